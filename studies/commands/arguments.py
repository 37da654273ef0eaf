"""Arguments that several commands have: folders, and a set of additional parameters with its settings."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

if TYPE_CHECKING:
    from adjust import ApModel


FOLDER = click.Path(file_okay=False, path_type=Path)
EXISTING = click.Path(exists=True, file_okay=False, path_type=Path)


def model_of(model_id: str, settings: tuple[str, ...]) -> ApModel:
    """The set with this id and these settings NAME=VALUE. Raises click.UsageError."""
    from adjust import ap_models

    try:
        types = ap_models.get(model_id).settings
        return ap_models.get(model_id, **dict(_setting(text, types) for text in settings))
    except (KeyError, TypeError, ValueError) as error:
        raise click.UsageError(str(error.args[0])) from error


def _setting(text: str, defaults: dict[str, Any]) -> tuple[str, Any]:
    """NAME=VALUE with the value in the type of the default; an unknown name is left to the model to refuse."""
    name, equals, value = (part.strip() for part in text.partition("="))
    if not equals or not name or not value:
        raise click.UsageError(f"--set {text}: needed is NAME=VALUE, such as r0_mm=100")
    default = defaults.get(name, value)
    if isinstance(default, bool):
        if value.lower() not in ("true", "false"):
            raise click.UsageError(f"--set {text}: {name} is true or false")
        return name, value.lower() == "true"
    if isinstance(default, tuple):
        return name, tuple(part.strip() for part in value.split(","))
    try:
        return name, type(default)(value)
    except ValueError as error:
        raise click.UsageError(f"--set {text}: {value!r} is no {type(default).__name__}") from error
