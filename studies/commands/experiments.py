"""The commands of experiments: reproduce repeats published ones, detection asks how often gross errors are found."""

from __future__ import annotations

from pathlib import Path

import click

from studies.commands.arguments import FOLDER
from studies.commands.exits import Failure

DEFAULT_TRIALS = 200


DEFAULT_SEED = 1980


@click.command()
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
        from studies.experiments import mauelshagen_1980_twin as experiment
    elif what == "ziemann-1982":
        from studies.experiments import ziemann_1982 as experiment  # type: ignore[no-redef]
    else:
        from studies.experiments import mauelshagen_1980 as experiment  # type: ignore[no-redef]

    from studies.experiments import ReproductionError

    folder = out if out is not None else Path("results") / (f"{what}-{world}" if world else what)
    try:
        done = experiment.reproduce(folder, trials=trials, jobs=jobs, seed=seed)
    except ReproductionError as error:
        raise Failure(str(error)) from error
    except OSError as error:
        raise Failure(f"{error.filename or folder}: cannot be written: {error.strerror}") from error
    for path in done.files:
        click.echo(path)
    for line in done.failures:
        click.echo(line, err=True)
    if done.failures:
        raise Failure(f"{len(done.failures)} adjustments failed; the report counts and names them")


@click.command()
@click.argument("source", metavar="[PRESET|SCENARIO.toml]", default="rheidt-1980")
@click.option("--ap", "model_id", metavar="ID", default="brown14", show_default=True, help="Additional parameters.")
@click.option("--out", type=FOLDER, default=Path("results/detection"), show_default=True, help="Folder to write.")
@click.option("--trials", type=click.IntRange(2), default=2000, show_default=True, help="Trials with one wrong error.")
@click.option("--contests", type=click.IntRange(2), default=20, show_default=True, help="Trials with many at once.")
@click.option("--blocks", type=click.IntRange(1), default=100, show_default=True, help="Blocks that are searched.")
@click.option("--seed", type=click.IntRange(0), default=1980, show_default=True, help="Seed of all that is random.")
def detection(source: str, model_id: str, out: Path, trials: int, contests: int, blocks: int, seed: int) -> None:
    """Say how often gross errors of 4 to 20 standard deviations are found, missed and laid to others."""
    from adjust import ap_models
    from simfield import simulate
    from studies.commands import simulation
    from studies.experiments import detection_page

    try:
        model = ap_models.get(model_id)
        scenario = simulation.scenario(source)
        block, _ = simulate(scenario, seed)
    except (KeyError, simulation.WrongScenarioError) as error:
        raise click.UsageError(str(error.args[0])) from error
    of = detection_page.DetectionTrials(trials, contests, blocks, seed)
    try:
        for path in detection_page.write(
            out, block, lambda number: simulate(scenario, seed + 1 + number)[0], model, of, source
        ):
            click.echo(path)
    except (ArithmeticError, ValueError, OSError) as error:
        raise click.ClickException(str(error)) from error
