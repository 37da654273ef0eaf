"""The report of the reproduction in Markdown. Every figure in it is read off the tables."""

from __future__ import annotations

from collections.abc import Iterator

import pandas as pd

from studies.experiments import published
from studies.experiments.ziemann_1982 import reseau
from studies.experiments.ziemann_1982.experiment import SETS, cases, model_of
from studies.experiments.ziemann_1982.findings import ZiemannFindings
from studies.experiments.ziemann_1982.table import case_markdown, order
from studies.pages import scenario_page
from studies.texts import markdown


def report_page(found: ZiemannFindings, command: str) -> str:
    """The report, from top to bottom."""
    sections = (_opening(found), _table(found), _orders(found), _system(found), _others(found), _world(found))
    return "\n".join("\n".join(section) for section in (*sections, _closing(command)))


def _opening(found: ZiemannFindings) -> Iterator[str]:
    yield "# Ziemann & El-Hakim 1982, flown and adjusted again\n"
    yield published.source("ziemann-el-hakim-1982").split(";")[0] + ".\n"
    yield (
        "Seven published sets of additional parameters in one bundle program, on images of two wide-angle reseau "
        "cameras over two test fields: a block of 3 x 3 images with 60 % overlap both ways at 1:5000 and four images "
        "at 1:10 000 in four headings, all field points held as control. The strategy has three steps: correct the "
        "image deformation by the reseau, determine and remove the system's distortion, self-calibrate.\n"
    )
    yield (
        f"Here the flights are simulated, {found.trials} over one geometry for each camera and field; noise, film, "
        "crosses and survey are new in every flight, and every set sees the same flights. The figure is the rms "
        "length of the residual vectors in the image: with all points held fixed, that is the ground residual at "
        "image scale. A figure is the mean over the flights; the Monte-Carlo standard errors, at most "
        f"{found.table['sim_mcse_um'].max():.2f} um, and the gains against none from pairs of the same flight are in "
        "`table.csv`.\n"
    )
    levels = "; ".join(f"{level} {name}" for level, name in reseau.LEVELS.items())
    yield (
        f"Levels of reseau correction: {levels}. The paper's own definition of its levels is on a page that is not "
        "at hand; these are this project's reading. A similarity (level 1) can change nothing here, because the "
        "orientation of each image takes it up; the published figures of the RMK-A fall from level 0 to 1, so the "
        "paper's level 1 was more than that. Set a is not compared: its formula is not at hand. Set k is a "
        "reconstruction.\n"
    )


def _table(found: ZiemannFindings) -> Iterator[str]:
    yield "## 1  Rms of residual vectors, um: published / simulated\n"
    names = ", ".join(f"{letter} `{model}`" for letter, model in SETS.items())
    yield f"Sets: {names}. A question mark: not readable, or with doubtful digits.\n"
    for case in cases():
        yield f"### {case}\n"
        yield case_markdown(found.table, case)
    yield "![Sets](sets.svg)\n"
    yield "![Levels](levels.svg)\n"


def _orders(found: ZiemannFindings) -> Iterator[str]:
    yield "## 2  The order of the sets\n"
    rows = [
        {
            "case": str(case),
            "published, best first": order(found.table, case, "published_um"),
            "simulated": order(found.table, case, "sim_um"),
        }
        for case in cases()
    ]
    yield "By the mean over the levels at which all sets are readable.\n"
    yield markdown(pd.DataFrame(rows))
    said = [f"{r:.2f} ± {error:.2f}" for r, error in found.ranks[["spearman", "spearman_mcse"]].to_numpy(float)]
    wide = found.ranks.assign(said=said).pivot(index=["camera", "field"], columns="level", values="said").reset_index()
    yield (
        "Spearman's rank correlation of the simulated with the published order, level by level and of the means, with "
        "its standard error over flights:\n"
    )
    yield markdown(wide.fillna(""))
    yield (
        "b and f span the same functions beside the orientation, so an exact adjustment cannot tell them apart; the "
        "paper's figures for them differ by up to 0.2 um. What is fitted and what is not: section 5.\n"
    )
    away = found.table.assign(away=found.table["published_um"] - found.table["sim_um"])
    by_set = away.groupby("set")["away"].agg(["mean", "min", "max"]).loc[list(SETS)].reset_index()
    yield "Published less simulated, um, over all cases and levels: the order agrees, the amounts do so less.\n"
    yield markdown(by_set, dict.fromkeys(("mean", "min", "max"), "+.2f"))


