"""The app of lesson 3."""

import marimo

app = marimo.App(width="medium", app_title="Which model for which distortion?")


@app.cell
def _():
    import marimo as mo

    from studies.lessons import drawings, which_model
    from studies.lessons.apps import showing
    from studies.lessons.apps.picture import picture

    return drawings, mo, picture, showing, which_model


@app.cell
def _(showing, which_model):
    showing.heading(
        "which_model",
        "You know the distortion, because you choose it: a vector of 8 µm in the quadratic mean over the image. "
        f"The image noise is {which_model.NOISE_UM:g} µm. Which set of additional parameters fits, and how would "
        "somebody know who sees σ₀ only?",
    )
    return


@app.cell
def _(mo, showing, which_model):
    truth = mo.ui.dropdown(list(which_model.TRUTHS), value="lens: radial and decentering", label="true distortion")
    model = mo.ui.dropdown(list(which_model.SETS), value="none", label="additional parameters")
    headings = mo.ui.radio({"1": 1, "4": 4}, value="4", label="headings flown", inline=True)
    showing.controls(truth, model, headings)
    return headings, model, truth


@app.cell
def _(headings, showing, truth, which_model):
    found = showing.answered(lambda: which_model.compared(truth.value, which_model.SIZE_UM, headings.value))
    return (found,)


@app.cell
def _(found, model):
    fitted = found.fitted[model.value]
    smallest = min(f.rms_z_mm for f in found.fitted.values())
    best = ", ".join(name for name, f in found.fitted.items() if f.rms_z_mm < 1.02 * smallest)
    parameters = {0: "no additional parameters"}.get(fitted.parameters, f"{fitted.parameters} parameters")
    return best, fitted, parameters, smallest


@app.cell
def _(fitted, showing, which_model):
    showing.numbers(
        ("m0", f"{fitted.m0_um:.2f} µm", f"σ₀ = {fitted.sigma0:.2f}; the noise is {which_model.NOISE_UM:g} µm"),
        ("error of X, Y", f"{fitted.rms_xy_mm:.0f} mm", f"the adjustment claims {fitted.claimed_xy_mm:.0f} mm"),
        ("error of Z", f"{fitted.rms_z_mm:.0f} mm", f"the adjustment claims {fitted.claimed_z_mm:.0f} mm"),
        ("left over", f"{fitted.residuals.rms_um:.1f} µm", "of the distortion in the mean residuals"),
    )
    return


@app.cell
def _(best, fitted, mo, parameters, smallest, which_model):
    mo.md(
        f"""
The smallest errors of heights, {smallest:.0f} mm, come with **{best}**.
All numbers are means over {which_model.TRIALS} flights; the errors are those of the check points against the truth.
**{fitted.model}** has {parameters}.
"""
    )
    return


@app.cell
def _(drawings, fitted, found, picture, truth):
    def _draw(figure):
        axes = figure.subplots(1, 3, width_ratios=(1, 1, 1.05))
        drawings.distortion_field(axes[0], found.true, "true distortion", 10.0)
        drawings.distortion_field(axes[1], fitted.residuals, f"in the residuals of {fitted.model}", 3.0)
        drawings.sets_compared(axes[2], found, fitted.model)

    picture(
        *(190, 82),
        f"Vectors of the true distortion ({truth.value}), of what {fitted.model} leaves in the residuals "
        f"({fitted.residuals.rms_um:.1f} µm), and all sets compared by m0 and by the errors of check points.",
        _draw,
    )
    return


@app.cell
def _(mo):
    mo.accordion(
        {
            "What to try": mo.md(
                """
- **Lens, ebner12, four headings**: $m_0$ is 2 to 3 % above the noise, which nobody would notice, and the heights
  are half as bad again as with the right set.
- **Film off its plane, none, four headings**: $m_0$ is half as large again as the noise, and the points hardly
  suffer. Four headings turn the image against the ground, and the errors average out.
- **One heading** instead of four: the residuals become small, for the orientations and the points take up the
  distortion. It has not gone. It is in your points.
- **No distortion, brown14, one heading**: parameters that nothing calls for cost accuracy, and $m_0$ says nothing
  of it.
"""
            ),
            "The formulas": mo.md(
                r"""
measured $+\ v =$ projected $+\ d(\text{measured})$, and $\sigma_0 = \sqrt{v^\top P v / r}$,
$m_0 = \sigma_0\,\sigma$ with the redundancy $r$. A distortion $\delta$ that no parameter describes is split by the
adjustment: the part $(I - A Q A^\top P)\,\delta$ goes into the residuals and into $\sigma_0$, the part
$Q A^\top P\,\delta$ into the unknowns. The sets of Mauelshagen (1980), with $r_0 = 100$ mm:

- optical: $dx = x\,[a_3(r^2-r_0^2) + a_4(r^4-r_0^4)] + a_5(r^2+2x^2) + a_6\,2xy$, $\ dy$ alike
- torlegard: $dx$ as optical; $\ dy = a_1 x + a_2 y\ +\ dy$ of optical
- brown14, with $q = b_5xy + b_6x^3 + b_7x^2y + b_8xy^2 + b_9y^3$ and
  $B = b_{10}(r^2-r_0^2) + b_{11}(r^4-r_0^4) + b_{12}(r^6-r_0^6)$:
  $dx = b_1x + b_2y + b_3xy^2 + \frac{x}{r}q + x\,B + b_{13}(r^2+2x^2) + b_{14}\,2xy$,
  $dy = b_4x^2y + \frac{y}{r}q + y\,B + b_{13}\,2xy + b_{14}(r^2+2y^2)$

ebner12 knows nothing of physics: its terms are orthogonal on nine points of the image. `simfield models ebner12`
prints them.
"""
            ),
        },
        multiple=True,
    )
    return


if __name__ == "__main__":
    app.run()
