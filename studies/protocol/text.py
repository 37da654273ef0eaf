"""The protocol as a page of text, from the figures of studies.protocol.record. Lengths in metres, angles in degrees,
images in um.
"""

from __future__ import annotations

import textwrap
from collections.abc import Iterable, Iterator
from typing import Any

Record = dict[str, Any]
WIDTH = 110
DASH = "-"
PAIRS_MOST = 20
LEFT_OUT = "leave_one_image_out_um"
STATUS = {True: "passed", False: "not passed"}


def page(found: Record) -> str:
    """The whole protocol, chapter by chapter."""
    chapters = (
        ("Advice", _advice(found)),
        ("Data", _data(found)),
        ("Datum", _datum(found)),
        ("Adjustment", _adjustment(found)),
        ("Redundancy and precision by group", _groups(found)),
        ("Additional parameters", _parameters(found)),
        ("Reliability of the image coordinates", _reliability(found)),
        ("Suspected gross errors", _suspected(found)),
        ("Weighted control", _control(found)),
        ("Further observations", _further(found)),
        ("Check points", _check(found)),
        ("Correlations", _correlations(found)),
        ("Residuals by image", _by_image(found)),
        ("Residuals by radius", _by_radius(found)),
        ("Exterior orientation", _images(found)),
        ("Points", _points(found)),
    )
    lines = ["PROTOCOL OF A BUNDLE BLOCK ADJUSTMENT"]
    for title, body in chapters:
        lines += ["", title, "-" * len(title), *body]
    return "\n".join(lines) + "\n"


def _number(value: float | None, form: str) -> str:
    return DASH if value is None else format(value, form)


def _table(header: Iterable[str], rows: Iterable[Iterable[str]]) -> Iterator[str]:
    """Columns as wide as their widest cell, the first to the left, the others to the right."""
    cells = [list(header), *(list(row) for row in rows)]
    widths = [max(len(row[i]) for row in cells) for i in range(len(cells[0]))]
    for row in cells:
        first, *rest = (c.ljust(w) if i == 0 else c.rjust(w) for i, (c, w) in enumerate(zip(row, widths, strict=True)))
        yield "  ".join([first, *rest]).rstrip()


def _wrapped(text: str, first: str = "", rest: str = "") -> list[str]:
    return textwrap.wrap(text, WIDTH, initial_indent=first, subsequent_indent=rest, break_long_words=False)


def _advice(found: Record) -> Iterator[str]:
    if not found["advice"]:
        yield "Nothing to be done."
    for sentence in found["advice"]:
        yield from _wrapped(sentence + ".", "* ", "  ")


def _data(found: Record) -> Iterator[str]:
    data = found["data"]
    for camera, n in data["images"].items():
        yield f"camera {camera}: {n} images, additional parameters {data['models'].get(camera, 'none')}"
    yield ", ".join(f"{n} {role} points" for role, n in data["points"].items())
    yield f"{data['image_points']} image points, {data['rays_per_point_mean']:.2f} rays a point"
    least, most = (data["sigma_um"][name] for name in ("least", "most"))
    upto = f" to {most:.2f} um" if most > least else ""
    yield f"a priori standard deviation of an image coordinate {least:.2f} um{upto}"


def _datum(found: Record) -> Iterator[str]:
    datum = found["datum"]
    over = f" over {len(datum['points'])} points: {', '.join(datum['points'])}" if datum["points"] else ""
    yield from _wrapped(f"by {datum['by']}{over}", "", "  ")
    if datum["rank_defect"]:
        motions = "shift, rotation and scale" if datum["rank_defect"] == 7 else "shift and rotation"
        yield f"rank defect {datum['rank_defect']}: {motions} of the block, taken up by the constraints"
        return
    if datum["further"]:
        yield "further observations: " + ", ".join(datum["further"])
    for kind in ("fixed", "weighted"):
        yield f"{kind:<8} coordinates: " + ", ".join(f"{n} {axis}" for axis, n in datum[kind].items())


