"""The commands of blocks: simulate, adjust and check."""

from __future__ import annotations

import json
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from studies.commands.late_choice import LateChoice

if TYPE_CHECKING:
    from adjust import Adjustment
    from adjust.model import ApBy
from studies.commands.arguments import EXISTING, FOLDER, model_of
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


@click.command()
@click.argument("folder", metavar="BLOCK_DIR", type=EXISTING)
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
    from adjust import ByControl, InnerConstraints, MinimumControl, adjust_block
    from adjust.plausibility import checked
    from simfield.files import BlockFolderError, read_block
    from studies.protocol import adjustment_page

    model = model_of(model_id, settings)
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
    findings = checked(a)
    if json_path is not None:
        table = {**adjustment_page.record(a), "findings": [each.as_table() for each in findings]}
        _write_json(table, json_path)
    said = [f"probably wrong: {f.place}: {f.text}" for f in findings if f.kind != "adjustment" and f.severity != "note"]
    if not a.status.ok:
        raise Failure("; ".join([a.message, *said[:1]]))
    for line in said:
        click.echo(line, err=True)
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


@click.command()
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
    from studies.commands import simulation

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


@click.command()
@click.argument("folder", metavar="BLOCK_DIR", type=EXISTING)
@click.option("--ap", "model_id", metavar="ID", default="none", show_default=True, help="Additional parameters.")
@click.option("--json", "json_path", metavar="FILE|-", help="Write the findings as JSON to a file, or to stdout (-).")
def check(folder: Path, model_id: str, json_path: str | None) -> None:
    """Say what is probably wrong with a block: units, axes, names, control, stations, starts.

    The block is adjusted on the way; nothing is written or changed. Exit 1 if a finding makes a result worthless.
    """
    from adjust import adjust_block
    from adjust.plausibility import checked
    from simfield.files import BlockFolderError, read_block

    model = model_of(model_id, ())
    try:
        found = checked(adjust_block(read_block(folder), model))
    except BlockFolderError as error:
        raise Failure(str(error)) from error
    except ValueError as error:  # what the folder states does not fit the model
        raise Failure(str(error)) from error
    if json_path is not None:
        _write_json({"findings": [each.as_table() for each in found]}, json_path)
    if json_path != "-":
        for each in found:
            click.echo(f"{each.severity}: {each.place}: {each.text}. {each.advice[:1].upper()}{each.advice[1:]}.")
        if not found:
            click.echo("nothing found")
    worthless = sum(each.severity == "worthless" for each in found)
    if worthless:
        raise Failure(f"{worthless} of {len(found)} findings make a result worthless")


def _write_json(record: dict[str, Any], path: str) -> None:
    from simfield.files import write_whole

    text = json.dumps(record, indent=1, allow_nan=False, ensure_ascii=False)
    if path == "-":
        click.echo(text)
        return
    try:
        write_whole(Path(path), f"{text}\n".encode())
    except OSError as error:
        raise click.UsageError(f"{path} cannot be written: {error.strerror}") from error


def _write_protocol(a: Adjustment, folder: Path, quiet: bool) -> None:
    from studies.protocol import files as protocol_files

    try:
        files = protocol_files.write(a, folder)
    except OSError as error:
        raise Failure(f"{error.filename or folder}: cannot be written: {error.strerror}") from error
    for path in files:
        click.echo(path, err=quiet)
