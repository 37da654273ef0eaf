"""The app of lesson 2."""

import marimo

app = marimo.App(width="medium", app_title="Why a second zero crossing?")


@app.cell
def _():
    import marimo as mo

    from studies.lessons import drawings, second_zero
    from studies.lessons.apps import showing
    from studies.lessons.apps.picture import picture

    return drawings, mo, picture, second_zero, showing


@app.cell
def _(showing):
    showing.heading(
        "second_zero",
        "Radial distortion that grows with the radius looks like another scale of the image, and over flat ground "
        "another scale looks like another flying height. Mauelshagen (1980) makes the curve vanish a second time, "
        "at the radius $r_0$. Why?",
    )
    return


@app.cell
def _(mo, second_zero, showing):
    r0 = mo.ui.slider(0, 140, step=10, value=0, label="second zero r0, mm", show_value=True)
    camera = mo.ui.dropdown(
        {title: name for name, title in second_zero.CAMERAS.items()}, value=second_zero.CAMERAS["ww"], label="camera"
    )
    auxiliary = mo.ui.checkbox(value=False, label="with auxiliary points")
    showing.controls(r0, camera, auxiliary)
    return auxiliary, camera, r0


@app.cell
def _(auxiliary, camera, second_zero, showing):
    flights = showing.answered(lambda: second_zero.flown(camera.value, auxiliary.value))
    curve = showing.answered(lambda: second_zero.curve(flights))
    return (curve,)


@app.cell
def _(curve, r0):
    here = next(c for c in curve if c.r0_mm == r0.value)
    return (here,)


@app.cell
def _(curve, here, showing):
    showing.numbers(
        ("R(Z0, a3)", f"{here.z0_a3:.2f}", f"with r0 = 0 it is {curve[0].z0_a3:.2f}"),
        ("R(Z0, a4)", f"{here.z0_a4:.2f}", f"with r0 = 0 it is {curve[0].z0_a4:.2f}"),
        (
            "flying height Z0",
            f"{here.std_z0_mm:.0f} mm",
            f"standard deviation; with r0 = 0 {curve[0].std_z0_mm:.0f} mm",
        ),
        ("R(a3, a4)", f"{here.a3_a4:.2f}", "does not care about r0"),
    )
    return


@app.cell
def _(curve, here, mo, second_zero):
    mo.md(
        f"""
σ₀ is {here.sigma0:.4f}, with $r_0 = 0$ it is {curve[0].sigma0:.4f}. The adjusted points lie
{second_zero.largest_shift_mm(curve[0], here):.1f} mm apart at most. **The second zero changes
next to nothing in the block; it changes what is called distortion and what is called height.**
"""
    )
    return


@app.cell
def _(curve, drawings, here, picture):
    def _draw(figure):
        left, right = figure.subplots(1, 2)
        drawings.correlations(left, curve, here)
        drawings.radial_with_second_zero(right, curve[0], here)

    picture(
        *(180, 82),
        f"Left: correlations of Z0 with a3 and a4 over r0; at {here.r0_mm:.0f} mm {here.z0_a3:.2f} and "
        f"{here.z0_a4:.2f}. Right: the radial distortion found with r0 = 0 and with r0 = {here.r0_mm:.0f} mm.",
        _draw,
    )
    return


@app.cell
def _(mo):
    mo.accordion(
        {
            "What to try": mo.md(
                """
- Move $r_0$ from 0 to 100 mm. The paper reports 0.80 to 0.85 without a second zero and almost nothing with
  $r_0 = 100$ mm; the simulated block says nearly the same for $a_3$.
- Look at the band of the right figure: with $r_0 = 0$ it opens like a fan, because nobody knows how much of the
  curve is height. With a second zero it stays narrow.
- Which $r_0$ makes the correlation vanish depends on where the points lie in the images. Add the auxiliary points,
  or take the other camera.
"""
            ),
            "The formulas": mo.md(
                r"""
Model 3.1 adds to the correction equations, at the measured coordinates $x, y$ with $r^2 = x^2 + y^2$:

$$dx = x\,[a_3(r^2-r_0^2) + a_4(r^4-r_0^4)] + a_5(r^2+2x^2) + a_6\,2xy$$
$$dy = y\,[a_3(r^2-r_0^2) + a_4(r^4-r_0^4)] + a_5\,2xy + a_6(r^2+2y^2)$$

Another $r_0$ adds $-x\,(a_3\,\Delta r_0^2 + a_4\,\Delta r_0^4)$ to $dx$ and the same with $y$ to $dy$: a change of
scale. Over flat ground at the distance $h$ a change $dZ_0$ of the flying height does $dx = -x\,dZ_0/h$. So the two
can stand in for each other, and only tilts and relief tell them apart. The correlation of two unknowns is
$R_{jk} = q_{jk} / \sqrt{q_{jj}\,q_{kk}}$ with the cofactors $Q = (A^\top P A)^{-1}$. Shown is the mean $|R|$ over
the middle images of the strips.
"""
            ),
        },
        multiple=True,
    )
    return


if __name__ == "__main__":
    app.run()
