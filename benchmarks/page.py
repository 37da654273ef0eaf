"""The results of the benchmark as a page of text."""

from __future__ import annotations

from typing import Any


def report(results: dict[str, Any]) -> str:
    """What a person reads: ratios, agreement, times, limit, scaling."""
    lines = ["times faster (medians of interleaved repetitions, one core)"]
    lines += [f"  {name:36} {_number(results[name])}" for name in results if "_over_" in name]
    lines += ["", f"cost of trial 0 (vPv) and relative distance from the least; agree: {results['agree']}"]
    for form, found in results["agreement"]["forms"].items():
        lines.append(f"  {form}, {found['unknowns']} unknowns")
        for name, cost in found["cost"].items():
            lines.append(f"    {name:32} {cost:.10f}   {found['relative_difference'][name]:.1e}")
    std = results["agreement"]["std_against_gtsam"]
    lines += [] if std is None else [f"  standard deviations of the points against GTSAM's marginals: {std:.1e}"]
    lines += ["", f"{'ms':34} {'median':>10} {'least':>10}"]
    for name, t in results["times"].items():
        lines.append(f"  {name:32} {t['median_ms']:10.4f} {t['min_ms']:10.4f}   {t['note']}")
    f, peak = results["flops"], results["peak"]["dgemm_gflops_median"]
    lines += [
        "",
        f"share of the flop limit {f['share']:.1%}: {f['mflop_per_trial']:.2f} MFLOP at {peak:.1f} GFLOP/s"
        f" (dgemm, one core) take {1000 * f['limit_ms']:.0f} us, measured {1000 * f['measured_ms']:.0f} us a trial",
    ]
    for b in results["scaling"]["blocks"]:
        lines.append(
            f"{b['images']:6} images  {b['unknowns']:7} unknowns  {b['median_s']:9.4f} s  {b['iterations']} steps"
            f"  peak {b['peak_mb']:.0f} MB"
        )
    lines.append(f"time ~ images^{_number(results['scaling_exponent']).strip()}")
    if results["memory"]:
        m = results["memory"]
        lines.append(f"{m['trials']} trials with results kept: {m['seconds']:.1f} s, peak {m['peak_mb']:.0f} MB")
    return "\n".join(lines)


def _number(value: float | None) -> str:
    return "        -" if value is None else f"{value:9.2f}"
