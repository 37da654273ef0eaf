"""The app of lesson 4."""

import marimo

app = marimo.App(width="medium", app_title="What is a 95 % interval?")


@app.cell
def _():
    import marimo as mo

    from studies.comparison import CONFIDENCE
    from studies.lessons import drawings, interval
    from studies.lessons.apps import showing
    from studies.lessons.apps.picture import picture

    return CONFIDENCE, drawings, interval, mo, picture, showing


@app.cell
def _(showing):
    showing.heading(
        "interval",
        "An adjustment says: 12.345 m, with a 95 % interval of ± 30 mm. The truth is inside or it is not; what "
        "are the 95 %? Here the same flight is measured again and again, with new noise each time, and you count. "
        "The camera has the distortion of its lens and an affinity of the film, as in 1980.",
    )
    return


@app.cell
def _(interval, mo, showing):
    model = mo.ui.dropdown(list(interval.SETS), value="torlegard", label="additional parameters")
    quantity = mo.ui.dropdown(list(interval.QUANTITIES), value="plan at the edge", label="coordinate")
    trials = mo.ui.slider(50, interval.MOST_TRIALS, step=50, value=200, label="trials", show_value=True)
    again = mo.ui.button(value=0, on_click=lambda count: count + 1, label="measure anew")
    showing.controls(model, quantity, trials, again)
    return again, model, quantity, trials


@app.cell
def _(again, interval, model, quantity, showing, trials):
    found = showing.answered(lambda: interval.repeated(model.value, quantity.value, trials.value, again.value))
    return (found,)


@app.cell
def _(found, showing):
    showing.numbers(
        (
            "truth inside",
            f"{100 * found.coverage:.1f} %",
            f"± {100 * found.coverage_mcse:.1f} % Monte-Carlo standard error; promised 95 %",
        ),
        ("mean error", f"{found.bias_mm:.1f} mm", f"± {found.bias_mcse_mm:.1f} mm; it should be 0"),
        ("scatter", f"{found.scatter_mm:.1f} mm", "standard deviation of the estimates over the trials"),
        ("half width", f"{found.half_width_mm.mean():.1f} mm", f"mean; σ₀ is {found.sigma0.mean():.2f} in the mean"),
    )
    return


@app.cell
def _(CONFIDENCE, drawings, found, picture):
    def _draw(figure):
        left, right = figure.subplots(1, 2)
        drawings.zip_plot(left, found)
        drawings.running_coverage(right, found, CONFIDENCE)

    picture(
        *(180, 95),
        f"Left: intervals of single trials, those without the truth in another colour. Right: the share of intervals "
        f"with the truth inside, {100 * found.coverage:.1f} % after {len(found.error_mm)} trials.",
        _draw,
    )
    return


@app.cell
def _(mo):
    mo.accordion(
        {
            "What to try": mo.md(
                """
- With **torlegard**, which can describe this camera, measure anew several times. The share moves around 95 % inside
  the grey band; with more trials the band narrows as $1/\\sqrt n$.
- Take **optical**, which does not know the affinity. For the plan at the edge about half of all intervals miss the
  truth, though each of them looks as respectable as before: the error is the same in every trial, and an interval
  knows of noise only.
- For heights the same wrong set gives *more* than 95 %: σ₀ has grown, and makes all intervals wider, also where
  nothing is wrong.
"""
            ),
            "The formulas": mo.md(
                r"""
The interval is $\hat x \pm t\,s$ with $s = \sigma_0\sqrt{q_{xx}}$ and Student's $t$ for 97.5 % and $r$ degrees of
freedom. If the model is right, $(\hat x - x)/s$ has that distribution, and 95 % of *all such intervals* contain
$x$; of a single one nothing is said. If the model leaves a distortion $\delta$ over, $\hat x$ scatters around
$x + (Q A^\top P\,\delta)_x$ instead.

The share $p$ found in $n$ trials has the Monte-Carlo standard error $\sqrt{p\,(1-p)/n}$: 1.5 % for 200 trials, 0.7
% for 1000.
"""
            ),
        },
        multiple=True,
    )
    return


if __name__ == "__main__":
    app.run()
