"""The command line. Results go to stdout, progress and messages to stderr.

Exit 0 done, 1 the data or the computation failed, 2 wrong call or wrong file, 130 and 143 on signals. Everything heavy
is imported inside the commands, so that --help answers at once.
"""

from __future__ import annotations

import json
import signal
import sys
import threading
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

import click

from studies import cli_chain, cli_quality, cli_report, cli_studies, cli_teach, installation
from studies.late_choice import LateChoice

if TYPE_CHECKING:
    from adjust import Adjustment, ApModel
    from adjust.ap_sets import ApBy

DEFAULT_TRIALS = 200
DEFAULT_SEED = 1980
FOLDER = click.Path(file_okay=False, path_type=Path)
BLOCK_FOLDER = click.Path(exists=True, file_okay=False, path_type=Path)


def stages() -> tuple[str, ...]:
    """The stages of the measurement chain."""
    from simfield.chain import STAGES

    return tuple(STAGES)


def further_tables() -> tuple[str, ...]:
    """The further observations of a block."""
    from simfield.further import TABLES

    return TABLES


def owners_of_sets() -> tuple[str, ...]:
    """Whose sets of additional parameters there may be."""
    from adjust.ap_sets import CHOICES

    return CHOICES


class Failure(click.ClickException):
    """The data or the computation failed: one line, exit 1."""

    exit_code = 1


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


@main.command()
@click.argument("what", metavar="EXPERIMENT", type=click.Choice(["mauelshagen-1980", "ziemann-1982"]))
@click.option("--out", type=FOLDER, help="Folder for the results.  [default: results/EXPERIMENT]")
@click.option("--trials", type=click.IntRange(2), default=DEFAULT_TRIALS, show_default=True, help="Simulated flights.")
@click.option("--jobs", type=click.IntRange(1), help="Processes.  [default: one a core]")
@click.option(
    "--seed", type=click.IntRange(0), default=DEFAULT_SEED, show_default=True, help="Seed of all that is random."
)
@click.option("--world", type=click.Choice(["twin"]), help="Fit worlds in which the published table of 1980 happens.")
def reproduce(what: str, out: Path | None, trials: int, jobs: int | None, seed: int, world: str | None) -> None:
    """Fly and adjust a published experiment; write its tables and figures beside the published ones."""
    if world == "twin" and what != "mauelshagen-1980":
        raise click.UsageError("--world twin belongs to mauelshagen-1980")
    if world == "twin":
        from studies import twin_1980 as experiment
    elif what == "ziemann-1982":
        from studies import reproduce_1982 as experiment  # type: ignore[no-redef]
    else:
        from studies import reproduce_1980 as experiment  # type: ignore[no-redef]

    folder = out if out is not None else Path("results") / (f"{what}-{world}" if world else what)
    try:
        done = experiment.reproduce(folder, trials=trials, jobs=jobs, seed=seed)
    except experiment.ReproductionError as error:
        raise Failure(str(error)) from error
    except OSError as error:
        raise Failure(f"{error.filename or folder}: cannot be written: {error.strerror}") from error
    for path in done.files:
        click.echo(path)
    for line in done.failures:
        click.echo(line, err=True)
    if done.failures:
        raise Failure(f"{len(done.failures)} adjustments failed; the report counts and names them")


@main.command()
@click.argument("folder", metavar="BLOCK_DIR", type=BLOCK_FOLDER)
@click.option(
    "--ap", "model_id", metavar="ID", required=True, help="Additional parameters; `simfield models` lists them."
)
@click.option(
    "--set", "settings", metavar="NAME=VALUE", multiple=True, help="A setting of the model, such as r0_mm=100."
)
@click.option("--json", "json_path", metavar="FILE|-", help="Write everything as JSON to a file, or to stdout (-).")
@click.option("-o", "--out", type=FOLDER, help="Folder for the protocol: text, JSON, observations and correlations.")
@click.option(
    "--datum",
    type=click.Choice(["control", "minimum", "inner"]),
    default="control",
    show_default=True,
    help="What ties the block to its frame: its control, seven coordinates, or inner constraints (a free network).",
)
@click.option(
    "--leave-out",
    type=LateChoice(further_tables),
    multiple=True,
    help="Further observations of the folder that are not used; may be given more than once.",
)
@click.option(
    "--ap-by",
    type=LateChoice(owners_of_sets),
    default="camera",
    show_default=True,
    help="Whose sets of additional parameters; a finer choice is tested against one set a camera.",
)
def adjust(
    folder: Path,
    model_id: str,
    settings: tuple[str, ...],
    json_path: str | None,
    out: Path | None,
    datum: str,
    leave_out: tuple[str, ...],
    ap_by: ApBy,
) -> None:
    """Adjust a block folder by bundles with self-calibration, with all further observations that are in it."""
    from adjust import adjust_block
    from adjust.datum import ByControl, InnerConstraints, MinimumControl
    from simfield.block_folder import BlockFolderError, read_block
    from studies import adjustment_page

    model = _model(model_id, settings)
    try:
        block = read_block(folder)
    except BlockFolderError as error:
        raise Failure(str(error)) from error
    tied = {"control": ByControl, "minimum": MinimumControl, "inner": InnerConstraints}[datum]()
    try:
        block = block.without(*leave_out) if leave_out else block
        a = adjust_block(block, model, datum=tied, ap_by=ap_by)
    except ValueError as error:  # what the folder states does not fit the model
        raise Failure(str(error)) from error
    if json_path is not None:
        _write_json(adjustment_page.record(a), json_path)
    _refuse_failed(a)
    if out is not None:
        if (out / "cameras.csv").exists():
            raise click.UsageError(
                f"{out} holds a block, whose observations.csv the protocol would replace; name another folder"
            )
        _write_protocol(a, out, quiet=json_path == "-")
    elif json_path is None:
        click.echo(adjustment_page.page(a))
    if ap_by != "camera":
        coarse = adjust_block(block, model, datum=tied)
        click.echo(adjustment_page.sets_line(coarse, a, ap_by), err=json_path == "-")


