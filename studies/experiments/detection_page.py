"""Size and power of the search for gross errors as tables, a figure and a report: `simfield detection`."""

from __future__ import annotations

import json
import time
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import pandas as pd

from adjust import ApModel
from adjust.quality import ALPHA, familywise
from simfield.block import Block
from simfield.files import make_folder, whole_folder
from simfield.numerics import one_thread
from studies.experiments.detection import detection, many_at_once, search_of_blocks
from studies.figures import BLACK, BLUE, GREY, VERMILION, house_style, new_figure, save
from studies.session import progress_bar, provenance
from studies.texts import markdown, write_csv

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SIZES = (0.0, 4.0, 5.0, 6.0, 8.0, 10.0, 12.0, 16.0, 20.0)
"""of one planted error, in standard deviations of its observation"""
SHARES = (0.005, 0.02, 0.05, 0.1)
"""of all coordinates that are wrong at once"""
FAMILY_ALPHA = 0.05
"""level of all tests of an adjustment together"""
STANDARD_ERRORS = 3.0
SAYS = (
    "How often gross errors are found",
    "Left: share of trials in which a planted error is found, rising with its size, on top of theory. Right: rms error "
    "of the points over the share of wrong coordinates; least squares grows, the robust methods stay low.",
)
"""title and description of the figure, for those who cannot see it"""
OUTCOMES = ("found", "missed", "wrongly_accused", "power")
RATES = (*OUTCOMES, *(f"{name}_mcse" for name in OUTCOMES), "power_theory")
FORMATS = {
    "level": ".3g",
    "size_sigma": ".0f",
    "trials": ".0f",
    **dict.fromkeys(RATES, ".4f"),
    "false_alarms": ".3e",
    "false_alarms_mcse": ".1e",
}
SEARCH_FORMATS = {"n": ".0f", "share": ".4f", "share_mcse": ".4f", "stated": ".2f"}
MANY_FORMATS = {
    "share": ".3f",
    "found": ".4f",
    "found_mcse": ".4f",
    "accused_wrongly": ".2e",
    "accused_wrongly_mcse": ".1e",
    "point_rms_m": ".4f",
    "point_rms_m_mcse": ".4f",
}


@dataclass(frozen=True, eq=False)
class DetectionFindings:
    """one: a row a level and size; many: a row a share and method; search: three rows, the search of the protocol in
    blocks with their own errors; and what was adjusted.
    """

    block: Block
    model: ApModel
    one: pd.DataFrame
    many: pd.DataFrame
    search: pd.DataFrame


OLDER = ("report.html",)
"""what `simfield report` made of older results"""


@dataclass(frozen=True)
class DetectionTrials:
    """How many: trials with one wrong error, contests with many, blocks that are searched; and the seed of all."""

    trials: int
    contests: int
    blocks: int
    seed: int


def find(block: Block, drawn: Callable[[int], Block], model: ApModel, of: DetectionTrials) -> DetectionFindings:
    """One error at a time at two levels, the errors the same at both, many at once, and the search of the protocol in
    blocks drawn by their number. Raises ValueError for a block that cannot be adjusted.
    """
    levels = (ALPHA, familywise(FAMILY_ALPHA, 2 * len(block.observations)))
    one, many = [], []
    with one_thread(), progress_bar(len(levels) * len(SIZES) + len(SHARES) + of.blocks, "tables and blocks") as bar:
        for level in levels:
            for size in SIZES:
                one.append(detection(block, model, of.trials, of.seed, (size,), level))
                bar.update()
        for share in SHARES:
            table = many_at_once(block, model, share, of.contests, of.seed, FAMILY_ALPHA)
            table.insert(0, "share", share)
            many.append(table)
            bar.update()

        def blocks() -> Iterator[Block]:
            for number in range(of.blocks):
                yield drawn(number)
                bar.update()

        search = search_of_blocks(blocks(), model, of.seed)
    return DetectionFindings(
        block, model, _ordered(pd.concat(one, ignore_index=True)), pd.concat(many, ignore_index=True), search
    )


def write(
    folder: Path, block: Block, drawn: Callable[[int], Block], model: ApModel, of: DetectionTrials, source: str
) -> list[Path]:
    """Compute everything and write it, as one; the files. source: the block in words. Raises ValueError, OSError."""
    make_folder(folder)
    start = time.perf_counter()
    found = find(block, drawn, model, of)
    parameters = {"block": source, "ap": model.id, **asdict(of)}
    options = " ".join(f"--{name} {value}" for name, value in parameters.items() if name != "block")
    command = f"simfield detection {source} {options}"
    said = provenance(command, parameters, time.perf_counter() - start)
    with whole_folder(folder, OLDER) as new:
        write_csv(found.one, new / "detection.csv", FORMATS)
        write_csv(found.many, new / "many-at-once.csv", MANY_FORMATS)
        write_csv(found.search, new / "protocol-search.csv", SEARCH_FORMATS)
        (new / "report.md").write_text(page(found, command, of), encoding="utf-8")
        with house_style():
            figure = new_figure(180.0, 85.0)
            left, right = figure.subplots(1, 2)
            draw_power(left, found.one)
            draw_many(right, found.many)
            figures = save(figure, new / "detection", *SAYS)
        (new / "provenance.json").write_text(json.dumps(said, indent=1) + "\n", encoding="utf-8")
    names = ("detection.csv", "many-at-once.csv", "protocol-search.csv", "report.md", "provenance.json")
    return [folder / name for name in (*names, *(path.name for path in figures))]


