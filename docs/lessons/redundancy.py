# %% [markdown]
# # What does redundancy buy?
#
# The wide-angle camera of 1980 flies over the field of Rheidt: 41 groups of points on 2 km x 2 km, five of them
# control. Each further image point costs work. Which standard errors does it buy?
#
# With $m$ images, $a$ additional parameters for each of $k$ cameras, $p$ points that are no control and $i$ image
# points: $u = 6m + ak + 3p$ unknowns, $n = 2i$ observations, redundancy $r = n - u$.

# %%
from studies.lessons import drawings, picture, redundancy

flights = redundancy.alternatives(strips=1)
for f in flights:
    c = f.counts
    print(
        f"{f.headings} headings, {f.group_size} points a group: "
        f"u = 6*{c.images} + {c.parameters}*{c.cameras} + 3*{c.points} = {c.unknowns}, r = {c.redundancy:4}   "
        f"Z {f.std_z_mm:5.1f} mm   radial distortion {f.std_radial_um:.2f} um"
    )

# %% [markdown]
# More points in a group triple the redundancy and do little for the heights: they bring their own unknowns. More
# headings help, for they show every point from other sides. The distortion is common to all points and gains from both.

# %%


def draw(figure):
    left, right = figure.subplots(1, 2)
    drawings.standard_errors(left, flights, flights[-1], "std_z_mm", "standard error of Z, mm")
    drawings.standard_errors(
        right,
        flights,
        flights[-1],
        "std_radial_um",
        "standard error of radial distortion, µm",
    )
    figure.legend(*left.get_legend_handles_labels(), loc="outside lower center", ncols=4)


picture(180, 82, "Standard errors over the redundancy, for 1, 2 and 4 headings.", draw)

# %% [markdown]
# The same arithmetic gives every row of Table 1 of Mauelshagen (1980).

# %%
for row in redundancy.table1():
    c = row.counts
    print(
        f"{row.model:10}{row.cameras:8} u {c.unknowns:4} ({row.printed_unknowns:4})   r {c.redundancy:5}",
        end="",
    )
    print(f" ({row.printed_redundancy:5})")

# %% [markdown]
# **To do.** Fly two and three strips a heading (`redundancy.alternatives(strips=2)`). Which flight has nearly the same
# redundancy as another one, and half its standard errors?
