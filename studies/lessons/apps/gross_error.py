"""The app of lesson 5."""

import marimo

app = marimo.App(width="medium", app_title="Find the gross error")


@app.cell
def _():
    import marimo as mo

    from adjust.quality import ALPHA, POWER
    from studies.lessons import drawings, gross_error
    from studies.lessons.apps import showing
    from studies.lessons.apps.picture import picture

    return ALPHA, POWER, drawings, gross_error, mo, picture, showing


@app.cell
def _(gross_error, showing):
    showing.heading(
        "gross_error",
        "Three strips of four images, 169 points. You falsify one image coordinate; the adjustment, which does "
        f"not know which, has a random error of {gross_error.NOISE_UM:g} µm in every coordinate and looks for the "
        "wrong one. Where can you hide how much?",
    )
    return


@app.cell
def _(gross_error, mo, showing):
    place = mo.ui.dropdown(list(gross_error.RAYS), value="seen in 6 images", label="a point")
    axis = mo.ui.dropdown(list(gross_error.AXES), value=gross_error.ALONG, label="its coordinate")
    size = mo.ui.slider(0, int(gross_error.SIZE_MOST_UM), step=2, value=10, label="your error, µm", show_value=True)
    showing.controls(place, axis, size)
    return axis, place, size


@app.cell
def _(axis, gross_error, place, showing, size):
    found = showing.answered(lambda: gross_error.planted(place.value, axis.value, float(size.value)))
    return (found,)


@app.cell
def _(found, gross_error, showing):
    showing.numbers(
        ("|w| of your coordinate", f"{abs(found.w[found.row]):.2f}", f"accused from {gross_error.CRITICAL:.2f} on"),
        ("redundancy number r", f"{found.redundancy:.3f}", "the share of the error that its residual shows"),
        ("minimal detectable", f"{found.mdb_um:.0f} µm", "found with 80 % probability"),
        ("error estimated", f"{found.estimated_um:.0f} µm", f"you planted {found.size_um:.0f} µm, plus noise"),
    )
    return


@app.cell
def _(found, gross_error, mo):
    others = [name for row, name in zip(found.accused, found.accused_names, strict=True) if row != found.row]
    if found.found:
        verdict = "**Found.** Data snooping takes out your coordinate."
    elif abs(found.w[found.row]) > gross_error.CRITICAL:
        verdict = "**Not found.** Your |w| is above the critical value, but falls below it once others are out."
    else:
        verdict = "**Not found.** Your coordinate stays in."
    blamed = f" Others are accused: {'; '.join(others)}." if others else " Nobody else is accused."
    ratio = abs(found.shift_mm) / found.std_mm
    worst = int(ratio.argmax())
    mo.md(
        f"""
{verdict}{blamed}

If it stays in, it moves its own point by {abs(found.shift_mm[worst]):.0f} mm in {"XYZ"[worst]}, where the standard
deviation is {found.std_mm[worst]:.0f} mm.
"""
    )
    return


@app.cell
def _(POWER, drawings, found, picture):
    def _draw(figure):
        left, right = figure.subplots(1, 2)
        drawings.tests(left, found)
        drawings.power(right, found, POWER)

    picture(
        *(180, 88),
        f"Left: |w| of all image coordinates; that of the falsified one is {abs(found.w[found.row]):.2f}. Right: the "
        f"probability that an error here is noticed; the minimal detectable one is {found.mdb_um:.0f} µm.",
        _draw,
    )
    return


@app.cell
def _(ALPHA, found, gross_error, mo):
    mo.accordion(
        {
            "What to try": mo.md(
                f"""
- **Seen in 6 images**: raise the error until it is found. Compare with the minimal detectable bias.
- **Seen in 2 images, along the flight**: nothing checks this coordinate. The error becomes height, whatever its
  size, and |w| does not move. Across the flight it can be found, but which of the two images is wrong remains open.
- **Seen in 3 images, along the flight**: the error is noticed, and another image may be blamed for it. The tests of
  neighbours are correlated.
- Set the error to 0. With {len(found.w)} coordinates tested at 0.1 % somebody innocent is accused in most
  flights. The level belongs to the whole adjustment, not to one test.
"""
            ),
            "The formulas": mo.md(
                rf"""
With the residual $v$, the standard deviation $\sigma$ and the redundancy number $r_i$, the diagonal element of
$R = I - A Q A^\top P$ (Baarda 1968):

$$w_i = \frac{{v_i}}{{\sigma_i \sqrt{{r_i}}}} \sim N(0, 1), \qquad
\nabla_i = \delta_0 \frac{{\sigma_i}}{{\sqrt{{r_i}}}}, \qquad \hat g_i = -\frac{{v_i}}{{r_i}}$$

An error $g$ moves $w_i$ by $g\sqrt{{r_i}}/\sigma_i$. At the level {100 * ALPHA:g} % of one test the critical value
is {gross_error.CRITICAL:.2f}; with $\delta_0 = {gross_error.DELTA0:.2f}$ the minimal detectable bias $\nabla_i$ is
noticed with a probability of 80 %. The sum of all $r_i$ is the redundancy.
"""
            ),
        },
        multiple=True,
    )
    return


if __name__ == "__main__":
    app.run()