def _system(found: ZiemannFindings) -> Iterator[str]:
    yield "## 3  With the system's distortion removed first\n"
    yield (
        "Step 2: the mean residual of the adjustment without parameters, in cells of 23 mm over all images of a "
        "flight, is taken off the image points. What the sets can find afterwards:\n"
    )
    rows = found.beyond[found.beyond["system"]]
    wide = rows.pivot_table(index=["camera", "field", "level"], columns="model", values="sim_um").reset_index()
    wide = wide[["camera", "field", "level", *SETS.values()]]
    yield markdown(wide, dict.fromkeys(SETS.values(), ".2f"))
    spread = (wide[list(SETS.values())].max(axis=1) - wide[list(SETS.values())].min(axis=1)).max()
    yield (
        f"The sets then differ by {spread:.2f} um at most: they compete for the same thing, the distortion that all "
        "images have in common. The cells also take up noise, which makes these figures smaller than any of section "
        "1.\n"
    )


def _others(found: ZiemannFindings) -> Iterator[str]:
    yield "## 4  Sets that the paper does not have\n"
    rows = found.beyond[~found.beyond["system"]]
    wide = rows.pivot_table(index="model", columns=["camera", "field"], values="sim_um", sort=False)
    wide.columns = pd.Index([", ".join(pair) for pair in wide.columns.to_list()])
    numbers = [len(model_of(str(name)).parameters) for name in wide.index]
    shown = wide.reset_index()
    shown.insert(1, "parameters", numbers)
    yield f"Level {max(reseau.LEVELS)}; brown1976 without a19, a20, a21, its interior orientation.\n"
    yield markdown(shown, dict.fromkeys(shown.columns[2:], ".2f"))


def _world(found: ZiemannFindings) -> Iterator[str]:
    yield "## 5  The simulated world\n"
    yield (
        "One world for all sets; the sources are silent about lenses, film and noise, so these are assumed. Fitted: "
        "each lens's amplitude in each field, to the published `none`; the image noise, to the best set n; the film, "
        "to the fall from level to level; and the shapes of the lenses to the order of the sets (for the RC8R the "
        "ratios of the powers of the radius, of the decentering and of a cubic film term, for the RMK-AR that it is "
        "mostly decentering). So agreement of the orders is no evidence for this world. What can be learnt: one lens "
        "curve of an ordinary kind is enough to bring about the order of 1982. It takes decentering to do it: the "
        "reconstructed set k takes up any smooth radial curve entirely, and even so it does better here than the "
        "paper's k. The published difference between none and n is twice as large at Rheidt as at Jamijarvi for the "
        "RC8; why is not known, and here the lens has two amplitudes.\n"
    )
    yield (
        f"Beyond the scenarios: {len(reseau.CROSSES_MM)} x {len(reseau.CROSSES_MM)} crosses, {reseau.SPACING_MM:g} "
        f"mm apart, each coordinate measured to {reseau.CROSS_NOISE_UM:g} um; local film deformation of "
        + ", ".join(f"{um:g} um ({camera})" for camera, um in reseau.LOCAL_UM.items())
        + f" rms a coordinate, with wavelengths of {reseau.WAVELENGTH_MM[0]:g} to "
        f"{reseau.WAVELENGTH_MM[1]:g} mm, new in every image.\n"
    )
    for world in found.worlds.values():
        yield f"### Preset `{world.scenario.name}`, seed {world.seed}\n"
        yield scenario_page(world.scenario)


def _closing(command: str) -> Iterator[str]:
    yield "## 6  Again\n"
    yield f"    {command}\n"
    yield (
        "writes this folder; the figures do not depend on the number of processes. `table.csv` has section 1, "
        "`ranks.csv` section 2, `beyond.csv` sections 3 and 4; `provenance.json` version, commit, parameters, "
        "packages and duration.\n"
    )
