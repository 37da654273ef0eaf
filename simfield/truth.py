"""The truth behind a simulated block. Only the comparison of truth and estimate may read it."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from simfield.block import Floats, Indices
from simfield.disturbances import EFFECTS, EffectOn, by_kind
from simfield.files import TRUTH_FILE, settle, write_whole

ARRAYS: Mapping[str, type[Any]] = {
    "exterior": np.float64,
    "coordinates": np.float64,
    "central": np.bool_,
    "image": np.intp,
    "point": np.intp,
    "ideal": np.float64,
    "undisturbed": np.float64,
    "noise_sigma": np.float64,
}


@dataclass(frozen=True, eq=False)
class Truth:
    """What really was, in the order of the block's images (m), points (n) and observations (k).

    exterior (m, 6) in metres and radians; coordinates (n, 3) in metres; group (n) the group's id, central (n) its
    central point; main_points the points used "without auxiliary points"; ideal (k, 2) without distortion and noise,
    undisturbed (k, 2) with distortion and without noise, noise_sigma (k) the true standard deviation of a coordinate,
    all in mm.
    """

    scenario: str
    seed: int
    trial: int
    image_ids: tuple[str, ...]
    flight_ids: tuple[str, ...]
    strip_ids: tuple[str, ...]
    camera_ids: tuple[str, ...]
    exterior: Floats
    point_ids: tuple[str, ...]
    group: tuple[str, ...]
    central: npt.NDArray[np.bool_]
    coordinates: Floats
    main_points: tuple[str, ...]
    image: Indices
    point: Indices
    ideal: Floats
    undisturbed: Floats
    noise_sigma: Floats
    effects: tuple[EffectOn, ...]

    def __post_init__(self) -> None:
        for name, dtype in ARRAYS.items():
            array = np.array(getattr(self, name), dtype=dtype)
            array.flags.writeable = False
            object.__setattr__(self, name, array)

    def distortion(self, image_id: str, xy_mm: Floats) -> Floats:
        """(n, 2) mm: the true d(measured) in an image at measured coordinates (n, 2) mm.

        Raises KeyError for an image that there is not.
        """
        if image_id not in self.image_ids:
            raise KeyError(f"no image named {image_id!r}")
        row = self.image_ids.index(image_id)
        return self._sum(self.camera_ids[row], self.flight_ids[row], image_id, np.asarray(xy_mm, dtype=float))

    def camera_distortion(self, camera_id: str, xy_mm: Floats) -> Floats:
        """(n, 2) mm: the true d that all images of a camera have. Raises KeyError for an unknown camera."""
        if camera_id not in self.camera_ids:
            raise KeyError(f"no camera named {camera_id!r}")
        return self._sum(camera_id, "", "", np.asarray(xy_mm, dtype=float))

    def _sum(self, camera_id: str, flight_id: str, image_id: str, xy: Floats) -> Floats:
        acting = (on.effect.displacement(xy) for on in self.effects if on.acts_on(camera_id, flight_id, image_id))
        return np.asarray(sum(acting, start=np.zeros_like(xy)))

    def to_json(self) -> str:
        """The truth as JSON. Raises ValueError for an effect that is none of simfield.disturbances.effects."""
        plain: dict[str, Any] = {}
        for f in fields(self):
            value = getattr(self, f.name)
            plain[f.name] = value.tolist() if isinstance(value, np.ndarray) else value
        plain["effects"] = [_effect_as_table(on) for on in self.effects]
        return json.dumps(plain, allow_nan=False) + "\n"

    @staticmethod
    def from_json(text: str) -> Truth:
        """The truth from its JSON. Raises ValueError or KeyError where the text is not one of to_json."""
        plain = json.loads(text)
        for name, value in plain.items():
            if isinstance(value, list) and name not in ARRAYS and name != "effects":
                plain[name] = tuple(value)
        plain["effects"] = tuple(_effect_from_table(table) for table in plain["effects"])
        return Truth(**plain)


def write_truth(truth: Truth, path: Path | str) -> None:
    """Write truth.json, at the path or into the folder that it names.

    Raises OSError where it cannot be written, ValueError for an effect that is none of simfield.disturbances.effects.
    """
    path = Path(path)
    write_whole(path / TRUTH_FILE if path.is_dir() else path, truth.to_json().encode())


def read_truth(path: Path | str) -> Truth:
    """Read truth.json, at the path or from the folder that it names.

    Raises OSError if there is none, ValueError or KeyError where it is not one that `write_truth` wrote.
    """
    path = Path(path)
    if path.is_dir():
        settle(path)
        path /= TRUTH_FILE
    return Truth.from_json(path.read_text(encoding="utf-8"))


def _effect_as_table(on: EffectOn) -> dict[str, Any]:
    if not isinstance(on.effect, EFFECTS):
        raise ValueError(
            f"{type(on.effect).__name__} is no effect of simfield.disturbances.effects, truth.json cannot hold it"
        )
    return asdict(on)


def _effect_from_table(table: Mapping[str, Any]) -> EffectOn:
    values = {k: tuple(v) if isinstance(v, list) else v for k, v in table["effect"].items()}
    return EffectOn(**{**table, "effect": by_kind(EFFECTS)[table["effect"]["kind"]](**values)})
