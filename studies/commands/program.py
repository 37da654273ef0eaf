"""The command line. Results go to stdout, progress and messages to stderr.

Exit 0 done, 1 the data or the computation failed, 2 wrong call or wrong file, 130 and 143 on signals. Everything heavy
is imported inside the commands, so that --help answers at once.
"""

from __future__ import annotations

import signal
import sys
import threading
from typing import TYPE_CHECKING, Any, NoReturn

import click

from studies.commands import (
    chain as cli_chain,
    quality as cli_quality,
    report as cli_report,
    studies as cli_studies,
    teach as cli_teach,
)
from studies.session import installation

if TYPE_CHECKING:
    pass
from studies.commands.exits import Failure


def stages() -> tuple[str, ...]:
    """The stages of the measurement chain."""
    from simfield.chain import STAGES

    return tuple(STAGES)


def further_tables() -> tuple[str, ...]:
    """The further observations of a block."""
    from simfield.block import TABLES

    return TABLES


def owners_of_sets() -> tuple[str, ...]:
    """Whose sets of additional parameters there may be."""
    from adjust.model import CHOICES

    return CHOICES


class Program(click.Group):
    """A group of commands that ends on a signal with the exit code a shell expects."""

    def invoke(self, ctx: click.Context) -> Any:
        if threading.current_thread() is threading.main_thread():
            signal.signal(signal.SIGTERM, _terminated)
        try:
            return super().invoke(ctx)
        except KeyboardInterrupt:
            click.echo("interrupted", err=True)
            raise click.exceptions.Exit(130) from None


def _terminated(number: int, frame: object) -> NoReturn:
    click.echo("terminated", err=True)
    raise SystemExit(143)


@click.group(cls=Program, context_settings={"help_option_names": ["-h", "--help"]})
@click.version_option(package_name="simfield", prog_name="simfield")
@click.pass_context
def main(ctx: click.Context) -> None:
    """Simulated photogrammetric test fields, self-calibrating bundle adjustment, and Monte-Carlo studies."""
    if ctx.invoked_subcommand != "doctor":
        for sentence in installation.shadows():
            raise Failure(f"{sentence}; `simfield doctor` says more")


cli_studies.register(main)


cli_chain.register(main)


cli_quality.register(main)


cli_report.register(main)


cli_teach.register(main)


@main.command()
def doctor() -> None:
    """Say whether this installation is sound: packages, where they are, versions."""
    click.echo(f"python {sys.version.split()[0]} at {sys.executable}")
    click.echo(f"packages in {installation.home()}")
    for name, version in installation.versions().items():
        click.echo(f"{name:<14} {version}")
    found = installation.shadows()
    for sentence in found:
        click.echo(sentence)
    if found:
        raise Failure("another package stands in the way; install simfield in an environment of its own")
    missing = [name for name, version in installation.versions().items() if version == "missing"]
    if missing:
        raise Failure(f"missing: {', '.join(missing)}; pip install {' '.join(missing)}")
    click.echo("all is well")
