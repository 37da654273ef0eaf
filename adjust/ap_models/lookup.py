"""The catalogue of additional-parameter sets: `names()` lists the ids, `get(id, **settings)` makes one."""

from __future__ import annotations

import dataclasses
from typing import Any

from adjust.ap_models import catalogue
from adjust.ap_models.model import ApModel, Certainty
from adjust.ap_models.own import own_model
from simfield.block import nearest

MODELS: tuple[type[ApModel], ...] = (
    catalogue.NoModel,
    catalogue.Optical,
    catalogue.Torlegard,
    catalogue.Brown14,
    catalogue.Ebner12,
    catalogue.ElHakimFaig11,
    catalogue.Gruen12,
    catalogue.KoelblJuhl9,
    catalogue.Mauelshagen14,
    catalogue.Schut14,
    catalogue.SalmenperaKilpela7,
    catalogue.Gruen44,
    catalogue.Brown1971,
    catalogue.Brown1976,
    catalogue.Jacobsen12,
    catalogue.Legendre,
    catalogue.Fourier,
    catalogue.Chebyshev,
    catalogue.Zernike,
)


def names() -> tuple[str, ...]:
    """The ids of all sets."""
    return tuple(model.id for model in MODELS)


def get(model_id: str, **settings: Any) -> ApModel:
    """The set with this id and these settings; "file.py:Class" or "module:Class" names a set of the user's own.

    Raises KeyError for an unknown id and TypeError for an unknown setting, each with what is allowed.
    """
    kind = own_model(model_id) if ":" in model_id else _of_catalogue(model_id)
    allowed = [f.name for f in dataclasses.fields(kind)]
    for name in settings:
        if name not in allowed:
            raise TypeError(f"{model_id} has no setting {name!r}, it has: {', '.join(allowed) or 'none'}")
    return kind(**settings)


def _of_catalogue(model_id: str) -> type[ApModel]:
    for model in MODELS:
        if model.id == model_id:
            return model
    raise KeyError(f"no AP model {model_id!r}{nearest(model_id, names())}")


__all__ = ["MODELS", "ApModel", "Certainty", "get", "names"]
