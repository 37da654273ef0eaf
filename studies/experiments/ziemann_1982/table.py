"""The table of the paper beside the simulated one, and how well the sets' orders agree."""

from __future__ import annotations

import numpy as np
import pandas as pd

from simfield.block import Floats
from studies.experiments import published
from studies.experiments.reproduction import ReproductionError
from studies.experiments.ziemann_1982.experiment import CAMERAS, OTHERS, SETS, Case, cases
from studies.experiments.ziemann_1982.reseau import LEVELS
from studies.summary import bootstrap_error, mean_error
from studies.texts import markdown

FORMATS = {
    "published_um": ".1f",
    "sim_um": ".3f",
    "sim_mcse_um": ".3f",
    "gain_um": ".3f",
    "gain_mcse_um": ".3f",
}
RANK_FORMATS = {"spearman": ".2f", "spearman_mcse": ".2f"}
FEWEST_RANKED = 5


def table(trials: pd.DataFrame) -> pd.DataFrame:
    """A row for each case, level and set of the paper, without the system's distortion removed.

    sim_um is the mean over the trials of each trial's rms, sim_mcse_um its standard error; gain_um is by how much the
    set is better than none, from pairs of the same trial. n trials entered, `failures` did not. Raises
    ReproductionError where all trials of a row failed.
    """
    paper = published.ziemann_el_hakim()
    rows = []
    for case in cases():
        for level in LEVELS:
            same = (paper["camera"] == CAMERAS[case.camera]) & (paper["field"] == case.field)
            printed = paper[same & (paper["level"] == level)].iloc[0]
            doubtful = str(printed["doubtful"]).split() if isinstance(printed["doubtful"], str) else []
            for letter, model in SETS.items():
                given = {"published_um": float(printed[letter]), "doubtful": letter in doubtful}
                simulated = _summary(trials, case, (level, False), model)
                rows.append({**_head(case, level), "set": letter, "model": model, **given, **simulated})
    return pd.DataFrame(rows)


def beyond(trials: pd.DataFrame) -> pd.DataFrame:
    """What the paper does not have: other sets at the highest level, and all with the system's distortion removed."""
    rows = []
    for case in cases():
        for model in OTHERS:
            found = _summary(trials, case, (max(LEVELS), False), model)
            rows.append({**_head(case, max(LEVELS)), "system": False, "model": model, **found})
        for level in (min(LEVELS), max(LEVELS)):
            for model in SETS.values():
                found = _summary(trials, case, (level, True), model)
                rows.append({**_head(case, level), "system": True, "model": model, **found})
    return pd.DataFrame(rows)


def _head(case: Case, level: int) -> dict[str, object]:
    return {"camera": case.camera, "field": case.field, "level": level}


def _summary(trials: pd.DataFrame, case: Case, how: tuple[int, bool], model: str) -> dict[str, float]:
    mine = trials[
        (trials["camera"] == case.camera)
        & (trials["field"] == case.field)
        & (trials["level"] == how[0])
        & (trials["system"] == how[1])
    ]
    values = mine[mine["model"] == model].set_index("trial")["rms_um"]
    reference = mine[mine["model"] == "none"].set_index("trial")["rms_um"]
    good = values.dropna()
    if good.empty:
        raise ReproductionError(f"{case}, level {how[0]}: all {len(values)} trials of {model} failed")
    gain = (reference - values).dropna()
    return {
        "sim_um": float(good.mean()),
        "sim_mcse_um": mean_error(good.to_numpy(float)),
        "gain_um": float(gain.mean()),
        "gain_mcse_um": mean_error(gain.to_numpy(float)),
        "n": len(good),
        "failures": len(values) - len(good),
    }


def rank_correlations(found: pd.DataFrame, trials: pd.DataFrame) -> pd.DataFrame:
    """Spearman's correlation of the sets' order with the published one, for each case and level, and of the means.

    found: as `table` gives it for these trials; spearman_mcse: the standard error over flights, resampled. Equal
    figures share their rank; sets whose figure is not readable are left out, and levels with fewer than FEWEST_RANKED;
    "mean" is the mean over the levels at which all sets are readable.
    """
    rows = []
    for case in cases():
        own = found[(found["camera"] == case.camera) & (found["field"] == case.field)]
        paper = own.pivot_table(index="level", columns="set", values="published_um", dropna=False)
        flown = _flown(trials, case, list(paper.index), list(paper.columns))
        whole = paper.notna().all(axis=1).to_numpy()
        levels = {str(level): np.arange(len(paper)) == number for number, level in enumerate(paper.index)}
        for level, used in (levels | {"mean": whole}).items():
            published_um = paper.to_numpy(float)[used].mean(axis=0)
            known = np.isfinite(published_um)

            def agreement(simulated: Floats, one: Floats = published_um[known]) -> float:
                return spearman(one, simulated.mean(axis=0))

            if known.sum() >= FEWEST_RANKED:
                values = flown[:, used][:, :, known]
                figure, error = agreement(np.nanmean(values, axis=0)), bootstrap_error(values, agreement)
                rows.append((case.camera, case.field, level, int(known.sum()), figure, error))
    return pd.DataFrame(rows, columns=["camera", "field", "level", "sets", "spearman", "spearman_mcse"])


def _flown(trials: pd.DataFrame, case: Case, levels: list[int], sets: list[str]) -> Floats:
    """(t, levels, sets) um: the rms of every trial, NaN where it failed."""
    mine = trials[(trials["camera"] == case.camera) & (trials["field"] == case.field) & ~trials["system"]]
    wide = mine.pivot_table(index="trial", columns=["level", "model"], values="rms_um", dropna=False)
    return np.stack([wide[level][[SETS[letter] for letter in sets]].to_numpy(float) for level in levels], axis=1)


def spearman(one: Floats, other: Floats) -> float:
    """Spearman's rank correlation; equal values share their mean rank."""
    first, second = (pd.Series(np.round(values, 9)).rank().to_numpy(float) for values in (one, other))
    return float(np.corrcoef(first, second)[0, 1])


def case_markdown(found: pd.DataFrame, case: Case) -> str:
    """The rows of one case: levels down, sets across, each cell published / simulated."""
    own = found[(found["camera"] == case.camera) & (found["field"] == case.field)]
    lines = []
    for level, name in LEVELS.items():
        line = {"level": f"{level} {name}"}
        for letter in SETS:
            row = own[(own["level"] == level) & (own["set"] == letter)].iloc[0]
            printed = (
                "?" if np.isnan(row["published_um"]) else f"{row['published_um']:.1f}{'?' if row['doubtful'] else ''}"
            )
            line[letter] = f"{printed} / {row['sim_um']:.2f}"
        lines.append(line)
    return markdown(pd.DataFrame(lines))


def order(found: pd.DataFrame, case: Case, column: str) -> str:
    """The sets from the best to the worst, by their mean over the levels at which all are readable."""
    own = found[(found["camera"] == case.camera) & (found["field"] == case.field)]
    whole = own.groupby("level")["published_um"].transform(lambda v: v.notna().all())
    mean = own[whole].groupby("set")[column].mean().sort_values(kind="stable")
    return ", ".join(str(name) for name in mean.index)
