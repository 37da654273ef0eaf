"""The command that makes the report of a folder of results."""

from __future__ import annotations

from pathlib import Path

import click

from studies.commands.arguments import EXISTING

PAGE = click.Path(dir_okay=False, path_type=Path)


@click.command()
@click.argument("folder", metavar="DIR", type=EXISTING)
@click.option("-o", "--out", type=PAGE, help="File to write.  [default: DIR/report.html]")
def report(folder: Path, out: Path | None) -> None:
    """Make one HTML file of a folder of results: of a study, a reproduction, or the error budget.

    The file needs nothing beside it, holds no script and is the same, byte for byte, for the same results.
    """
    from simfield.files import write_whole
    from studies.commands.exits import Failure, StoreFailure
    from studies.pages import report as made
    from studies.store import StoreError
    from studies.summary import NothingToReportError

    path = out if out is not None else folder / "report.html"
    try:
        page = made(folder)
    except NothingToReportError as error:
        raise click.UsageError(str(error)) from error
    except StoreError as error:
        raise StoreFailure(str(error)) from error
    except OSError as error:
        raise Failure(f"{error.filename or folder}: cannot be read: {error.strerror or error}") from error
    try:
        write_whole(path, page.encode())
    except OSError as error:
        raise Failure(f"{error.filename or path}: cannot be written: {error.strerror or error}") from error
    click.echo(path)
