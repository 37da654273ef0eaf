"""The protocol of an adjustment as figures: what a surveyor signs. The keys are those of protocol.json.

Beside the estimates (studies.protocol.adjustment_page) it has the datum, the global test, redundancy by group,
significance of additional parameters, reliability, suspected gross errors, residuals by image and by radius, control,
and advice.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from adjust import Adjustment, FreeAdjustment, reweighted
from adjust.model import POINT_NAMES
from adjust.quality import (
    LEVEL,
    POWER,
    Accused,
    ApSignificance,
    Inspection,
    Reliability,
    VarianceComponents,
    aic,
    ap_significance,
    bic,
    global_test,
    groups_by_camera,
    inspected,
    leave_one_image_out,
    tau_critical,
    variance_components,
    w_critical,
)
from studies.protocol import adjustment_page, further_observations as protocol_further, residuals as protocol_residuals
from studies.protocol.advice import advice

Record = dict[str, Any]
ALPHA = 0.001
"""of the bound beside which the w of single observations are counted"""
ACCUSED_MOST = 50
ORDER = ["variance components", "gross errors", "additional parameters"]


@dataclass(frozen=True, eq=False)
class ProtocolFindings:
    """What is computed once for the whole protocol."""

    adjustment: Adjustment

    @cached_property
    def reliability(self) -> Reliability:
        """Of the stated standard deviations."""
        return Reliability.of(self.adjustment, ALPHA, POWER)

    @cached_property
    def inspection(self) -> Inspection:
        """Components, search and minimal detectable biases: a wrong standard deviation of a group accuses nobody."""
        return inspected(self.adjustment, LEVEL, ACCUSED_MOST, POWER)

    @cached_property
    def components(self) -> VarianceComponents | None:
        """Those of all groups without the suspected observations; None where they cannot be estimated."""
        a, weights = self.adjustment, self.adjustment.groups.weights
        weights[self.inspection.suspected] = 0.0
        try:
            return variance_components(reweighted(a, weights) if len(self.inspection.suspected) else a)
        except ValueError:
            return None

    @cached_property
    def ap(self) -> dict[str, ApSignificance]:
        """Tested in what the search left, with the components."""
        left = self.inspection.adjustment
        left = left if left.status.ok else self.adjustment
        return {camera: ap_significance(left, camera) for camera, e in left.ap.items() if e.names}


def record(a: Adjustment, findings: ProtocolFindings | None = None) -> Record:
    """The whole protocol in plain types without NaN. Raises ValueError where the adjustment failed."""
    findings = ProtocolFindings(a) if findings is None else findings
    found: Record = {
        **adjustment_page.record(a),
        "data": data(a),
        "datum": datum(a),
        "global_test": _global_test(a),
        "groups": groups(findings),
        "model_choice": model_choice(a),
        "ap_sets": {s.id: a.layout.owner_of(s) for s in a.layout.sets},
        "ap_significance": {camera: _significance(s) for camera, s in findings.ap.items()},
        "reliability": reliability(findings),
        "order_of_tests": ORDER,
        "suspected": [_accused(a, each) for each in findings.inspection.snooping.accused],
        "search": _search(findings),
        "control": control(findings),
        "further": protocol_further.observations(a, findings.reliability, findings.inspection.reliability.mdb),
        "biases": protocol_further.biases(a),
        "residuals_by_image": protocol_residuals.by_image(a),
        "residuals_by_radius": protocol_residuals.by_radius(a),
    }
    found["advice"] = advice(found)
    return found


def data(a: Adjustment) -> Record:
    """What was adjusted, counted."""
    b = a.block
    role, rays = b.points.role, b.rays
    return {
        "images": {c.camera_id: int(np.sum(b.images.camera == i)) for i, c in enumerate(b.cameras)},
        "points": {name: int(np.sum(role == name)) for name in ("control", "check", "tie")},
        "image_points": len(b.observations),
        "rays_per_point_mean": float(rays.mean()),
        "points_with_two_rays": int(np.sum(rays == 2)),
        "sigma_um": {
            "least": 1000.0 * float(b.observations.sigma.min()),
            "most": 1000.0 * float(b.observations.sigma.max()),
        },
        "models": {s.id: s.model.id for s in a.layout.sets},
    }


def datum(a: Adjustment) -> Record:
    """What fixes the block in space."""
    p = a.block.points
    if isinstance(a, FreeAdjustment):
        ids = [p.ids[row] for row in a.datum_rows]
        return {
            "by": "inner constraints",
            "points": ids,
            "fixed": {},
            "weighted": {},
            "rank_defect": a.rank_defect,
            "further": [],
        }
    return {
        "by": "control" if (p.fixed | p.weighted).any() else "further observations",
        "points": [name for name, row in zip(p.ids, p.fixed | p.weighted, strict=True) if row.any()],
        "fixed": {name: int(p.fixed[:, i].sum()) for i, name in enumerate(POINT_NAMES)},
        "weighted": {name: int(p.weighted[:, i].sum()) for i, name in enumerate(POINT_NAMES)},
        "rank_defect": 0,
        "further": [group.name for group in a.groups.further],
    }


def groups(findings: ProtocolFindings) -> list[Record]:
    """Count, redundancy and vPv of every group of observations, with the factor of its standard deviations."""
    a = findings.adjustment
    components, factors = findings.components, {}
    if components is not None:
        both = zip(components.sigma_factor, components.sigma_factor_std, strict=True)
        factors = dict(zip(components.names, both, strict=True))
    standard, r = findings.reliability.influence.rows.standard, findings.reliability.redundancy
    found = []
    for name, rows in groups_by_camera(a).items():
        factor, std = factors.get(name, (math.nan, math.nan))
        found.append(
            {
                "group": name,
                "observations": len(rows),
                "redundancy": float(r[rows].sum()),
                "redundancy_mean": float(r[rows].mean()),
                "vpv": float(np.sum(standard[rows] ** 2)),
                "sigma_factor": number(float(factor)) if math.isfinite(std) else None,
                "sigma_factor_std": number(float(std)),
            }
        )
    return found


def model_choice(a: Adjustment) -> Record:
    """What to compare with the same block adjusted with another set: the smallest is best."""
    a = a.regular
    with np.errstate(divide="ignore", invalid="ignore"):  # a block without any error, or images that nothing predicts
        found = {"aic": aic(a), "bic": bic(a), "leave_one_image_out_um": leave_one_image_out(a).rms_um}
    return {name: number(value) for name, value in found.items()}


def reliability(findings: ProtocolFindings) -> Record:
    """The reliability of the image coordinates in a few numbers, and of the points: the worst effect of a hidden
    error. Minimal detectable biases are those of the search: of its level and of the precision that was found.
    """
    found, a, tested = findings.reliability, findings.adjustment, findings.inspection.reliability
    rows = found.image_points
    r, mdb, external = found.redundancy[rows], tested.mdb[rows], tested.external[rows]
    weakest = int(np.argmin(r))
    return {
        "alpha": tested.alpha,
        "power": POWER,
        "delta0": float(np.mean(tested.shifts[rows])) if tested.shifts is not None else tested.delta0,
        "redundancy_least": float(r[weakest]),
        "redundancy_least_of": found.name(weakest),
        "redundancy_mean": float(r.mean()),
        "below_0.1": int(np.sum(r < 0.1)),
        "below_0.3": int(np.sum(r < 0.3)),
        "mdb_median_um": number(1000.0 * float(np.median(mdb))),
        "mdb_most_um": number(1000.0 * float(mdb.max())),
        "external_median": number(float(np.median(external))),
        "external_most": number(float(external.max())),
        "w_alpha": ALPHA,
        "w_critical": w_critical(ALPHA),
        "tau_critical": tau_critical(a.redundancy, ALPHA),
        "w_above_critical": int(np.sum(np.abs(found.w) > w_critical(ALPHA))),
        "w_above_critical_expected": ALPHA * a.observations,
    }


def control(findings: ProtocolFindings) -> list[Record]:
    """Weighted control coordinates: correction, redundancy, w; fixed ones have none."""
    found, mdb = findings.reliability, findings.inspection.reliability.mdb
    start = found.image_points.stop
    given = findings.adjustment.regular.groups.control
    return [
        {
            "point": findings.adjustment.block.points.ids[at // 3],
            "coordinate": POINT_NAMES[at % 3],
            "v_m": float(found.influence.rows.v[row]),
            "redundancy": float(found.redundancy[row]),
            "w": number(float(found.w[row])),
            "mdb_m": number(float(mdb[row])),
        }
        for row, at in enumerate(given.coordinates.tolist(), start=start)
    ]


def number(value: float) -> float | None:
    return value if math.isfinite(value) else None


def _global_test(a: Adjustment) -> Record:
    found = global_test(a, LEVEL)
    return {
        "alpha": LEVEL,
        "vpv": found.vpv,
        "lower": found.lower,
        "upper": found.upper,
        "p": found.p,
        "passed": found.passed,
    }


def _significance(s: ApSignificance) -> list[Record]:
    columns = zip(
        s.names, s.values, s.std, s.t, s.p, s.z, s.p_added, s.with_exterior, s.with_all, s.strongest, strict=True
    )
    return [
        {
            "name": name,
            "value": float(value),
            "std": float(std),
            "t": float(t),
            "p": float(p),
            "z": float(z),
            "p_added": float(p_added),
            "with_exterior": float(exterior),
            "with_all": float(everything),
            "left_over": math.sqrt(max(1.0 - float(everything) ** 2, 0.0)),
            "strongest": {"owner": strongest[0], "name": strongest[1], "r": strongest[2]},
        }
        for name, value, std, t, p, z, p_added, exterior, everything, strongest in columns
    ]


def _accused(a: Adjustment, each: Accused) -> Record:
    unit = protocol_further.unit(a, each.row)
    return {
        "observation": each.name,
        "tau": each.statistic,
        "critical": each.critical,
        "error": protocol_further.factor(unit) * each.error,
        "unit": unit,
        "redundancy": each.redundancy,
        "confused_with": list(each.confused_with),
    }


def _search(findings: ProtocolFindings) -> Record:
    inspection = findings.inspection
    weights = findings.adjustment.groups.weights
    weights[inspection.suspected] = 0.0
    without = reweighted(findings.adjustment, weights) if len(inspection.suspected) else findings.adjustment
    return {
        "test": "tau, each observation with the sigma0 of its group",
        "level_of_all": LEVEL,
        "level_of_one": inspection.alpha,
        "critical": w_critical(inspection.alpha),
        "stopped": inspection.snooping.stopped,
        "sigma0_without": number(without.sigma0),
    }
