"""A choice of words that are declared where they are used, and loaded only when one is given or help is asked for."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import Any

import click


class LateChoice(click.ParamType[str]):
    """As click.Choice, of the words that `load` returns."""

    name = "choice"

    def __init__(self, load: Callable[[], Sequence[str]]) -> None:
        self.load = load

    def get_metavar(self, param: click.Parameter, ctx: click.Context) -> str:
        return f"[{'|'.join(self.load())}]"

    def convert(self, value: Any, param: click.Parameter | None, ctx: click.Context | None) -> str:
        return str(click.Choice(self.load()).convert(value, param, ctx))

    def shell_complete(self, ctx: click.Context, param: click.Parameter, incomplete: str) -> list[Any]:
        return list(click.Choice(self.load()).shell_complete(ctx, param, incomplete))
