# %% [markdown]
# # Why a second zero crossing?
#
# Radial distortion that grows with the radius looks like another scale of the image, and over flat ground another scale
# looks like another flying height. Model 3.1 of Mauelshagen (1980) makes the curve vanish at a second radius $r_0$:
#
# $$dx = x\,[a_3(r^2-r_0^2) + a_4(r^4-r_0^4)] + a_5(r^2+2x^2) + a_6\,2xy, \qquad dy \text{ alike}$$

# %%
from studies.lessons import drawings, picture, second_zero

flights = second_zero.flown("ww", aux_points=False)
curve = second_zero.curve(flights)
for c in curve[::2]:
    print(
        f"r0 {c.r0_mm:3.0f} mm   R(Z0,a3) {c.z0_a3:.2f}   R(Z0,a4) {c.z0_a4:.2f}   R(a3,a4) {c.a3_a4:.2f}"
        f"   std of Z0 {c.std_z0_mm:.0f} mm   sigma0 {c.sigma0:.4f}"
    )

# %% [markdown]
# The paper reports 0.80 to 0.85 without a second zero and almost nothing with $r_0 = 100$ mm. $\sigma_0$ stays: next to
# nothing changes in the block, only what is called distortion and what is called height.

# %%
without, here = curve[0], next(c for c in curve if c.r0_mm == 100.0)


def draw(figure):
    left, right = figure.subplots(1, 2)
    drawings.correlations(left, curve, here)
    drawings.radial_with_second_zero(right, without, here)


picture(
    180,
    82,
    "Correlations of Z0 with a3 and a4 over r0, and the radial distortion with two choices of r0.",
    draw,
)

# %% [markdown]
# The two curves differ by a multiple of $r$, which is a change of scale.

# %%
inside = second_zero.RADII_MM > 10.0
difference = (without.radial_um - here.radial_um)[inside] / second_zero.RADII_MM[inside]
print(f"difference over radius: {difference.min():.4f} to {difference.max():.4f} um/mm")
print(f"largest shift of an adjusted point: {second_zero.largest_shift_mm(without, here):.1f} mm")

# %% [markdown]
# **To do.** Take the super-wide-angle camera (`"sww"`), or the auxiliary points. At which $r_0$ does the correlation
# vanish now, and why does it depend on where the points lie in the images?
