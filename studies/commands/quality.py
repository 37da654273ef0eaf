"""The command of quality control: detection."""

from __future__ import annotations

from pathlib import Path

import click

from studies.commands.arguments import FOLDER


@click.command()
@click.argument("source", metavar="[PRESET|SCENARIO.toml]", default="rheidt-1980")
@click.option("--ap", "model_id", metavar="ID", default="brown14", show_default=True, help="Additional parameters.")
@click.option("--out", type=FOLDER, default=Path("results/detection"), show_default=True, help="Folder to write.")
@click.option("--trials", type=click.IntRange(2), default=2000, show_default=True, help="Trials with one wrong error.")
@click.option("--contests", type=click.IntRange(2), default=20, show_default=True, help="Trials with many at once.")
@click.option("--seed", type=click.IntRange(0), default=1980, show_default=True, help="Seed of all that is random.")
def detection(source: str, model_id: str, out: Path, trials: int, contests: int, seed: int) -> None:
    """Say how often gross errors of 4 to 20 standard deviations are found, missed and laid to others."""
    from adjust import ap_models
    from simfield import simulate
    from studies.commands import simulation
    from studies.experiments import detection_page

    try:
        model = ap_models.get(model_id)
        block, _ = simulate(simulation.scenario(source), seed)
    except (KeyError, simulation.WrongScenarioError) as error:
        raise click.UsageError(str(error.args[0])) from error
    try:
        for path in detection_page.write(out, block, model, trials, contests, seed, source):
            click.echo(path)
    except (ArithmeticError, ValueError, OSError) as error:
        raise click.ClickException(str(error)) from error
