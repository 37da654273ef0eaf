"""The app of lesson 1."""

import marimo

app = marimo.App(width="medium", app_title="What does redundancy buy?")


@app.cell
def _():
    import marimo as mo

    from studies.lessons import drawings, redundancy
    from studies.lessons.apps import showing
    from studies.lessons.apps.picture import picture

    return drawings, mo, picture, redundancy, showing


@app.cell
def _(showing):
    showing.heading(
        "redundancy",
        "The wide-angle camera of 1980 flies over the field of Rheidt: 41 groups of points on 2 km × 2 km, five "
        "of them control. Each further image point costs work. Which standard errors does it buy?",
    )
    return


@app.cell
def _(mo, redundancy, showing):
    strips = mo.ui.slider(steps=list(redundancy.STRIPS), value=1, label="strips a heading", show_value=True)
    headings = mo.ui.radio({str(n): n for n in redundancy.HEADINGS_GON}, value="1", label="headings", inline=True)
    points = mo.ui.slider(steps=list(redundancy.GROUP_SIZES), value=1, label="points a group", show_value=True)
    showing.controls(strips, headings, points)
    return headings, points, strips


@app.cell
def _(redundancy, showing, strips):
    flights = showing.answered(lambda: redundancy.alternatives(strips.value))
    return (flights,)


@app.cell
def _(flights, headings, points):
    chosen = next(f for f in flights if (f.headings, f.group_size) == (headings.value, points.value))
    return (chosen,)


@app.cell
def _(chosen, showing):
    showing.numbers(
        ("redundancy r", f"{chosen.counts.redundancy}", f"{chosen.counts.images} images"),
        ("X, Y of a point", f"{chosen.std_xy_mm:.1f} mm", "expected standard error, root mean square"),
        ("Z of a point", f"{chosen.std_z_mm:.1f} mm", "expected standard error, root mean square"),
        ("radial distortion", f"{chosen.std_radial_um:.2f} µm", "expected standard error at 60 mm of radius"),
    )
    return


@app.cell
def _(chosen, mo):
    counts = chosen.counts
    mo.md(
        rf"""
$u = 6m + ak + 3p = 6\cdot{counts.images} + {counts.parameters}\cdot{counts.cameras} +
3\cdot{counts.points} = {counts.unknowns}$,
$\quad n = 2i = 2\cdot{counts.image_points} = {counts.observations}$, $\quad r = n - u = {counts.redundancy}$
"""
    )
    return (counts,)


@app.cell
def _(chosen, drawings, flights, picture):
    def _draw(figure):
        left, right = figure.subplots(1, 2)
        drawings.standard_errors(left, flights, chosen, "std_z_mm", "standard error of Z, mm")
        drawings.standard_errors(right, flights, chosen, "std_radial_um", "standard error of radial distortion, µm")
        figure.legend(*left.get_legend_handles_labels(), loc="outside lower center", ncols=4)

    picture(
        *(180, 82),
        f"Standard errors of heights and of radial distortion over the redundancy. Chosen: redundancy "
        f"{chosen.counts.redundancy}, heights {chosen.std_z_mm:.1f} mm, distortion {chosen.std_radial_um:.2f} µm.",
        _draw,
    )
    return


@app.cell
def _(mo, redundancy):
    table = "\n".join(
        f"| {row.model} | {row.cameras} | {'with' if row.aux_points else 'without'} "
        f"| 6·{row.counts.images} + {row.counts.parameters}·{row.counts.cameras} + 3·{row.counts.points} "
        f"| {row.counts.unknowns} | {row.printed_unknowns} "
        f"| 2·{row.counts.image_points} − {row.counts.unknowns} "
        f"| {row.counts.redundancy} | {row.printed_redundancy} |"
        for row in redundancy.table1()
    )
    mo.accordion(
        {
            "What to try": mo.md(
                """
- Go from one to three **points a group**. The redundancy more than triples, but the heights hardly gain: new points
  bring new unknowns, and tell little about old ones. The distortion, which all points share, gains.
- Go from one to four **headings**. Four times as many images should halve the standard errors; the heights gain
  more, for what the camera does to all images alike can no longer hide in the orientations.
- Redundancy alone is no measure: compare two flights that lie above each other in the figure.
"""
            ),
            "The formulas": mo.md(
                r"""
$m$ images with six orientation unknowns, $k$ cameras with $a$ additional parameters, $p$ points that are no
control, $i$ image points with two coordinates: $u = 6m + ak + 3p$, $n = 2i$, $r = n - u$.

With the design matrix $A$ and the weights $P = \mathrm{diag}(1/\sigma^2)$ the cofactors are
$Q = (A^\top P A)^{-1}$, and the standard error of unknown $j$ is expected to be $\sqrt{q_{jj}}$. It hangs on the
geometry and on $\sigma$ (here 4 µm), and on no measurement. Model 3.1 of Mauelshagen (1980) with $r_0 = 100$ mm:

$$dx = x\,[a_3(r^2-r_0^2) + a_4(r^4-r_0^4)] + a_5(r^2+2x^2) + a_6\,2xy$$
$$dy = y\,[a_3(r^2-r_0^2) + a_4(r^4-r_0^4)] + a_5\,2xy + a_6(r^2+2y^2)$$
"""
            ),
            "The arithmetic of Table 1 of 1980": mo.md(
                "All 18 adjustments of Mauelshagen (1980), counted; beside each count the printed one.\n\n"
                "| model | cameras | auxiliary points | 6m + ak + 3p | u | printed | 2i − u | r | printed |\n"
                "|---|---|---|---|--:|--:|---|--:|--:|\n" + table
            ),
        },
        multiple=True,
    )
    return


if __name__ == "__main__":
    app.run()