@main.command()
@click.argument("source", metavar="PRESET|SCENARIO.toml")
@click.option("--seed", type=click.IntRange(0), required=True, help="Seed of all that is random.")
@click.option("--trial", type=click.IntRange(0), default=0, show_default=True, help="Number of the trial.")
@click.option("-o", "--out", "folder", type=FOLDER, required=True, help="Block folder to write.")
@click.option("--raw", is_flag=True, help="Write comparator coordinates with marks instead, for `simfield reduce`.")
@click.option(
    "--chain", default="psk-1969", show_default=True, help="Measurement chain of --raw: psk-1969, undisturbed."
)
@click.option(
    "--without", type=LateChoice(stages), multiple=True, help="A stage of the chain to leave out, with --raw."
)
def simulate(source: str, seed: int, trial: int, folder: Path, raw: bool, chain: str, without: tuple[str, ...]) -> None:
    """Fly a scenario; write the block folder a surveyor would hand over, and truth.json beside it."""
    from studies import simulation

    try:
        if without and not raw:
            raise click.UsageError("--without belongs to --raw: a block folder has no measurement chain")
        if raw:
            click.echo(simulation.write_measured(source, chain, seed, trial, folder, without))
            return
        click.echo(simulation.write(source, seed, trial, folder))
    except simulation.WrongScenarioError as error:
        raise click.UsageError(str(error)) from error
    except (simulation.SimulationError, OSError) as error:
        raise Failure(str(error)) from error


@main.command()
@click.argument("model_id", metavar="[ID]", required=False)
@click.option("--set", "settings", metavar="NAME=VALUE", multiple=True, help="A setting of the model.")
@click.option("--draw", type=click.Path(dir_okay=False, path_type=Path), help="Draw its terms (.svg, .png).")
def models(model_id: str | None, settings: tuple[str, ...], draw: Path | None) -> None:
    """List the sets of additional parameters, or describe one."""
    from studies import models_page

    if model_id is None:
        if draw is not None:
            raise click.UsageError("--draw needs the ID of a model")
        click.echo(models_page.table(), nl=False)
        return
    model = _model(model_id, settings)
    click.echo(models_page.describe(model), nl=False)
    if draw is None:
        return
    try:
        models_page.draw_fields(model, draw)
    except (ValueError, OSError) as error:
        raise click.UsageError(f"{draw} cannot be drawn: {error}") from error


def _model(model_id: str, settings: tuple[str, ...]) -> ApModel:
    from adjust import ap_models

    try:
        types = ap_models.get(model_id).settings
        return ap_models.get(model_id, **dict(_setting(text, types) for text in settings))
    except (KeyError, TypeError, ValueError) as error:
        raise click.UsageError(str(error.args[0])) from error


def _setting(text: str, defaults: dict[str, Any]) -> tuple[str, Any]:
    """NAME=VALUE with the value in the type of the default; an unknown name is left to the model to refuse."""
    name, equals, value = (part.strip() for part in text.partition("="))
    if not equals or not name or not value:
        raise click.UsageError(f"--set {text}: needed is NAME=VALUE, such as r0_mm=100")
    default = defaults.get(name, value)
    if isinstance(default, bool):
        if value.lower() not in ("true", "false"):
            raise click.UsageError(f"--set {text}: {name} is true or false")
        return name, value.lower() == "true"
    if isinstance(default, tuple):
        return name, tuple(part.strip() for part in value.split(","))
    try:
        return name, type(default)(value)
    except ValueError as error:
        raise click.UsageError(f"--set {text}: {value!r} is no {type(default).__name__}") from error


def _write_json(record: dict[str, Any], path: str) -> None:
    from simfield.whole_files import write_whole

    text = json.dumps(record, indent=1, allow_nan=False, ensure_ascii=False)
    if path == "-":
        click.echo(text)
        return
    try:
        write_whole(Path(path), f"{text}\n".encode())
    except OSError as error:
        raise click.UsageError(f"{path} cannot be written: {error.strerror}") from error


def _write_protocol(a: Adjustment, folder: Path, quiet: bool) -> None:
    from studies import protocol_files

    try:
        files = protocol_files.write(a, folder)
    except OSError as error:
        raise Failure(f"{error.filename or folder}: cannot be written: {error.strerror}") from error
    for path in files:
        click.echo(path, err=quiet)


def _refuse_failed(a: Adjustment) -> None:
    if not a.status.ok:
        raise Failure(a.message)
