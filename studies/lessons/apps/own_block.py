"""The app of lesson 6."""

import marimo

app = marimo.App(width="medium", app_title="Fly your own block")


@app.cell
def _():
    import marimo as mo

    from studies.lessons import drawings, own_block
    from studies.lessons.apps import showing
    from studies.lessons.apps.picture import picture

    return drawings, mo, own_block, picture, showing


@app.cell
def _(own_block, showing):
    showing.heading(
        "own_block",
        f"An area of 4 km × 4 km with {own_block.POINTS_A_SIDE**2} points is to be measured with a wide-angle "
        "camera. Every image costs money, and so does every control point. What accuracy may the client be "
        "promised before anybody flies?",
    )
    return


@app.cell
def _(mo, own_block, showing):
    scale = mo.ui.slider(*own_block.SCALES, step=1000, value=10000, label="image scale 1 :", show_value=True)
    overlap = mo.ui.slider(30, 80, step=5, value=60, label="forward overlap, %", show_value=True)
    control = mo.ui.dropdown(list(own_block.LAYOUTS), value="four corners", label="control")
    showing.controls(scale, overlap, control)
    return control, overlap, scale


@app.cell
def _(control, overlap, own_block, scale, showing):
    found = showing.answered(lambda: own_block.expected(float(scale.value), overlap.value / 100.0, control.value))
    return (found,)


@app.cell
def _(found, showing):
    control_points = int(found.control.sum())
    showing.numbers(
        ("images", f"{found.images}", f"in {found.strips} strips; {control_points} control points"),
        ("X, Y", f"{found.rms_xy_mm:.0f} mm", f"expected; rule of thumb {found.rule_xy_mm:.0f} mm"),
        ("Z", f"{found.rms_z_mm:.0f} mm", f"expected; rule of thumb {found.rule_z_mm:.0f} mm"),
        (
            "Z of the worst point",
            f"{found.worst_z_mm:.0f} mm",
            f"{found.lost} points are seen in fewer than two images",
        ),
    )
    return


@app.cell
def _(drawings, found, picture):
    def _draw(figure):
        left, right = figure.subplots(1, 2, width_ratios=(1.15, 1))
        dots = drawings.accuracy_map(left, found)
        figure.colorbar(dots, ax=left, label="standard deviation of Z, mm", shrink=0.8)
        drawings.expected_bars(right, found)

    picture(
        *(190, 88),
        f"Left: map of the expected standard deviations of heights, with images and control. Right: expected "
        f"{found.rms_xy_mm:.0f} mm in X and Y, {found.rms_z_mm:.0f} mm in Z, {found.worst_z_mm:.0f} mm for the "
        f"worst point.",
        _draw,
    )
    return


@app.cell
def _(mo, own_block):
    mo.accordion(
        {
            "What to try": mo.md(
                """
- **Four corners, 1 : 6000, 60 %**: more images than at 1 : 10 000, and heights worse by a power of ten. Narrow
  strips hang together by a seam only; the middle of the block sags. One control point in the centre, or control all
  around, mends it.
- **All around**, and move the scale: now the standard deviations follow it, as the rule of thumb says.
- **80 % of overlap** makes the rule of thumb worse, for the base of a pair is shorter, and the block better, for
  every point has more rays.
- **30 or 50 % of overlap**, or **no control**: read why there is no answer, or a bad one.
"""
            ),
            "The formulas": mo.md(
                rf"""
$Q = (A^\top P A)^{{-1}}$ needs the geometry and the standard deviation of an image coordinate
($\sigma = {own_block.NOISE_UM:g}$ µm), and no measurement. Expected is $\sqrt{{q_{{jj}}}}$; control counts as free
of error, and there are no additional parameters. The rules of thumb for the normal case of one pair of images, with
the scale number $s$, the flying height $h$ and the base $b$:

$$\sigma_{{XY}} = s\,\sigma, \qquad \sigma_Z = \sqrt2\,\frac{{h}}{{b}}\,s\,\sigma$$

The sidelap of the strips is 30 %.
"""
            ),
        },
        multiple=True,
    )
    return


if __name__ == "__main__":
    app.run()
