"""The command that shows sets of additional parameters: models."""

from __future__ import annotations

from pathlib import Path

import click

from studies.commands.arguments import model_of


@click.command()
@click.argument("model_id", metavar="[ID]", required=False)
@click.option("--set", "settings", metavar="NAME=VALUE", multiple=True, help="A setting of the model.")
@click.option("--draw", type=click.Path(dir_okay=False, path_type=Path), help="Draw its terms (.svg, .png).")
def models(model_id: str | None, settings: tuple[str, ...], draw: Path | None) -> None:
    """List the sets of additional parameters, or describe one."""
    from studies.pages import models_page

    if model_id is None:
        if draw is not None:
            raise click.UsageError("--draw needs the ID of a model")
        click.echo(models_page.table(), nl=False)
        return
    model = model_of(model_id, settings)
    click.echo(models_page.describe(model), nl=False)
    if draw is None:
        return
    try:
        models_page.draw_fields(model, draw)
    except (ValueError, OSError) as error:
        raise click.UsageError(f"{draw} cannot be drawn: {error}") from error
