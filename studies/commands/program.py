"""The command line. Results go to stdout, progress and messages to stderr.

Exit 0 done, 1 the data or the computation failed, 2 wrong call or wrong file, 130 and 143 on signals. Everything heavy
is imported inside the commands, so that --help answers at once.
"""

from __future__ import annotations

import signal
import sys
import threading
from typing import Any, NoReturn

import click

from studies.commands.blocks import adjust, check, simulate
from studies.commands.chain import budget, reduce
from studies.commands.exits import Failure
from studies.commands.experiments import detection, reproduce
from studies.commands.report import report
from studies.commands.sets import models
from studies.commands.studies import replay, run, studies, verify
from studies.commands.teach import teach
from studies.session import installation


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


for command in (
    *(
        adjust,
        check,
        budget,
        detection,
        models,
        reduce,
        replay,
        report,
        reproduce,
        run,
        simulate,
        studies,
        teach,
        verify,
    ),
):
    main.add_command(command)
