"""What the paper says in words, beside what comes out here: a value, its range, and whether the claim is reached.

Correlations hang on the geometry alone, so their range is over geometries (other deviations of the flights, other
omitted points); crest and corner vectors are of one flight in the paper, so theirs is over flights. A claim is reached
where the figure as printed, with what was rounded off, lies in the range.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass

import numpy as np
import pandas as pd

from adjust import Replicates, adjust_replicates, ap_models
from simfield import Truth, World
from simfield.block import Block, Floats
from studies.comparison import CREST_RADII_MM, DECENTERING, RADIAL, VectorField, crest, format_grid
from studies.experiments.mauelshagen_1980.claims import mean_with_z0
from studies.experiments.mauelshagen_1980.experiment import BOTH, CAMERAS, adjusted, middle_images, sub_block
from studies.experiments.mauelshagen_1980.trials import places
from studies.summary import quantile_error

COLUMNS = (
    "claim", "model", "r0_mm", "aux_points", "camera", "images", "quantity", "published", "simulated", "low", "high",
    "low_mcse", "high_mcse", "over", "n", "reached",
)  # fmt: skip
FORMATS = {"r0_mm": "g", "simulated": ".3f", "low": ".3f", "high": ".3f", "low_mcse": ".3f", "high_mcse": ".3f"}
A3_A4, Z0_CLAIM, CREST = "a3 and a4", "Z0 and a3, a4", "crest and corners"
MODELS = ("optical", "torlegard", "brown14")
BETWEEN = (0.025, 0.975)
"""quantiles that bound a range over flights"""


@dataclass(frozen=True)
class Said:
    """A figure as printed, and the bounds that it stands for."""

    printed: str
    low: float
    high: float

    def reached(self, low: float, high: float) -> str:
        """Whether a range meets the figure."""
        return "yes" if low <= self.high and high >= self.low else "no"


CORRELATION = {False: Said("-0.92", -0.925, -0.915), True: Said("-0.82", -0.825, -0.815)}
WITH_Z0 = {0.0: Said("0.80 to 0.85", 0.80, 0.85), 100.0: Said("almost none", 0.0, 0.25)}
"""'fast keine Korrelation' is read as a quarter at most"""
RISE_UM = {"torlegard": Said("1.0", 0.95, 1.05), "brown14": Said("1.5", 1.45, 1.55)}
LONGER = {
    ("torlegard", "ww"): Said("-10", -12.5, -7.5),
    ("brown14", "ww"): Said("-15", -17.5, -12.5),
    ("torlegard", "sww"): Said("0", -2.5, 2.5),
    ("brown14", "sww"): Said("20", 17.5, 22.5),
}
"""per cent, printed in steps of five"""
Key = tuple[str, str, float, bool, str, str, str]
"""claim, model, r0_mm, aux_points, camera, images, quantity"""


def verdicts(world: World, geometries: Iterable[World], trials: int) -> pd.DataFrame:
    """The claims as one table; geometries are worlds of the same scenario and other seeds."""
    lines = [*_over_geometries([world, *geometries]), *_over_flights(world, trials)]
    return pd.DataFrame(lines, columns=list(COLUMNS))


def _over_geometries(worlds: list[World]) -> Iterator[tuple[object, ...]]:
    values = [dict(_correlations(*w.observe(0))) for w in worlds]
    for key in values[0]:
        said = CORRELATION[key[3]] if key[0] == A3_A4 else WITH_Z0[key[2]]
        found = np.array([each[key] for each in values])
        low, high = float(found.min()), float(found.max())
        # the range is that of all geometries looked at, so its ends have no sampling error to state
        ends = (low, high, float("nan"), float("nan"))
        yield (*key, said.printed, float(found.mean()), *ends, "geometries", len(found), said.reached(low, high))


def _correlations(block: Block, truth: Truth) -> Iterator[tuple[Key, float]]:
    for model in MODELS[:2]:
        for aux in (False, True):
            a = adjusted(sub_block(block, truth, BOTH, aux), model)
            for camera in CAMERAS:
                r = float(a.correlation((camera, "a3"), (camera, "a4"))[0, 1])
                yield (A3_A4, model, 100.0, aux, camera, "-", "R(a3,a4)"), r
    for aux in (False, True):
        part = sub_block(block, truth, BOTH, aux)
        for r0 in WITH_Z0:
            a = adjusted(part, ap_models.get("optical", r0_mm=r0))
            for camera in CAMERAS:
                own = [i for i, c in zip(truth.image_ids, truth.camera_ids, strict=True) if c == camera]
                for kind, images in (("all", own), ("middle", middle_images(truth, camera))):
                    for name in ("a3", "a4"):
                        key = (Z0_CLAIM, "optical", r0, aux, camera, kind, f"mean abs R(Z0,{name})")
                        yield key, mean_with_z0(a, camera, images, name)


def _over_flights(world: World, trials: int) -> Iterator[tuple[object, ...]]:
    """Crest of the radial curve and longest corner vector, as changes against model 3.1 on the same flights."""
    block, truth = world.observe(0)
    part = sub_block(block, truth, BOTH, True)
    observations, points = places(part, block)
    given = np.stack([world.given_coordinates(trial)[points] for trial in range(trials)])
    draws = world.draws(0, trials).only(observations)
    flown = {m: adjust_replicates(part, ap_models.get(m), draws, coordinates=given) for m in MODELS}
    both = np.all([r.ok for r in flown.values()], axis=0)
    for camera in CAMERAS:
        crests = {m: _crests(r, camera)[both] for m, r in flown.items()}
        corners = {m: _corners(r, camera)[both] for m, r in flown.items()}
        changes: Mapping[str, tuple[str, Mapping[str, Floats]]] = {
            "rise": ("rise of the crest, um", {m: crests[m] - crests["optical"] for m in RISE_UM}),
            "longer": (
                "corner vector longer by, %",
                {m: 100.0 * (corners[m] / corners["optical"] - 1.0) for m in RISE_UM},
            ),
        }
        for kind, (quantity, by_model) in changes.items():
            for model, found in by_model.items():
                said = RISE_UM[model] if kind == "rise" else LONGER[model, camera]
                low, high = (float(v) for v in np.quantile(found, BETWEEN))
                key: Key = (CREST, model, 100.0, True, camera, "-", quantity)
                yield (
                    *key,
                    said.printed,
                    float(found.mean()),
                    low,
                    high,
                    *(quantile_error(found, share) for share in BETWEEN),
                    "flights",
                    len(found),
                    said.reached(low, high),
                )


def _crests(r: Replicates, camera: str) -> Floats:
    """(t) um: the extreme values of the radial curves between the centre and their second zero."""
    model = next(s.model for s in r.nominal.layout.sets if s.id == camera)
    columns = [model.parameters.index(name) for name in RADIAL[model.id]]
    terms = 1000.0 * model.basis(CREST_RADII_MM, np.zeros_like(CREST_RADII_MM))[:, 0, columns]
    curves = r.ap(camera)[:, columns] @ terms.T
    return np.array([crest(CREST_RADII_MM, curve, float(model.settings["r0_mm"])) for curve in curves])


def _corners(r: Replicates, camera: str) -> Floats:
    """(t) um: the longest vectors of decentering distortion in a corner of the grid."""
    model = next(s.model for s in r.nominal.layout.sets if s.id == camera)
    columns = [model.parameters.index(name) for name in DECENTERING[model.id]]
    xy = format_grid()
    vectors = 1000.0 * np.einsum("nca,ta->tnc", model.basis(*xy.T)[:, :, columns], r.ap(camera)[:, columns])
    return np.array([VectorField(xy, each).corner_um for each in vectors])


def reached(table: pd.DataFrame) -> tuple[int, int]:
    """How many claims are reached, and how many there are."""
    return int((table["reached"] == "yes").sum()), len(table)
