"""The results of one cell (a condition under a method) as rows: measure, unit, n, failures, estimate, mcse."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache

import numpy as np
import numpy.typing as npt
from scipy.special import stdtrit

from simfield.block import Floats
from studies.comparison import CONFIDENCE
from studies.store import BEFORE, Columns
from studies.summary import performance
from studies.summary.performance import Measured
from studies.trials import CONSTANTS, CONVERGED, CRASHED, DEVIATIONS

UNITS = {"m0_um": "um", "coverage_xy": "1", "coverage_z": "1"}
ANGLES = ("omega", "phi", "kappa")
METRES = ("X0", "Y0", "Z0", "X", "Y", "Z")
RELATIVE = ("model_se_error", "coverage")
OWN_UNIT = "mm-powers"
"""additional parameters: the unit that the term's power of mm asks for"""


@dataclass(frozen=True, eq=False)
class Cell:
    """The trials of a cell: status (n), deviations and tracked estimates of those that converged, and the nominal side.

    names are the tracked unknowns; error (m, q) are estimate - estimand and std (m, q) the claimed standard errors of
    the m trials that converged, estimand (q), kept (n) says which trials these are; formal (q, q) are the formal
    correlations.
    """

    status: npt.NDArray[np.int8]
    kept: npt.NDArray[np.bool_]
    deviations: Mapping[str, Floats]
    names: tuple[str, ...]
    error: Floats
    std: Floats
    formal: Floats
    estimand: Floats
    constants: Mapping[str, float]

    @classmethod
    def of(cls, key: str, trials: Columns, nominal: Columns) -> Cell:
        """A cell from the columns of its shards, joined, and of its nominal shard."""
        own = {name.removeprefix(key + BEFORE): v for name, v in trials.items() if name.startswith(key + BEFORE)}
        fixed = {name.removeprefix(key + BEFORE): v for name, v in nominal.items() if name.startswith(key + BEFORE)}
        status = own.pop("status", np.zeros(0, dtype=np.int8))
        kept = status == CONVERGED
        constants = dict(zip(CONSTANTS, fixed.pop("constants", np.full(len(CONSTANTS), np.nan)).tolist(), strict=False))
        if "m0_um" not in own:  # no trial of this cell could be adjusted
            none: Floats = np.empty((0, 0))
            return cls(status, kept, {d: np.empty(0) for d in DEVIATIONS}, (), none, none, none, np.empty(0), constants)
        names = tuple(name for name in own if name not in DEVIATIONS)
        table = np.array([fixed[name] for name in names]).reshape(len(names), -1)
        estimand, s, formal = table[:, 0], table[:, 1], table[:, 2 : 2 + len(names)]
        estimates = np.array([own[name] for name in names]).reshape(len(names), -1).compress(kept, axis=1).T
        sigma0 = own["m0_um"][kept] / constants["unit_weight_um"]
        deviations = {name: own[name][kept] for name in DEVIATIONS}
        return cls(
            status, kept, deviations, names, estimates - estimand, sigma0[:, None] * s, formal, estimand, constants
        )

    @property
    def failures(self) -> int:
        return int(np.sum(~self.kept))

    @property
    def lost(self) -> bool:
        """Whether the cell is no result: no trial converged, or some were lost to crashes or had no end."""
        return bool(len(self.status)) and (not self.kept.any() or bool(np.any(self.status >= CRASHED)))

    @property
    def inside(self) -> Floats:
        """(m, q) 1 where the 95 % interval of a tracked unknown contains its estimand."""
        t = stdtrit(self.constants["redundancy"], 0.5 + CONFIDENCE / 2.0)
        return np.asarray(np.abs(self.error) <= t * self.std, dtype=float)


