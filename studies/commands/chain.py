"""The commands of the measurement chain: reduce and budget."""

from __future__ import annotations

from pathlib import Path

import click
import numpy as np

from adjust.reductions import Plan, reduce
from simfield import write_block
from simfield.files import read_raw
from studies.commands.late_choice import LateChoice

FOLDER = click.Path(file_okay=False, path_type=Path)
RAW_FOLDER = click.Path(exists=True, file_okay=False, path_type=Path)


def switches() -> tuple[str, ...]:
    """The reductions that can be left out."""
    from adjust.reductions import SWITCHES

    return SWITCHES


def inner_kinds() -> tuple[str, ...]:
    """The transformations on fiducial marks."""
    from adjust.reductions import PARAMETERS

    return tuple(PARAMETERS)


def register(main: click.Group) -> None:
    """Add the commands of this module."""
    main.add_command(reduce)
    main.add_command(budget)


@click.command()
@click.argument("raw", metavar="RAW_DIR", type=RAW_FOLDER)
@click.option("-o", "--out", "folder", type=FOLDER, required=True, help="Block folder to write.")
@click.option(
    "--inner",
    type=LateChoice(inner_kinds),
    default="affine",
    show_default=True,
    help="Transformation on the fiducial marks.",
)
@click.option("--reseau", type=click.IntRange(1, 5), help="Degree of the reseau correction.  [default: none]")
@click.option("--without", type=LateChoice(switches), multiple=True, help="A reduction to leave out.")
@click.option("--threshold", type=click.FloatRange(0.0), default=15.0, show_default=True, help="Double settings, um.")
def reduce(raw: Path, folder: Path, inner: str, reseau: int | None, without: tuple[str, ...], threshold: float) -> None:
    """Reduce comparator coordinates (`simfield simulate --raw`) to a block folder; say what was removed."""
    from adjust.reductions import SWITCHES, Plan
    from simfield.files import BlockFolderError

    wanted = {name: name not in without for name in SWITCHES}
    plan = Plan(inner=inner, threshold_um=threshold, reseau_degree=reseau, **wanted)  # type: ignore[arg-type]
    try:
        click.echo(reduce_folder(raw, folder, plan))
    except (BlockFolderError, ValueError) as error:
        raise click.ClickException(str(error)) from error


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


def reduce_folder(raw_folder: Path, folder: Path, plan: Plan) -> str:
    """Reduce a measured file and write the block folder; a few lines that say what was removed.

    Raises BlockFolderError for a folder that cannot be read or written and ValueError for one that cannot be reduced.
    """
    done = reduce(read_raw(raw_folder), plan)
    write_block(done.block, folder)
    lines = [f"{folder}: {len(done.block.images)} images, {len(done.block.observations)} image points"]
    lines += [f"  {name:<18} {value:8.2f} um removed (rms of a coordinate)" for name, value in done.rms_um.items()]
    if np.isfinite(done.double.sigma_um):
        doubtful = int(done.double.doubtful.sum())
        lines.append(
            f"  one setting        {done.double.sigma_um:8.2f} um, {doubtful} differences beyond "
            f"{plan.threshold_um:g} um"
        )
    sigma = done.inner.sigma0_um
    if np.isfinite(sigma).any():
        lines.append(f"  fiducial residuals {np.sqrt(np.nanmean(sigma**2)):8.2f} um ({done.inner.kind})")
    return "\n".join(lines)
