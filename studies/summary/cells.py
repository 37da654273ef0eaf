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
from studies.store import (
    ANGLES,
    BEFORE,
    CONSTANTS,
    CONVERGED,
    CRASHED,
    DEVIATIONS,
    METRES,
    TRIAL,
    Columns,
    unit_of_unknown,
)
from studies.summary import performance
from studies.summary.performance import Measured

UNITS = {column.name: column.unit for column in TRIAL}
RELATIVE = ("model_se_error", "coverage")


@dataclass(frozen=True, eq=False)
class Cell:
    """The trials of a cell: status (n), deviations and tracked estimates of those that converged, and the nominal side.

    names are the tracked unknowns; error (m, q) are estimate - estimand and std (m, q) the claimed standard errors of
    the m trials that converged, estimand (q), kept (n) says which trials these are; formal (q, q) are the formal
    correlations; left_out names columns that not all shards have, or that this version does not know.
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
    left_out: tuple[str, ...] = ()

    @classmethod
    def of(cls, key: str, trials: Columns, nominal: Columns) -> Cell:
        """A cell from the columns of its shards, joined, and of its nominal shard."""
        own, fixed = _of_method(key, trials), _of_method(key, nominal)
        status = own.pop("status", np.zeros(0, dtype=np.int8))
        kept = status == CONVERGED
        constants = dict(zip(CONSTANTS, fixed.pop("constants", np.empty(0)).tolist(), strict=False))
        names = tuple(name for name in own if name in fixed)
        some = bool(kept.any())
        deviations = {d: own[d][kept] if d in own else np.empty(0) for d in DEVIATIONS if d in own or not some}
        if not names:  # such as where no trial could be adjusted
            error = std = np.empty((int(kept.sum()), 0))
            formal, estimand = np.empty((0, 0)), np.empty(0)
        else:
            table = np.array([fixed[name] for name in names])
            row = {name: number for number, name in enumerate(fixed)}
            estimand, formal = table[:, 0], table[:, [2 + row[name] for name in names]]
            estimates = np.array([own[name] for name in names]).compress(kept, axis=1).T
            error = estimates - estimand
            m0 = deviations.get("m0_um", np.full(len(error), np.nan))
            std = (m0 / constants.get("unit_weight_um", np.nan))[:, None] * table[:, 1]
        lacking = [name for name in (*DEVIATIONS, *fixed) if name not in own]
        lacking += [name for name in CONSTANTS if name not in constants]
        unknown = [name for name in own if name not in DEVIATIONS and name not in fixed]
        left_out = tuple(lacking + unknown) if some else ()
        return cls(status, kept, deviations, names, error, std, formal, estimand, constants, left_out)

    @property
    def claims(self) -> bool:
        """Whether the standard errors that the method claims are known."""
        needed = [self.constants.get(name, np.nan) for name in ("redundancy", "unit_weight_um")]
        return "m0_um" in self.deviations and bool(np.isfinite(needed).all())

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


def _of_method(key: str, columns: Columns) -> Columns:
    head = key + BEFORE
    return {name.removeprefix(head): values for name, values in columns.items() if name.startswith(head)}


def measured(cell: Cell) -> dict[str, Measured]:
    """All measures of a cell but the correlations, by name; those of tracked unknowns are "bias ww.a3" and so on."""
    found: dict[str, Measured] = {}
    for name, values in cell.deviations.items():
        form = performance.share_coverage if name.startswith("coverage") else performance.mean
        if name in ("m0_um", "mean_z_mm") or np.isfinite(values).any() or not len(values):
            found[name] = form(values[:, None])
    found |= {name: performance.mean(values[:, None]) for name, values in _choice(cell).items()}
    if cell.names and len(cell.error):
        tables = _of_unknowns(cell)
        for number, name in enumerate(cell.names):
            for measure, table in tables.items():
                found[f"{measure} {name}"] = _column(table, number)
    return found


def _of_unknowns(cell: Cell) -> dict[str, Measured]:
    """The measures of tracked unknowns, a column an unknown; some need the standard errors that the method claims."""
    empirical = performance.empirical_se(cell.error)
    found = {"bias": performance.bias(cell.error), "emp_se": empirical}
    if cell.claims:
        model = performance.model_se(cell.std)
        found |= {"model_se": model, "model_se_error": performance.model_se_error(model, empirical)}
    found["rmse"] = performance.rmse(cell.error)
    return found | ({"coverage": performance.coverage(cell.inside)} if cell.claims else {})


def _choice(cell: Cell) -> dict[str, Floats]:
    """What one chooses a set of additional parameters by: by name, a value (m) for each trial.

    aic and bic as in adjust.quality.model_choice; significant, the number of parameters whose 95 % interval does not
    contain 0, of parameters; the other two belong to the noise-free adjustment.
    """
    if not len(cell.error) or not cell.claims or "observations" not in cell.constants:
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
    nominal = (*(("largest_ap_exterior",) if own else ()), "condition_number")
    return found | {name: np.full(len(fit), cell.constants[name]) for name in nominal if name in cell.constants}


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
        return UNITS.get(form, "1")
    return "1" if form in RELATIVE or "correlation" in form else unit_of_unknown(name)
