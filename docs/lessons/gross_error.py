# %% [markdown]
# # Find the gross error: can it hide?
#
# We falsify one image coordinate by $g$; the adjustment does not know which. With the redundancy number $r_i$ (Baarda
# 1968) its test quantity $w_i = v_i / (\sigma_i\sqrt{r_i})$ moves by $g\sqrt{r_i}/\sigma_i$, and an error of
# $\nabla_i = \delta_0\,\sigma_i/\sqrt{r_i}$ is noticed with a probability of 80 %.

# %%
from studies.lessons import drawings, gross_error, picture

for place in gross_error.RAYS:
    for axis in gross_error.AXES:
        p = gross_error.planted(place, axis, size_um=40.0)
        print(f"{place}, {axis}: r {p.redundancy:.3f}, minimal detectable {p.mdb_um:.0f} um, |w| {abs(p.w[p.row]):.1f}")
        print(f"    {'found' if p.found else 'not found'}; accused: {'; '.join(p.accused_names) or 'nobody'}")
        print(f"    moves its point by {p.shift_mm.round()} mm, standard deviations {p.std_mm.round()} mm")

# %% [markdown]
# Along the flight a point seen in two images is checked by nothing: the error becomes height. In three images it is
# noticed, and a neighbour may be blamed for it.

# %%
p = gross_error.planted("seen in 6 images", gross_error.ALONG, size_um=20.0)


def draw(figure):
    left, right = figure.subplots(1, 2)
    drawings.tests(left, p)
    drawings.power(right, p, gross_error.POWER)


picture(
    180,
    88,
    "|w| of all image coordinates, and the probability that an error is noticed.",
    draw,
)

# %% [markdown]
# **To do.** Plant nothing (`size_um=0.0`). Who is accused, and how many would you expect at a level of 0.1 %?
