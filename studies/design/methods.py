"""Methods of a study: how the trials of a condition are adjusted. Every method sees the same trials."""

from __future__ import annotations

import itertools
from collections.abc import Mapping
from dataclasses import dataclass, field, fields
from typing import Any

from adjust import ap_models
from adjust.ap_models import MODELS, ApModel
from simfield.block import nearest, shown
from studies.design.factors import canonical_text
from studies.design.study import Study

MODEL_SETTINGS: Mapping[str, tuple[str, ...]] = {model.id: tuple(f.name for f in fields(model)) for model in MODELS}
"""the settings that each AP model of the catalogue takes"""
KEYS = ("ap", "cameras", "aux_points", "image_um", "control_mm")
ALL = "all"


@dataclass(frozen=True)
class Method:
    """How a trial is adjusted.

    model and settings: the AP model; cameras: those of the block ("all", or ids joined by +); aux_points: with
    auxiliary points; image_um: the standard deviation that the adjustment is told, one or one a camera, um (None: the
    scenario's); control_mm: that of the control, 0 for fixed, mm (None: the scenario's).
    """

    model: str
    settings: Mapping[str, Any] = field(default_factory=dict)
    cameras: str = ALL
    aux_points: bool = True
    image_um: float | Mapping[str, float] | None = None
    control_mm: float | None = None

    @property
    def columns(self) -> dict[str, str | bool]:
        """The method as columns of a table."""
        return {
            "ap": " ".join([self.model, *(f"{k}={_shown(v)}" for k, v in self.settings.items())]),
            "cameras": self.cameras,
            "aux_points": self.aux_points,
            "image_um": "scenario" if self.image_um is None else _shown(self.image_um),
            "control_mm": "scenario" if self.control_mm is None else _shown(self.control_mm),
        }

    @property
    def key(self) -> str:
        """The method in one line, unlike that of any other."""
        named = self.columns
        parts = [str(named["ap"]), f"cameras {named['cameras']}", "with aux" if self.aux_points else "without aux"]
        parts += [f"{k} {named[k]}" for k in ("image_um", "control_mm") if named[k] != "scenario"]
        return ", ".join(parts)

    def ap_model(self) -> ApModel:
        """Raises KeyError, TypeError or ValueError for a model or setting that is not allowed."""
        return ap_models.get(self.model, **dict(self.settings))


def _setting(name: str, value: Any) -> Any:
    return tuple(value) if isinstance(value, list) else float(value) if name.endswith("_mm") else value


def _shown(value: Any) -> str:
    if isinstance(value, tuple):
        return ",".join(value)
    if isinstance(value, Mapping):
        return "+".join(f"{k}:{v:g}" for k, v in sorted(value.items()))
    return (
        str(value).lower()
        if isinstance(value, bool)
        else f"{value:g}"
        if isinstance(value, float | int)
        else str(value)
    )


def methods_of(study: Study) -> tuple[Method, ...]:
    """The crossed methods of a study without faults, in the order of its file."""
    given = {key: study.methods[key] for key in KEYS if key in study.methods}
    return tuple(method_of(dict(zip(given, levels, strict=True))) for levels in itertools.product(*given.values()))


def method_of(levels: Mapping[str, Any]) -> Method:
    """One method from one level of every key."""
    ap = levels["ap"]
    settings = {} if isinstance(ap, str) else {k: v for k, v in ap.items() if k != "id"}
    return Method(
        model=ap if isinstance(ap, str) else ap["id"],
        settings={k: _setting(k, v) for k, v in settings.items()},
        cameras=levels.get("cameras", ALL),
        aux_points=levels.get("aux_points", True),
        image_um=levels.get("image_um"),
        control_mm=levels.get("control_mm"),
    )


def references(study: Study) -> dict[str, str]:
    """For the key of every method that of the method it is compared with, itself left out."""
    given = {key: study.methods[key] for key in KEYS if key in study.methods}
    against = dict(study.paired.against) or {"ap": given["ap"][0]}
    found = {}
    for levels in itertools.product(*given.values()):
        chosen = dict(zip(given, levels, strict=True))
        method, reference = method_of(chosen), method_of({**chosen, **against})
        if method != reference:
            found[method.key] = reference.key
    return found


def method_faults(study: Study, camera_ids: tuple[str, ...] | None) -> list[str]:
    """A line for each fault of [methods]; camera ids are compared with these, None where they are not known."""
    faults = [f"methods.{key}: unknown key{nearest(key, KEYS)}" for key in study.methods if key not in KEYS]
    if not study.methods.get("ap"):
        faults.append("methods.ap: is missing; a list of AP models, `simfield models` names them")
    for key in KEYS:
        levels = study.methods.get(key, ())
        if key in study.methods and not levels:
            faults.append(f"methods.{key}: found [], allowed: at least one level")
        seen: list[str] = []
        for number, level in enumerate(levels):
            place = f"methods.{key}[{number}]"
            faults += [f"{place}{line}" for line in _level_faults(key, level, camera_ids)]
            if canonical_text(level) in seen:
                faults.append(f"{place}: {shown(level)} stands there twice")
            seen.append(canonical_text(level))
    return faults


def _level_faults(key: str, level: Any, camera_ids: tuple[str, ...] | None) -> list[str]:
    if key == "ap":
        return _ap_faults(level)
    if key == "aux_points":
        return [] if isinstance(level, bool) else [f": found {shown(level)}, allowed: true or false"]
    if key == "cameras":
        if not isinstance(level, str):
            return [f': found {shown(level)}, allowed: "all" or camera ids joined by +']
        if camera_ids is None:
            return []
        unknown = [c for c in level.split("+") if level != ALL and c not in camera_ids]
        return [f": no camera {c!r}{nearest(c, camera_ids)}" for c in unknown]
    if key == "image_um" and isinstance(level, Mapping):
        if camera_ids is None:
            return []
        if set(level) != set(camera_ids) or not all(_is_positive(v) for v in level.values()):
            return [f": found {shown(level)}, allowed: a number > 0 for each of {', '.join(camera_ids)}"]
        return []
    if key == "control_mm":
        return [] if level == 0 or _is_positive(level) else [f": found {shown(level)}, allowed: a number >= 0"]
    return [] if _is_positive(level) else [f": found {shown(level)}, allowed: a number > 0"]


def _ap_faults(level: Any) -> list[str]:
    model = level.get("id") if isinstance(level, Mapping) else level
    if not isinstance(model, str):
        return [f': found {shown(level)}, allowed: the id of an AP model or {{id = "optical", r0_mm = 90}}']
    if ":" in model:  # a set of the user's own, which is not loaded before it is used
        return []
    if model not in MODEL_SETTINGS:
        return [f": no AP model {model!r}{nearest(model, MODEL_SETTINGS)}"]
    if not isinstance(level, Mapping):
        return []
    faults = []
    for name, value in level.items():
        if name != "id" and name not in MODEL_SETTINGS[model]:
            allowed = nearest(name, MODEL_SETTINGS[model]) if MODEL_SETTINGS[model] else "; it has none"
            faults.append(f".{name}: unknown setting of {model}{allowed}")
        elif name == "without":
            if not isinstance(value, list | tuple) or not all(isinstance(v, str) for v in value):
                faults.append(f".{name}: found {shown(value)}, allowed: a list of parameters")
        elif name != "id" and (
            isinstance(value, bool) != name.endswith("printed") or not isinstance(value, int | float)
        ):
            faults.append(
                f".{name}: found {shown(value)}, allowed: {'true or false' if 'printed' in name else 'a number'}"
            )
    return faults


def _is_positive(value: Any) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool) and value > 0