def _adjustment(found: Record) -> Iterator[str]:
    test = found["global_test"]
    yield f"{found['observations']} observations, {found['unknowns']} unknowns, redundancy {found['redundancy']}"
    yield f"sigma0 {found['sigma0']:.4f}, m0 {found['m0_um']:.2f} um"
    yield from _wrapped(f"{found['message']}; {found['iterations']} iterations")
    yield (
        f"global test at {test['alpha']:.0%}: vPv = {test['vpv']:.1f} in {test['lower']:.1f} .. {test['upper']:.1f}: "
        f"{STATUS[test['passed']]} (p = {test['p']:.2g})"
    )
    choice = found["model_choice"]
    aic, bic, left_out = (_number(choice[name], f) for name, f in (("aic", ".1f"), ("bic", ".1f"), (LEFT_OUT, ".3f")))
    yield f"AIC {aic}, BIC {bic}, prediction error of images left out {left_out} um (the smallest of all sets is best)"


def _groups(found: Record) -> Iterator[str]:
    header = ("group", "observations", "redundancy", "mean", "vPv", "sigma x", "+-")
    rows = (
        (
            g["group"],
            str(g["observations"]),
            f"{g['redundancy']:.2f}",
            f"{g['redundancy_mean']:.3f}",
            f"{g['vpv']:.1f}",
            _number(g["sigma_factor"], ".3f"),
            _number(g["sigma_factor_std"], ".3f"),
        )
        for g in found["groups"]
    )
    yield from _table(header, rows)
    yield "sigma x: the variance component as a factor of the a priori standard deviations; a dash: not estimable"


def _parameters(found: Record) -> Iterator[str]:
    if not found["ap_significance"]:
        yield "none"
        return
    header = ("name", "value", "std", "t", "p", "z", "p added", "R(EO)", "R(all)", "left %", "strongest correlation")
    for set_id, tested in found["ap_significance"].items():
        rows = (
            (
                e["name"],
                f"{e['value']:.5e}",
                f"{e['std']:.1e}",
                f"{e['t']:.2f}",
                f"{e['p']:.4f}",
                f"{e['z']:.2f}",
                f"{e['p_added']:.4f}",
                f"{e['with_exterior']:.3f}",
                f"{e['with_all']:.3f}",
                f"{100.0 * e['left_over']:.2g}",
                f"{e['strongest']['r']:+.3f} {e['strongest']['name']} of {e['strongest']['owner']}",
            )
            for e in tested
        )
        yield f"{found['ap_sets'][set_id]} (mm, per power of mm)"
        yield from _table(header, rows)
    yield "tested with the variance components and without suspected observations"
    yield "t, p: each beside all others; z, p added: what each adds to those above it; R: multiple correlation with the"
    yield "exterior orientation and with all other orientation unknowns, which leave over so much of its effect"


def _reliability(found: Record) -> Iterator[str]:
    r = found["reliability"]
    yield f"redundancy numbers: mean {r['redundancy_mean']:.3f}"
    yield f"least {r['redundancy_least']:.3f}: {r['redundancy_least_of']}"
    yield f"{r['below_0.1']} below 0.1, {r['below_0.3']} below 0.3"
    median, most = (_number(r[f"mdb_{which}_um"], ".1f") for which in ("median", "most"))
    yield f"minimal detectable bias: median {median} um, most {most} um, which an observation's own test in the"
    level = f"level of one observation {r['alpha']:.1e}, delta0 {r['delta0']:.2f}"
    yield f"search below finds with a power of {r['power']:.0%} ({level})"
    yield (
        f"a hidden bias moves no unknown by more than (in its a priori standard deviations): median "
        f"{_number(r['external_median'], '.2f')}, most {_number(r['external_most'], '.2f')}"
    )
    expected = f"{r['w_above_critical_expected']:.1f} expected if the stated standard deviations are right"
    yield f"{r['w_above_critical']} observations above w {r['w_critical']:.2f} ({r['w_alpha']:.1%}), {expected}"
    yield "every observation: observations.csv"


def _suspected(found: Record) -> Iterator[str]:
    search = found["search"]
    yield "order of the tests: variance components of the groups, gross errors, additional parameters"
    yield "iterative data snooping, each observation tested with the sigma0 of its group; accuses anybody in"
    yield f"{search['level_of_all']:.0%} of blocks without gross errors; critical {search['critical']:.2f}"
    if not found["suspected"]:
        yield "none"
        return
    rows = (
        (
            e["observation"],
            f"{e['tau']:.2f}",
            f"{e['error']:.4f} {e['unit']}",
            f"{e['redundancy']:.3f}",
            "; ".join(e["confused_with"]) or DASH,
        )
        for e in found["suspected"]
    )
    yield from _table(("observation", "tau", "error", "redundancy", "could as well be"), rows)


