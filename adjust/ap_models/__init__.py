"""The catalogue of additional-parameter sets: `names()` lists the ids, `get(id, **settings)` makes one."""

from __future__ import annotations

import dataclasses
from typing import Any

from adjust.ap_models.brown import Brown1971, Brown1976
from adjust.ap_models.ebner import Ebner12
from adjust.ap_models.elhakim_faig import ElHakimFaig11
from adjust.ap_models.fourier import Fourier
from adjust.ap_models.gruen import Gruen12, Gruen44
from adjust.ap_models.jacobsen import Jacobsen12
from adjust.ap_models.koelbl_juhl import KoelblJuhl9
from adjust.ap_models.mauelshagen import Brown14, Mauelshagen14, NoModel, Optical, Torlegard
from adjust.ap_models.model import ApModel, Certainty
from adjust.ap_models.own import own_model
from adjust.ap_models.products import Chebyshev, Legendre
from adjust.ap_models.salmenpera_kilpela import SalmenperaKilpela7
from adjust.ap_models.schut import Schut14
from adjust.ap_models.zernike import Zernike
from simfield.wording import nearest

MODELS: tuple[type[ApModel], ...] = (
    NoModel,
    Optical,
    Torlegard,
    Brown14,
    Ebner12,
    ElHakimFaig11,
    Gruen12,
    KoelblJuhl9,
    Mauelshagen14,
    Schut14,
    SalmenperaKilpela7,
    Gruen44,
    Brown1971,
    Brown1976,
    Jacobsen12,
    Legendre,
    Fourier,
    Chebyshev,
    Zernike,
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
