"""The report of the twin in Markdown. Every figure in it is read off the findings."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import pandas as pd

from studies.experiments.mauelshagen_1980 import table1_markdown
from studies.experiments.mauelshagen_1980_twin import fixed, variances
from studies.experiments.mauelshagen_1980_twin.findings import Twin, TwinFindings
from studies.summary import quantile_error
from studies.texts import markdown

SEPARABLE = 0.6
"""two components whose refitted variances are correlated below minus this are said not to be separable"""

INTRODUCTION = """# A twin of 1969

Two kinds of world in which Table 1 of Mauelshagen 1980 happens. They could have been; nothing here says that they were.

- The **random** world has variance components: image noise of each camera, film deformation (affinity in y; all affine,
  quadratic, cubic terms) that is drawn anew for a camera, a flight or an image, and geodetic error. Their sizes were
  fitted to all 54 published m0, mu_xy and mu_z at once, so agreement with the table is no evidence for them: it says
  that such a world is enough, not that it is needed.
- The **fixed** world has the same deformation in every trial and few terms.

mu_xy is read in two ways, as the 2-D point error and as the rms of one coordinate; every world is fitted for both.
"""


def report_page(found: TwinFindings, command: str) -> str:
    """The whole report."""
    parts = [INTRODUCTION, f"Made by `{command}`: {found.trials} whole experiments in each world.\n", _verdict(found)]
    for twin in found.twins.values():
        parts += list(_chapter(found, twin))
    parts += ["## One set of additional parameters a camera, a flight, a strip or an image?\n", _sets(found)]
    return "\n".join(parts)


def inside(table: pd.DataFrame, reading: str) -> int:
    """How many of the 54 published figures lie inside the simulated 95 % ranges."""
    return sum(
        int(((table[name] >= table[f"sim_{own}_lo"]) & (table[name] <= table[f"sim_{own}_hi"])).sum())
        for name, own in _columns(reading)
    )


def near(table: pd.DataFrame, reading: str) -> tuple[int, int]:
    """How many m0 lie within 0.4 um of the simulated mean, how many mu within 20 %."""
    m0, *mu = _columns(reading)
    close = (table[m0[0]] - table[f"sim_{m0[1]}"]).abs() <= fixed.M0_WITHIN_UM
    shares = [((table[a] - table[f"sim_{b}"]).abs() <= fixed.MU_WITHIN * table[a]).sum() for a, b in mu]
    return int(close.sum()), int(sum(shares))


def components_table(found: TwinFindings) -> pd.DataFrame:
    """Sizes of all components under both readings: first fit, refined fit, and the middle 68 % of the refits."""
    lines = []
    for twin in found.twins.values():
        lo, middle, hi = np.percentile(twin.refits, (16, 50, 84), axis=0)
        for number, component in enumerate(found.components):
            lines.append(
                {
                    "reading": twin.reading,
                    "component": str(component),
                    "unit": component.unit,
                    "first_fit": float(twin.fit.first[number]),
                    "size": float(twin.fit.sizes[number]),
                    "refit_16": float(lo[number]),
                    "refit_50": float(middle[number]),
                    "refit_84": float(hi[number]),
                    "refit_50_mcse": quantile_error(twin.refits[:, number], 0.5),
                }
            )
    return pd.DataFrame(lines)


def terms_table(found: TwinFindings) -> pd.DataFrame:
    """The terms of the fixed worlds."""
    lines = [
        {"reading": twin.reading, "term": str(term), "um_at_100mm": float(size)}
        for twin in found.twins.values()
        for term, size in zip(twin.fixed.terms, twin.fixed.sizes, strict=True)
    ]
    return pd.DataFrame(lines)


def _columns(reading: str) -> list[tuple[str, str]]:
    plan = "mu_xy_mm" if reading == "2-D" else "mu_xy_coordinate_mm"
    return [("m0_um", "m0_um"), ("mu_xy_mm", plan), ("mu_z_mm", "mu_z_mm")]


def _verdict(found: TwinFindings) -> str:
    lines = []
    for reading, twin in found.twins.items():
        m0, mu = near(twin.table_fixed, reading)
        lines.append(
            f"- mu_xy read as {_named(reading)}: {inside(twin.table, reading)} of 54 published figures lie inside 95 % "
            f"of the random world's experiments (composite log-likelihood {twin.fit.log_likelihood:.1f}); in the "
            "fixed world "
            f"{m0} of 18 m0 are within {fixed.M0_WITHIN_UM} um and {mu} of 36 mu within "
            f"{100 * fixed.MU_WITHIN:.0f} % of the means, with {len(twin.fixed.terms)} terms."
        )
    best = max(found.twins.values(), key=lambda t: t.fit.log_likelihood)
    lines.append(
        f"\nThe reading as {_named(best.reading)} fits better. With noise alone the 2-D reading agrees with the "
        "published plan errors, but the deformations that lift the heights of WW to what is published also lift its "
        "plan errors. "
        "The likelihood treats the 54 figures as if they were independent, which they are not; its differences are a "
        "hint, not a test."
    )
    return "\n".join(lines) + "\n"


def _named(reading: str) -> str:
    return "the 2-D error" if reading == "2-D" else "the rms of one coordinate"


def _chapter(found: TwinFindings, twin: Twin) -> Iterator[str]:
    name = _named(twin.reading)
    sizes = components_table(found)
    own = sizes[(sizes["reading"] == twin.reading) & ((sizes["size"] > 0) | (sizes["first_fit"] >= 0.5))]
    yield f"## mu_xy as {name}: the random world\n"
    digits = dict.fromkeys(("first_fit", "size", "refit_16", "refit_50", "refit_84", "refit_50_mcse"), ".1f")
    yield markdown(own.drop(columns="reading"), digits)
    yield (
        f"first_fit: non-negative least squares of the expected squares. size: refined. refit: percentiles over "
        f"{len(twin.refits)} experiments of this world, fitted again from their own 54 figures. Bounds: noise at least "
        f"{variances.NOISE_LEAST_UM} um, geodetic error at most {variances.GEODETIC_MOST_MM} mm; components without a "
        "line are 0.\n"
    )
    yield _not_separable(found, twin)
    ending = "" if twin.reading == "2-D" else f"-{twin.reading}"
    yield f"![published figures in the simulated distributions](located{ending}.png)\n"
    yield table1_markdown(twin.table)
    yield _outside(twin)
    yield f"## mu_xy as {name}: the fixed world\n"
    own_terms = terms_table(found)
    yield markdown(own_terms[own_terms["reading"] == twin.reading].drop(columns="reading"), {"um_at_100mm": ".1f"})
    sww, ww, survey = twin.fixed.random
    yield f"With noise of {sww:.1f} um (SWW) and {ww:.1f} um (WW) and a geodetic error of {survey:.1f} mm.\n"
    yield table1_markdown(twin.table_fixed)
    yield _far(twin)


def _not_separable(found: TwinFindings, twin: Twin) -> str:
    """The pairs of components of which refits take more of the one where they take less of the other."""
    variances_ = twin.refits**2
    used = np.flatnonzero(variances_.std(axis=0) > 0.0)
    r = np.atleast_2d(np.corrcoef(variances_[:, used].T))
    pairs = [(float(r[i, j]), used[i], used[j]) for i in range(len(used)) for j in range(i) if r[i, j] < -SEPARABLE]
    if not pairs:
        weakest = _cosines(found)
        return (
            f"No two components exchange their parts by a correlation below -{SEPARABLE} from refit to refit, but "
            f"their ranges above are wide. {weakest}\n"
        )
    said = "; ".join(f"{found.components[i]} and {found.components[j]} ({r_:.2f})" for r_, i, j in sorted(pairs))
    return f"What the data cannot separate, by the correlation of the refitted variances: {said}. {_cosines(found)}\n"


def _cosines(found: TwinFindings) -> str:
    scaled = found.expected / np.linalg.norm(found.expected, axis=0)
    cosine = scaled.T @ scaled - np.eye(len(found.components))
    i, j = np.unravel_index(np.argsort(-cosine, axis=None), cosine.shape)
    pairs = [(a, b) for a, b in zip(i.tolist(), j.tolist(), strict=True) if a < b][:6]
    said = "; ".join(f"{found.components[a]} and {found.components[b]} ({cosine[a, b]:.3f})" for a, b in pairs)
    return f"The most alike in what they do to the 54 expected squares (cosine): {said}."


def _outside(twin: Twin) -> str:
    said = [
        f"{name} of {row['model']}, {row['block']}, {'with' if row['aux_points'] else 'without'} auxiliary points"
        for name, own in _columns(twin.reading)
        for row in twin.table.to_dict("records")
        if not row[f"sim_{own}_lo"] <= row[name] <= row[f"sim_{own}_hi"]
    ]
    return f"Outside: {'; '.join(said) or 'none'}.\n"


def _far(twin: Twin) -> str:
    said = [
        f"{name} of {row['model']}, {row['block']}, {'with' if row['aux_points'] else 'without'} "
        f"({row[name]:g} published, {row[f'sim_{own}']:.0f} simulated)"
        for name, own in _columns(twin.reading)[1:]
        for row in twin.table_fixed.to_dict("records")
        if abs(row[name] - row[f"sim_{own}"]) > fixed.MU_WITHIN * row[name]
    ]
    return (
        f"Further than {100 * fixed.MU_WITHIN:.0f} %: {'; '.join(said) or 'none'}. What stands in the way: brown14 "
        "takes up the constant cubic terms that lift the heights with the other two models; heights as bad as "
        "published with "
        "brown14 need deformation that differs from image to image, which the fixed world does not have.\n"
    )


def _sets(found: TwinFindings) -> str:
    digits = {**dict.fromkeys(("median_f", "significant"), ".2f"), **dict.fromkeys(("mu_xy", "mu_z"), ".3f")}
    return (
        "The paper's open question, put to the twins: F test of the finer choice against the coarser, "
        f"{found.ap_sets['n'].max()} experiments each; `significant` is the share with a probability below 5 %, "
        "`mu_xy` and `mu_z` are the errors at check points with the finer choice as shares of those with the coarser "
        "(medians)."
        f"\n\n{markdown(found.ap_sets, digits)}\n{_answer(found.ap_sets)}\n"
        "In rheidt-1980 every image of a camera has the same distortion, so the share there is that of false alarms; "
        "with optical it is no false alarm, because that model lacks the affinity. The two cameras, of different "
        "noise, are adjusted with one weight, so the test does not keep its level exactly.\n"
    )


def _answer(sets: pd.DataFrame) -> str:
    """One set a flight against one a camera, world by world, in a sentence."""
    said = []
    by_flight = sets[sets["fine"] == "flight"]
    for world in by_flight["world"].unique().tolist():
        lines = by_flight[by_flight["world"] == world]
        share, mu = lines["significant"], lines[["mu_xy", "mu_z"]]
        said.append(
            f"in {world} the test says so in {100 * share.min():.0f} to {100 * share.max():.0f} % of the "
            f"experiments, and check points have {mu.min(axis=None):.2f} to {mu.max(axis=None):.2f} times the error"
        )
    return "Is one set a flight better than one a camera? By model, " + "; ".join(said) + ".\n"
