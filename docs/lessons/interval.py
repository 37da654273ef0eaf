# %% [markdown]
# # What is a 95 % interval?
#
# The interval of a coordinate is $\hat x \pm t\,s$ with $s = \sigma_0\sqrt{q_{xx}}$. The truth is inside or it is not;
# the 95 % are a promise about many such intervals. So we measure the same flight many times, with new noise each time,
# and count. The share $p$ found in $n$ trials has the Monte-Carlo standard error $\sqrt{p(1-p)/n}$.

# %%
from studies.comparison import CONFIDENCE
from studies.lessons import drawings, interval, picture

for model in interval.SETS:
    for quantity in interval.QUANTITIES:
        r = interval.repeated(model, quantity, trials=1000)
        print(
            f"{model:10} {quantity:22} inside {r.coverage:.1%} +- {r.coverage_mcse:.1%}  mean error {r.bias_mm:6.1f} mm"
            f"   scatter {r.scatter_mm:5.1f} mm   sigma0 {r.sigma0.mean():.2f}"
        )

# %% [markdown]
# The camera has an affinity that `optical` and `none` do not know. The error that this makes in a coordinate is the
# same in every trial; an interval knows of noise only.

# %%
wrong = interval.repeated("optical", "plan at the edge", trials=500)


def draw(figure):
    left, right = figure.subplots(1, 2)
    drawings.zip_plot(left, wrong)
    drawings.running_coverage(right, wrong, CONFIDENCE)


picture(
    180,
    95,
    "Intervals of single trials, and the share of those with the truth inside.",
    draw,
)

# %% [markdown]
# **To do.** How many trials does it take to tell 93 % from 95 % with some certainty?
