"""The commands that run studies: run, studies, verify, replay.

Exit 3: a store that is damaged or belongs to another study; 75: another run holds it; others as in
studies.commands.program.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import TYPE_CHECKING, Any

import click

from studies.commands.arguments import EXISTING, FOLDER

if TYPE_CHECKING:
    from studies.design import Plan, Study
from studies.commands.exits import StoreFailure, exit_codes

SECONDS_AN_ADJUSTMENT = 2e-8
"""expected time of one adjusted trial for each image point, measured on one core of 2026 with blocks of 3300 of them"""


def _part(ctx: click.Context, parameter: click.Parameter, value: str | None) -> tuple[int, int] | None:
    if value is None:
        return None
    found = re.fullmatch(r"(\d{1,6})/(\d{1,6})", value)
    if not found or not 1 <= int(found[1]) <= int(found[2]):
        raise click.BadParameter("needed is I/N with I from 1 to N, such as 3/16")
    return int(found[1]), int(found[2])


@click.command()
@click.argument("source", metavar="NAME|STUDY.toml")
@click.option("--trials", type=click.IntRange(0, 10_000_000), help="Trials a condition.  [default: the study's]")
@click.option("--jobs", type=click.IntRange(1), help="Processes.  [default: one a core]")
@click.option("--out", type=FOLDER, help="Folder of the store and the results.  [default: results/NAME]")
@click.option("--seed", type=click.IntRange(0, 2**63 - 1), help="Seed.  [default: the study's]")
@click.option("--dry-run", is_flag=True, help="Print conditions, methods, blocks and the expected time; run nothing.")
@click.option("--backend", type=click.Choice(["joblib", "dask"]), default="joblib", show_default=True)
@click.option("--scheduler", metavar="ADDRESS", help="Of a running dask cluster, such as tcp://127.0.0.1:8786.")
@click.option("--shard", "part", metavar="I/N", callback=_part, help="Compute part I of N alone, for array jobs.")
@click.option("--other-program", is_flag=True, help="Go on with a store that another version has begun.")
@click.option("--trial-limit", type=click.FloatRange(1.0), default=60.0, show_default=True, help="Seconds for a trial.")
def run(
    source: str,
    trials: int | None,
    jobs: int | None,
    out: Path | None,
    seed: int | None,
    dry_run: bool,
    backend: str,
    scheduler: str | None,
    part: tuple[int, int] | None,
    other_program: bool,
    trial_limit: float,
) -> None:
    """Run a study, or go on where it was left; write summary, figures and report.

    What is in the folder and whole is kept; more trials, levels and methods may be added between runs.
    """
    if (backend == "dask") != (scheduler is not None):
        raise click.UsageError("--backend dask and --scheduler ADDRESS belong together")
    with exit_codes():
        from studies.design import shipped

        asked = shipped.study(source).with_changes(trials=trials, seed=seed)
        if dry_run:
            click.echo(_dry(asked))
            return
        folder = out if out is not None else Path("results") / asked.name
        options = {
            "jobs": jobs,
            "backend": backend,
            "scheduler": scheduler,
            "part": part,
            "other_program": other_program,
        }
        _run(asked, folder, options, trial_limit)


def _run(asked: Study, folder: Path, options: dict[str, Any], trial_limit: float) -> None:
    import os

    from studies.commands.exits import Failure
    from studies.run import How, run as run_study
    from studies.session import progress_bar

    jobs = options.pop("jobs") or os.cpu_count() or 1
    how = How(**{k: v for k, v in options.items() if v is not None}, jobs=jobs, trial_limit_s=trial_limit)
    bars: list[Any] = []

    def count(done: int, of: int, open_conditions: int) -> None:
        if not bars:
            bars.append(progress_bar(of, " trials"))
        bars[0].total = of
        bars[0].set_postfix_str(f"{open_conditions} conditions left", refresh=False)
        bars[0].update(done - bars[0].n)

    try:
        outcome = run_study(asked, folder, how, lambda line: click.echo(line, err=True), count)
    except (KeyboardInterrupt, SystemExit):
        click.echo(f"stopped; every finished block is kept in {folder}, the same command goes on from there", err=True)
        raise
    finally:
        for bar in bars:
            bar.close()
    for path in outcome.files:
        click.echo(path)
    for line in outcome.failures:
        click.echo(line, err=True)
    if outcome.failures:
        raise Failure(f"{len(outcome.failures)} cells or trials failed; the summary counts them")


def _dry(asked: Study) -> str:
    """Conditions, methods, blocks and expected time. Raises StudyError for what only the whole plan shows."""
    from simfield import build_world
    from studies.design import Plan, StudyError
    from studies.summary import measure_faults

    plan = Plan.of(asked)
    if faults := list(measure_faults(plan)):
        raise StudyError("\n".join(faults))
    lines = [f"{asked.name}: {asked.study.question.strip()}", ""]
    worlds = asked.trials.geometries
    more = "" if worlds == 1 else f" and {worlds - 1} more"
    lines += [f"{n:5} {c.id} {c}{more}" for n, c in enumerate(plan.conditions, start=1) if (c.geometry or 1) == 1]
    lines += ["", "methods", *(f"      {m.key}" for m in plan.methods), ""]
    sizes = []
    for condition in plan.firsts[:20]:
        try:
            sizes.append(len(build_world(condition.scenario, condition.seed).image))
        except (ArithmeticError, ValueError) as error:
            lines.append(f"condition {condition.id} cannot be simulated: {error}")
    conditions, methods = len(plan.conditions), len(plan.methods)
    cells = conditions * methods
    seconds = SECONDS_AN_ADJUSTMENT * (sum(sizes) / max(1, len(sizes))) * cells * plan.trials
    upto = "up to " if asked.trials.target_mcse else ""
    lines += [
        f"{len(plan.firsts)} conditions{f' in {worlds} geometries' if worlds > 1 else ''} x {methods} methods = "
        f"{cells} cells, {upto}{plan.trials} trials each",
        f"{conditions * plan.blocks} blocks of {asked.trials.block} trials",
        f"{upto}about {_duration(seconds)} on a core, compiling not counted",
    ]
    return "\n".join(lines)


def _duration(seconds: float) -> str:
    if seconds > 5400.0:
        return f"{seconds / 3600.0:.1f} h"
    return f"{seconds / 60.0:.0f} min" if seconds > 90.0 else f"{seconds:.0f} s"


@click.command()
def studies() -> None:
    """List the studies that ship, with their questions."""
    from studies.design import shipped

    for name in shipped.names():
        question = " ".join(shipped.study(name).study.question.split())
        click.echo(f"{name:<14} {question}")


@click.command()
@click.argument("folder", metavar="DIR", type=EXISTING)
def verify(folder: Path) -> None:
    """Read everything in a store again and compute some trials again, bit by bit."""
    with exit_codes():
        from studies.run import verify as verify_store

        defects = verify_store(folder, lambda line: click.echo(line, err=True))
    if defects:
        for line in defects:
            click.echo(line, err=True)
        raise StoreFailure(f"{len(defects)} defects; `simfield run` computes again what is damaged or missing")
    click.echo("all is well")


@click.command()
@click.argument("source", metavar="NAME|STUDY.toml|DIR")
@click.argument("condition", metavar="CONDITION")
@click.argument("trial", type=click.IntRange(0))
def replay(source: str, condition: str, trial: int) -> None:
    """Run one trial of one condition alone and say everything about it.

    CONDITION is an id, its beginning, or its number in the dry run.
    """
    with exit_codes():
        from studies.run import condition_named, replay as replay_trial

        plan = _plan(source)
        for line in replay_trial(plan, condition_named(plan, condition), trial):
            click.echo(line)


def _plan(source: str) -> Plan:
    from studies.design import Plan, shipped
    from studies.store import study_of

    if Path(source).is_dir() and source not in shipped.names():
        return study_of(Path(source))
    return Plan.of(shipped.study(source))