def worst_deviation(one: pd.DataFrame) -> tuple[float, float]:
    """The largest deviation from theory of the power and of the false alarms, in Monte-Carlo standard errors; the
    false alarms of trials without a gross error.
    """
    power = ((one["power"] - one["power_theory"]) / one["power_mcse"]).abs().max()
    clean = one[one["size_sigma"] == 0.0]
    return float(power), float(((clean["false_alarms"] - clean["level"]) / clean["false_alarms_mcse"]).abs().max())


def draw_power(axes: Axes, one: pd.DataFrame) -> None:
    """Power beside theory for both levels, with 95 % Monte-Carlo intervals, and the share found at the common level."""
    for (level, rows), colour in zip(one.groupby("level", sort=False), (BLUE, VERMILION), strict=True):
        axes.plot(rows["size_sigma"], rows["power_theory"], color=colour, label=f"theory, level {float(level):.1e}")  # type: ignore[arg-type]
        axes.errorbar(
            rows["size_sigma"], rows["power"], 1.96 * rows["power_mcse"], fmt="o", ms=4, color=colour, label="simulated"
        )
    strict = one[one["level"] == one["level"].min()]
    axes.plot(strict["size_sigma"], strict["found"], "x", color=BLACK, label="found first, lower level")
    axes.set_xlabel("planted error, standard deviations")
    axes.set_ylabel("share of trials")
    axes.set_ylim(-0.02, 1.04)
    axes.legend(loc="lower right")


def draw_many(axes: Axes, many: pd.DataFrame) -> None:
    """What is left in the points, by method, over the share of wrong coordinates."""
    colours = {"none": GREY, "data snooping": BLUE, "Huber": "#e69f00", "Danish": "#009e73", "Cauchy": "#cc79a7"}
    for method, rows in many.groupby("method", sort=False):
        label = "least squares" if method == "none" else str(method)
        axes.errorbar(
            100.0 * rows["share"],
            1000.0 * rows["point_rms_m"],
            1960.0 * rows["point_rms_m_mcse"],
            marker="o",
            ms=3,
            color=colours[str(method)],
            label=label,
        )
    axes.set_xlabel("wrong coordinates, %")
    axes.set_ylabel("rms error of a point coordinate, mm")
    axes.set_ylim(bottom=0.0)
    axes.legend(loc="upper left")


def page(found: DetectionFindings, command: str, of: DetectionTrials) -> str:
    """The report in Markdown."""
    power, alarms = worst_deviation(found.one)
    within = max(power, alarms) <= STANDARD_ERRORS
    verdict = "as theory says" if within else "**not as theory says**"
    return (
        "# How often gross errors are found\n\n"
        f"`{command}`: {2 * len(found.block.observations)} image coordinates, parameters of {found.model.id}.\n\n"
        "## One wrong coordinate\n\n"
        f"{of.trials} trials a row; in each one coordinate, chosen at random, is wrong by size_sigma standard "
        "deviations, all others have normal errors of the stated standard deviations. found: the wrong coordinate has "
        "the largest |w|, above the critical value; wrongly_accused: another has it; missed: none is above. power: its "
        "own |w| is above, beside Baarda's theory for its redundancy number. false_alarms: share of right coordinates "
        "above. mcse: Monte-Carlo standard errors. The second level is 5 % for all tests together.\n\n"
        f"{markdown(found.one, FORMATS)}\n"
        f"Largest deviation from theory, in Monte-Carlo standard errors: power {power:.1f}, false alarms without a "
        f"gross error {alarms:.1f}: {verdict} (bound {STANDARD_ERRORS:g}).\n\n"
        "## The search of the protocol\n\n"
        f"{of.blocks} blocks drawn anew from the scenario, with the noise that it has and not that which is stated; "
        "first as they are, then with one coordinate wrong by the minimal detectable bias that the protocol prints for "
        "it. Shares of the blocks: anybody is accused; the test of the wrong coordinate exceeds its critical value; "
        "this coordinate is accused, and not another one with nearly the same test. stated: what the protocol "
        "promises, which does not say which of two such coordinates it names. Scenarios with systematic errors that "
        "the set of additional parameters cannot follow accuse more.\n\n"
        f"{markdown(found.search, SEARCH_FORMATS)}\n"
        "## Many at once\n\n"
        f"{of.contests} trials a row; a share of all coordinates is wrong by 6 to 20 standard deviations; "
        f"{FAMILY_ALPHA:.0%} for all tests together. found: share of the wrong ones that are accused; accused_wrongly: "
        "share of the right ones; point_rms_m: rms error of the adjusted coordinates.\n\n"
        f"{markdown(found.many, MANY_FORMATS)}\n"
        "![detection](detection.png)\n"
    )


def _ordered(one: pd.DataFrame) -> pd.DataFrame:
    return one[["level", *(name for name in one.columns if name != "level")]]