def measured(cell: Cell) -> dict[str, Measured]:
    """All measures of a cell but the correlations, by name; those of tracked unknowns are "bias ww.a3" and so on."""
    found: dict[str, Measured] = {}
    for name, values in cell.deviations.items():
        form = performance.share_coverage if name.startswith("coverage") else performance.mean
        if name in ("m0_um", "mean_z_mm") or np.isfinite(values).any() or not len(values):
            found[name] = form(values[:, None])
    found |= {name: performance.mean(values[:, None]) for name, values in _choice(cell).items()}
    if cell.names and len(cell.error):
        empirical, model = performance.empirical_se(cell.error), performance.model_se(cell.std)
        tables = {
            "bias": performance.bias(cell.error),
            "emp_se": empirical,
            "model_se": model,
            "model_se_error": performance.model_se_error(model, empirical),
            "rmse": performance.rmse(cell.error),
            "coverage": performance.coverage(cell.inside),
        }
        for number, name in enumerate(cell.names):
            for measure, table in tables.items():
                found[f"{measure} {name}"] = _column(table, number)
    return found


def _choice(cell: Cell) -> dict[str, Floats]:
    """What one chooses a set of additional parameters by: by name, a value (m) for each trial.

    aic and bic as in adjust.quality.model_choice; significant, the number of parameters whose 95 % interval does not contain 0,
    of parameters; the other two belong to the noise-free adjustment.
    """
    if not len(cell.error) or "observations" not in cell.constants:
        return {}
    n, redundancy = cell.constants["observations"], cell.constants["redundancy"]
    unknowns = n - redundancy
    fit = n * np.log((cell.deviations["m0_um"] / cell.constants["unit_weight_um"]) ** 2 * redundancy / n)
    own = [number for number, name in enumerate(cell.names) if _is_parameter(name)]
    t = stdtrit(redundancy, 0.5 + CONFIDENCE / 2.0)
    found = {"aic": fit + 2.0 * unknowns, "bic": fit + unknowns * np.log(n)}
    if own:
        estimate = cell.error[:, own] + cell.estimand[own]
        found["parameters"] = np.full(len(fit), float(len(own)))
        found["significant"] = np.sum(np.abs(estimate) > t * cell.std[:, own], axis=1).astype(float)
        found["largest_ap_exterior"] = np.full(len(fit), cell.constants["largest_ap_exterior"])
    return {**found, "condition_number": np.full(len(fit), cell.constants["condition_number"])}


def correlated(cell: Cell, least: float) -> dict[str, tuple[float, Measured]]:
    """Formal and empirical correlation of additional parameters with each other and with Z0 of their camera's image.

    Only pairs whose formal correlation is at least `least`; the choice does not depend on the trials.
    """
    pairs = [(i, j) for i, j in _pairs(cell.names) if abs(cell.formal[i, j]) >= least]
    if not pairs or len(cell.error) == 0:
        return {}
    first, second = (np.array(side) for side in zip(*pairs, strict=True))
    found = performance.correlation(cell.error[:, first], cell.error[:, second])
    return {
        f"{cell.names[i]}~{cell.names[j]}": (float(cell.formal[i, j]), _column(found, number))
        for number, (i, j) in enumerate(pairs)
    }


def _pairs(names: tuple[str, ...]) -> list[tuple[int, int]]:
    wanted = [n for n, name in enumerate(names) if _is_parameter(name) or name.endswith(".Z0")]
    return [
        *((i, j) for place, i in enumerate(wanted) for j in wanted[place + 1 :]
          if names[i].split(".")[0] == names[j].split(".")[0]),
    ]  # fmt: skip


def _is_parameter(name: str) -> bool:
    return name.partition(".")[2] not in (*ANGLES, *METRES)


def _column(table: Measured, number: int) -> Measured:
    own = slice(number, number + 1)
    return Measured(table.estimate[own], table.mcse[own], table.influence[:, own])


@cache
def unit(measure: str) -> str:
    """The unit of a measure by its name."""
    form, _, name = measure.partition(" ")
    if not name:
        return UNITS.get(form, "mm" if form.endswith("_mm") else "1")
    if form in RELATIVE or "correlation" in form:
        return "1"
    last = name.partition(".")[2]
    return "rad" if last in ANGLES else "m" if last in METRES else OWN_UNIT
