# %% [markdown]
# # Fly your own block: how well will it do?
#
# The cofactors $Q = (A^\top P A)^{-1}$ need the geometry and the standard deviation of an image coordinate, and no
# measurement. So the accuracy is known before anybody flies. Beside it stand the rules of thumb for one pair of images,
# with the scale number $s$, the flying height $h$ and the base $b$: $\sigma_{XY} = s\,\sigma$ and
# $\sigma_Z = \sqrt2\,(h/b)\,s\,\sigma$.

# %%
from studies.lessons import LessonError, drawings, own_block, picture

for scale in (6000, 10000, 16000):
    for layout in own_block.LAYOUTS:
        try:
            e = own_block.expected(scale, 0.6, layout)
        except LessonError as error:
            print(f"1:{scale}, control {layout}: {error}")
            continue
        print(
            f"1:{scale}, control {layout}: {e.images} images, X, Y {e.rms_xy_mm:.0f} mm ({e.rule_xy_mm:.0f}), "
            f"Z {e.rms_z_mm:.0f} mm ({e.rule_z_mm:.0f}), worst {e.worst_z_mm:.0f} mm"
        )

# %% [markdown]
# At 1:6000 four corners do not hold four narrow strips together. One point in the centre does.

# %%
e = own_block.expected(6000, 0.6, "four corners")


def draw(figure):
    left, right = figure.subplots(1, 2, width_ratios=(1.15, 1))
    dots = drawings.accuracy_map(left, e)
    figure.colorbar(dots, ax=left, label="standard deviation of Z, mm", shrink=0.8)
    drawings.expected_bars(right, e)


picture(
    190,
    88,
    "Expected standard deviations of heights over the area, and beside the rules of thumb.",
    draw,
)

# %% [markdown]
# **To do.** A client asks for 60 mm in height everywhere. Which is cheaper, more images or more control?
