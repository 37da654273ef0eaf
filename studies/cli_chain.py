"""The commands of the measurement chain: reduce, and what `simulate --raw` does."""

from __future__ import annotations

from pathlib import Path

import click

FOLDER = click.Path(file_okay=False, path_type=Path)
RAW_FOLDER = click.Path(exists=True, file_okay=False, path_type=Path)
REDUCTIONS = ("drift", "comparator", "lens", "refraction", "curvature")


def register(main: click.Group) -> None:
    """Add the commands of this module."""
    main.add_command(reduce)


@click.command()
@click.argument("raw", metavar="RAW_DIR", type=RAW_FOLDER)
@click.option("-o", "--out", "folder", type=FOLDER, required=True, help="Block folder to write.")
@click.option(
    "--inner",
    type=click.Choice(["helmert", "affine", "bilinear", "projective"]),
    default="affine",
    show_default=True,
    help="Transformation on the fiducial marks.",
)
@click.option("--reseau", type=click.IntRange(1, 5), help="Degree of the reseau correction.  [default: none]")
@click.option("--without", type=click.Choice(REDUCTIONS), multiple=True, help="A reduction to leave out.")
@click.option("--threshold", type=click.FloatRange(0.0), default=15.0, show_default=True, help="Double settings, um.")
def reduce(
    raw: Path, folder: Path, inner: str, reseau: int | None, without: tuple[str, ...], threshold: float
) -> None:
    """Reduce comparator coordinates (`simfield simulate --raw`) to a block folder; say what was removed."""
    from simfield.block_folder import BlockFolderError
    from studies.reduction import Plan, reduce_folder

    wanted = {name: name not in without for name in REDUCTIONS}
    plan = Plan(inner=inner, threshold_um=threshold, reseau_degree=reseau, **wanted)  # type: ignore[arg-type]
    try:
        click.echo(reduce_folder(raw, folder, plan))
    except (BlockFolderError, ValueError) as error:
        failure = click.ClickException(str(error))
        failure.exit_code = 1
        raise failure from error
