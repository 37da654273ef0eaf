"""The command that opens the lessons: teach. Needs the extra `teach`."""

from __future__ import annotations

from importlib.util import find_spec

import click

from studies.commands.exits import Failure

INSTALL = "pip install 'simfield[teach]'"


@click.command()
@click.option("--port", type=click.IntRange(0, 65535), default=0, help="Port on 127.0.0.1.  [default: a free one]")
@click.option(
    "--browser/--no-browser", default=True, show_default=True, help="Open the page, or print its address only."
)
def teach(port: int, browser: bool) -> None:
    """Open the lessons in the browser: a question each, a few controls, an answer at once.

    The server is reached from this machine only, by the address with its token that is printed.
    """
    if find_spec("marimo") is None:
        raise click.UsageError(f"the lessons need marimo: {INSTALL}")
    from studies.lessons import serve

    try:
        serve(port, browser=browser, say=lambda line: click.echo(line, err=not line.startswith("open ")))
    except OSError as error:
        raise Failure(f"port {port} of 127.0.0.1 cannot be taken: {error.strerror or error}") from error
