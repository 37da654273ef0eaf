"""The catalogue of additional-parameter sets: `names()` lists the ids, `get(id, **settings)` makes one."""

from __future__ import annotations

import dataclasses
import difflib
from typing import Any

from adjust.ap_models.mauelshagen import Brown14, NoModel, Optical, Torlegard
from adjust.ap_models.model import ApModel, Certainty

MODELS: tuple[type[ApModel], ...] = (NoModel, Optical, Torlegard, Brown14)


def names() -> tuple[str, ...]:
    """The ids of all sets."""
    return tuple(model.id for model in MODELS)


def get(model_id: str, **settings: Any) -> ApModel:
    """The set with this id and these settings.

    Raises KeyError for an unknown id and TypeError for an unknown setting, each with what is allowed.
    """
    for model in MODELS:
        if model.id == model_id:
            allowed = [f.name for f in dataclasses.fields(model)]
            for name in settings:
                if name not in allowed:
                    raise TypeError(f"{model_id} has no setting {name!r}, it has: {', '.join(allowed) or 'none'}")
            return model(**settings)
    near = difflib.get_close_matches(model_id, names(), n=1)
    hint = f"did you mean {near[0]!r}?" if near else f"known are {', '.join(names())}"
    raise KeyError(f"no AP model {model_id!r}, {hint}")


__all__ = ["MODELS", "ApModel", "Certainty", "get", "names"]
