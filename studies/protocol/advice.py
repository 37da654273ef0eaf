"""Warnings that say what to do: from the figures of a protocol to sentences."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

Record = dict[str, Any]
CORRELATED = 0.99
"""multiple correlation with the exterior orientation from which an additional parameter is called doubtful"""
NOT_SIGNIFICANT = 0.05
NAMED_MOST = 6
FEW_POINTS = 6
WITHOUT_ERRORS = 1e-3
"""sigma0 below which nothing was measured"""
SYSTEMATIC = 4.0
"""mean of the radial residuals of a ring in its standard errors from which it is called systematic"""


def advice(found: Record) -> list[str]:
    """What a careful reader of the protocol would do next; empty if nothing is to be done."""
    return [
        *_suspects(found),
        *_sigma0(found),
        *_weights(found),
        *_parameters(found),
        *_checks(found),
        *_geometry(found),
    ]


def _listed(names: list[str]) -> str:
    more = len(names) - NAMED_MOST
    return ", ".join(names[:NAMED_MOST]) + (f" and {more} more" if more > 0 else "")


def _suspects(found: Record) -> Iterator[str]:
    suspected = found["suspected"]
    if suspected:
        names = _listed([each["observation"] for each in suspected])
        yield (
            f"{_counted(len(suspected), 'observation')} suspected of a gross error: {names}. Measure again or take "
            "out, the worst first, and adjust again; without them sigma0 would be "
            f"{found['search']['sigma0_without']:.4f}"
        )
    if found["search"]["stopped"]:
        yield (
            "The search for gross errors was stopped before its end: that many are hardly errors of measurement. Look "
            "at the approximate values, the camera file and the additional parameters first"
        )


def _sigma0(found: Record) -> Iterator[str]:
    test = found["global_test"]
    if test["passed"]:
        return
    if found["sigma0"] < WITHOUT_ERRORS:
        yield (
            f"sigma0 = {found['sigma0']:.1g}: the observations have no errors at all, as if computed and not measured, "
            "so they say nothing about their standard deviations"
        )
    elif test["vpv"] > test["upper"]:
        yield (
            f"sigma0 = {found['sigma0']:.3f} is larger than 1 (global test, p = {test['p']:.2g}): the observations are "
            "less precise than stated, or errors are left in them. Look at suspected errors and at the residuals by "
            f"radius; if both are clean, multiply the standard deviations by {found['sigma0']:.3g}"
        )
    else:
        yield (
            f"sigma0 = {found['sigma0']:.3f} is smaller than 1 (global test, p = {test['p']:.2g}): the observations "
            f"are more precise than stated. Multiply their standard deviations by {found['sigma0']:.3g}; estimates "
            "with control held fixed stay as they are, weighted control loses weight"
        )


def _weights(found: Record) -> Iterator[str]:
    known = [g for g in found["groups"] if g["sigma_factor"] is not None]
    factors = [g["sigma_factor"] for g in known]
    if len(known) > 1:
        apart = [g for g in known if abs(g["sigma_factor"] / min(factors) - 1.0) > 0.2]
        clear = [g for g in apart if abs(g["sigma_factor"] - min(factors)) > 4.0 * g["sigma_factor_std"]]
        if clear:
            said = ", ".join(f"{g['group']} {g['sigma_factor']:.2f} +- {g['sigma_factor_std']:.2f}" for g in known)
            yield f"The groups differ in precision; multiply their standard deviations by: {said}"
    unchecked = [g["group"] for g in found["groups"] if g["group"] == "control" and g["redundancy"] < 1.0]
    if unchecked:
        yield "Control is hardly checked by the block: give more of it, an error in it would not be seen"
    bad = [f"{c['coordinate']} of {c['point']}" for c in found["control"] if c["w"] is not None and abs(c["w"]) > 3.29]
    if bad:
        yield f"Control that does not fit the block: {_listed(bad)}. Check identification and coordinates"


def _parameters(found: Record) -> Iterator[str]:
    for set_id, tested in found["ap_significance"].items():
        owner = found["ap_sets"][set_id]
        doubtful = [each["name"] for each in tested if each["with_exterior"] > CORRELATED]
        if doubtful:
            yield (
                f"{_listed(doubtful)} of {owner} can hardly be told from the exterior orientation: leave out, "
                "or fly cross strips, oblique images or ground with more relief"
            )
        idle = [each["name"] for each in tested if each["p"] > NOT_SIGNIFICANT and each["p_added"] > NOT_SIGNIFICANT]
        if idle:
            yield f"{_listed(idle)} of {owner} are not significant: they can be left out"
    systematic = sorted({r["camera"] for r in found["residuals_by_radius"] if _is_systematic(r)})
    if systematic:
        yield (
            f"Radial residuals of camera {_listed(systematic)} are systematic: take a set of additional parameters "
            "that can follow them"
        )


def _is_systematic(ring: Record) -> bool:
    spread = max(ring["rms_radial_um"] ** 2 - ring["mean_radial_um"] ** 2, 0.0) ** 0.5
    return bool(abs(ring["mean_radial_um"]) > SYSTEMATIC * spread / ring["n"] ** 0.5 and ring["n"] > 10)


def _checks(found: Record) -> Iterator[str]:
    check = found["check"]
    if check["n"] == 0:
        yield "There are no check points: nothing outside the adjustment says how good it is"


def _geometry(found: Record) -> Iterator[str]:
    weak = found["reliability"]["below_0.1"]
    if weak:
        yield (
            f"{_counted(weak, 'image coordinate')} checked by less than a tenth (redundancy below 0.1), weakest "
            f"{found['reliability']['redundancy_least_of']}: errors there stay hidden; measure these points in more "
            "images"
        )
    two = found["data"]["points_with_two_rays"]
    if two:
        yield (
            f"{_counted(two, 'point')} measured in two images only: an error along the base cannot be seen; measure "
            "in a third"
        )
    few = [each["image"] for each in found["residuals_by_image"] if each["n"] < FEW_POINTS]
    if few:
        yield f"Fewer than {FEW_POINTS} points in {_listed(few)}: their orientation is weak; measure more"


def _counted(n: int, noun: str) -> str:
    return f"{n} {noun} is" if n == 1 else f"{n} {noun}s are"