def _control(found: Record) -> Iterator[str]:
    if not found["control"]:
        yield "none"
        return
    rows = (
        (
            c["point"],
            c["coordinate"],
            f"{c['v_m']:.4f}",
            f"{c['redundancy']:.3f}",
            _number(c["w"], ".2f"),
            _number(c["mdb_m"], ".3f"),
        )
        for c in found["control"]
    )
    yield from _table(("point", "", "v m", "redundancy", "w", "mdb m"), rows)


def _further(found: Record) -> Iterator[str]:
    if not found["further"]:
        yield "none"
        return
    rows = (
        (
            e["observation"],
            f"{e['v']:.4g} {e['unit']}".rstrip(),
            f"{e['redundancy']:.3f}",
            _number(e["w"], ".2f"),
            _number(e["mdb"], ".3g"),
        )
        for e in found["further"]
    )
    yield from _table(("observation", "v", "redundancy", "w", "mdb"), rows)
    if found["biases"]:
        yield ""
        biases = (
            (f"{e['name']} of {e['owner']}", f"{e['value']:.4g} {e['unit']}", f"{e['std']:.2g}")
            for e in found["biases"]
        )
        yield from _table(("offset or drift", "value", "std"), biases)
        yield "a drift is the change from the middle of a strip to its end"


def _check(found: Record) -> Iterator[str]:
    check = found["check"]
    if not check["n"]:
        yield "none"
        return
    values = (f"{axis} {_number(check[f'rms_{axis.lower()}_m'], '.4f')}" for axis in ("X", "Y", "XY", "Z"))
    yield f"{check['n']} points, rms of adjusted minus given, m: " + ", ".join(values)


def _correlations(found: Record) -> Iterator[str]:
    pairs = found["correlations"]
    total = len(pairs) + found["correlations_left_off"]
    yield f"{total} pairs of orientation unknowns above 0.95; all correlations: correlations.csv"
    for pair in pairs[:PAIRS_MOST]:
        yield f"{pair['r']:9.4f}  " + ", ".join(f"{end['name']} of {end['owner']}" for end in (pair["a"], pair["b"]))


def _by_image(found: Record) -> Iterator[str]:
    names = ("mean_x_um", "mean_y_um", "rms_x_um", "rms_y_um")
    rows = ((e["image"], str(e["n"]), *(f"{e[name]:.2f}" for name in names)) for e in found["residuals_by_image"])
    yield from _table(("image", "points", "mean x um", "mean y um", "rms x um", "rms y um"), rows)


def _by_radius(found: Record) -> Iterator[str]:
    names = ("mean_radial_um", "mean_tangential_um", "rms_radial_um", "rms_tangential_um")
    rows = (
        (e["camera"], f"{e['from_mm']:.0f} - {e['to_mm']:.0f}", str(e["n"]), *(f"{e[name]:.2f}" for name in names))
        for e in found["residuals_by_radius"]
    )
    header = (
        "camera",
        "radius mm",
        "points",
        "mean radial um",
        "mean tangential um",
        "rms radial um",
        "rms tangential um",
    )
    yield from _table(header, rows)


def _images(found: Record) -> Iterator[str]:
    yield from _estimates(found["images"], {"_m": 3, "_deg": 6}, "image")


def _points(found: Record) -> Iterator[str]:
    yield from _estimates(found["points"], {"_m": 4}, "point")


def _estimates(table: Record, digits: dict[str, int], first: str) -> Iterator[str]:
    """Value and standard deviation of every column of a table."""
    names = list(next(iter(table.values())))
    form = {name: next(f".{d}f" for unit, d in digits.items() if name.endswith(unit)) for name in names}
    header = [first, *(part for name in names for part in (name, "std"))]
    rows = (
        [owner, *(_number(values[name][part], form[name]) for name in names for part in ("value", "std"))]
        for owner, values in table.items()
    )
    yield from _table(header, rows)
