"""The commands of the measurement chain: reduce and budget."""

from __future__ import annotations

import math
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import click

from studies.commands.arguments import EXISTING, FOLDER
from studies.commands.late_choice import LateChoice

if TYPE_CHECKING:
    from adjust.reductions import ReducedBlock, ReductionPlan


def reduction_names() -> tuple[str, ...]:
    """The reductions that can be left out."""
    from adjust.reductions import REDUCTIONS

    return REDUCTIONS


def inner_kinds() -> tuple[str, ...]:
    """The transformations on fiducial marks."""
    from adjust.reductions import PARAMETERS

    return tuple(PARAMETERS)


@click.command()
@click.argument("raw", metavar="RAW_DIR", type=EXISTING)
@click.option("-o", "--out", "folder", type=FOLDER, required=True, help="Block folder to write.")
@click.option(
    "--inner",
    type=LateChoice(inner_kinds),
    default="helmert",
    show_default=True,
    help="Transformation on the fiducial marks.",
)
@click.option("--reseau", type=click.IntRange(1, 5), help="Degree of the reseau correction.  [default: none]")
@click.option("--without", type=LateChoice(reduction_names), multiple=True, help="A reduction to leave out.")
@click.option("--threshold", type=click.FloatRange(0.0), default=15.0, show_default=True, help="Double settings, um.")
def reduce(raw: Path, folder: Path, inner: str, reseau: int | None, without: tuple[str, ...], threshold: float) -> None:
    """Reduce comparator coordinates (`simfield simulate --raw`) to a block folder; say what was removed."""
    from adjust import reductions
    from simfield.files import BlockFolderError, read_raw, write_block

    wanted = {name: name not in without for name in reductions.REDUCTIONS}
    plan = reductions.ReductionPlan(inner=inner, threshold_um=threshold, reseau_degree=reseau, **wanted)  # type: ignore[arg-type]
    try:
        done = reductions.reduce(read_raw(raw), plan)
        write_block(done.block, folder)
    except (BlockFolderError, ValueError) as error:
        raise click.ClickException(str(error)) from error
    for line in _removed(folder, done, plan):
        click.echo(line)


@click.command()
@click.option("--out", type=FOLDER, default="results/error-budget", show_default=True, help="Folder to write.")
@click.option("--trials", type=click.IntRange(2), default=500, show_default=True, help="Measured flights a stage.")
@click.option("--seed", type=click.IntRange(0), default=1980, show_default=True, help="Seed of all that is random.")
def budget(out: Path, trials: int, seed: int) -> None:
    """Say how much every stage of the measurement chain puts into images and check points."""
    from studies.experiments import error_budget_page

    try:
        for path in error_budget_page.write(out, trials, seed):
            click.echo(path)
    except (ArithmeticError, ValueError, OSError) as error:
        raise click.ClickException(str(error)) from error


def _removed(folder: Path, done: ReducedBlock, plan: ReductionPlan) -> Iterator[str]:
    """What was removed, in a few lines."""
    yield f"{folder}: {len(done.block.images)} images, {len(done.block.observations)} image points"
    for name, value in done.rms_um.items():
        yield f"  {name:<18} {value:8.2f} um removed (rms of a coordinate)"
    if math.isfinite(done.double.sigma_um):
        beyond = f"{int(done.double.doubtful.sum())} differences beyond {plan.threshold_um:g} um"
        yield f"  one setting        {done.double.sigma_um:8.2f} um, {beyond}"
    if math.isfinite(done.inner.rms_um):
        yield f"  fiducial residuals {done.inner.rms_um:8.2f} um ({done.inner.kind})"
