"""Table 1 of the paper: unknowns, redundancy, m0 and mu of 18 adjustments, as published and as simulated."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd

from studies.experiments import published
from studies.experiments.mauelshagen_1980.experiment import Row
from studies.experiments.mauelshagen_1980.trials import COUNTS, MEASURES
from studies.experiments.reproduction import ReproductionError
from studies.summary import mean_error, quantile_error
from studies.texts import DASH, markdown

FORMATS = {"m0_um": ".1f"} | {
    f"sim_{measure}{part}": ".3f" if measure == "m0_um" else ".2f"
    for measure in MEASURES
    for part in ("", "_mcse", "_lo", "_hi", "_lo_mcse", "_hi_mcse")
}
RANGE = (2.5, 97.5)
"""percentiles between which 95 % of the trials lie"""


def table1(rows: Sequence[Row], trials: pd.DataFrame) -> pd.DataFrame:
    """The published table with the simulated figures behind it.

    A simulated figure is the mean over the trials of each trial's own rms (not the rms of all trials together: the
    paper reports one flight); _mcse is the standard error of this mean, _lo and _hi enclose 95 % of the trials and have
    standard errors of their own, _lo_mcse and _hi_mcse. n trials entered, `failures` did not. Raises ReproductionError
    where all trials of a row failed.
    """
    simulated = [_summary(row, trials[trials["row"] == number]) for number, row in enumerate(rows)]
    return pd.concat([published.mauelshagen_table1(), pd.DataFrame(simulated)], axis=1)


def _summary(row: Row, trials: pd.DataFrame) -> dict[str, float]:
    done = trials[trials["failure"] == ""]
    if done.empty:
        raise ReproductionError(f"all {len(trials)} trials failed ({row}): {trials['failure'].iloc[0]}")
    summary: dict[str, float] = {f"sim_{name}": int(done[name].iloc[0]) for name in COUNTS}
    for name in MEASURES:
        values = done[name].to_numpy(float)
        lo, hi = np.percentile(values, RANGE)
        summary |= {
            f"sim_{name}": float(values.mean()),
            f"sim_{name}_mcse": mean_error(values),
            f"sim_{name}_lo": float(lo),
            f"sim_{name}_hi": float(hi),
            f"sim_{name}_lo_mcse": quantile_error(values, RANGE[0] / 100.0),
            f"sim_{name}_hi_mcse": quantile_error(values, RANGE[1] / 100.0),
        }
    return summary | {"n": len(done), "failures": len(trials) - len(done)}


def table1_markdown(table: pd.DataFrame) -> str:
    """The table for readers: each published figure, then the simulated one with the range of 95 % of the trials."""
    shown = pd.DataFrame(
        {
            "model": table["model"],
            "block": table["block"],
            "aux points": ["with" if aux else "without" for aux in table["aux_points"]],
            "unknowns": _pairs(table, "unknowns"),
            "redundancy": _pairs(table, "redundancy"),
            "m0 um": table["m0_um"],
            "simulated": _ranges(table, "m0_um", 1),
            "mu_xy mm": table["mu_xy_mm"],
            "simulated 2-D": _ranges(table, "mu_xy_mm", 0),
            "simulated, one coordinate": _ranges(table, "mu_xy_coordinate_mm", 0),
            "mu_z mm": table["mu_z_mm"],
            "simulated ": _ranges(table, "mu_z_mm", 0),
        }
    )
    return markdown(shown, {"m0 um": ".1f"})


def errors_markdown(table: pd.DataFrame) -> str:
    """The means over trials with their Monte-Carlo standard errors, n and failures."""
    names = {"m0_um": ("m0 um", 4), "mu_xy_mm": ("mu_xy 2-D mm", 2), "mu_z_mm": ("mu_z mm", 2)}
    means = {
        title: [
            f"{m:.{digits}f} ± {e:.{digits}f}" for m, e in table[[f"sim_{name}", f"sim_{name}_mcse"]].to_numpy(float)
        ]
        for name, (title, digits) in names.items()
    }
    head = table[["model", "block"]].assign(**{"aux points": table["aux_points"].map({False: "without", True: "with"})})
    return markdown(pd.concat([head.assign(**means), table[["n", "failures"]]], axis=1))


def failures(rows: Sequence[Row], trials: pd.DataFrame) -> list[str]:
    """A line for each adjustment of a trial that failed."""
    failed = trials[trials["failure"] != ""]
    return [f"trial {t}, {rows[r]}: {why}" for t, r, why in failed[["trial", "row", "failure"]].to_numpy().tolist()]


def _pairs(table: pd.DataFrame, name: str) -> list[str]:
    """Published, and the simulated count only where it differs."""
    pairs = zip(table[name], table[f"sim_{name}"], strict=True)
    return [f"{a}" if a == b else f"{a}, simulated {b}" for a, b in pairs]


def _ranges(table: pd.DataFrame, name: str, digits: int) -> list[str]:
    columns = (table[f"sim_{name}{part}"] for part in ("", "_lo", "_hi"))
    return [f"{m:.{digits}f} ({lo:.{digits}f}{DASH}{hi:.{digits}f})" for m, lo, hi in zip(*columns, strict=True)]
