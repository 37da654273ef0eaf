"""The pages on the sets of additional parameters: a table of all, a description and a drawing of each.

Compute (`vector_fields`), draw (`draw_on`) and write (`draw_fields`) are apart; the texts are strings to be printed.
"""

from __future__ import annotations

import dataclasses
import textwrap
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from adjust.ap_models import MODELS, ApModel, properties
from simfield.block import Floats

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

HALF_FORMAT_MM = 115.0
ARROWS_A_SIDE = 9
LARGEST_ARROW_UM = 10.0
LINE = 118
CERTAINTY = {
    "certain": "confirmed by a second source or by a computed property",
    "reading": "the best reading of a bad scan",
    "reconstruction": "parts of the printed form could not be read and are guessed",
    "memory": "from general knowledge, no page of the source at hand",
}


def table() -> str:
    """All sets with their default settings, one a line."""
    rows = [("id", "parameters", "certainty", "settings", "title")]
    for model in (kind() for kind in MODELS):
        settings = ", ".join(f"{name}={_number(value)}" for name, value in model.settings.items()) or "-"
        rows.append((model.id, str(len(model.parameters)), str(model.certainty), settings, model.title))
    rows = [(i, count, sure, textwrap.shorten(s, 44, placeholder=" ..."), title) for i, count, sure, s, title in rows]
    widths = [max(len(row[k]) for row in rows) for k in range(4)]
    lines = []
    for i, count, sure, settings, title in rows:
        right = f"{count:>{widths[1]}}"
        lines.append(f"{i:<{widths[0]}}  {right}  {sure:<{widths[2]}}  {settings:<{widths[3]}}  {title}".rstrip())
    return "\n".join(lines)


def describe(model: ApModel) -> str:
    """Everything about one set: where it comes from, its formula, settings, parameters and computed properties."""
    head = [
        f"{model.id}: {model.title}",
        "",
        f"author     {model.author}, {model.year}" if model.year else f"author     {model.author}",
        *_wrapped("source     ", model.source),
        f"certainty  {model.certainty}: {CERTAINTY[str(model.certainty)]}",
        "",
        "formula    distortion contained in the measurement, evaluated at the measured x (flight direction), y in mm",
    ]
    formula = [part for line in model.formula.splitlines() for part in _wrapped("  ", line)]
    lines = [*head, *formula, "", *_settings(model), "", *_parameters(model), "", *_properties(model)]
    return "\n".join(lines)


def _settings(model: ApModel) -> list[str]:
    fields = dataclasses.fields(model)
    if not fields:
        return ["settings   none"]
    rows = []
    for f in fields:
        value = getattr(model, f.name)
        given = "" if value == f.default else f" (default {_number(f.default)})"
        rows.append(f"  {f.name:<14} {_number(value):>8}{given}  {f.metadata.get('about', '')}{_unit(f.name)}")
    return ["settings", *rows]


def _parameters(model: ApModel) -> list[str]:
    lines = [f"parameters {len(model.parameters)}", *_wrapped("  ", ", ".join(model.parameters) or "none")]
    if model.not_estimable:
        lines += ["", "not estimable beside the exterior orientation of a flat, near-vertical block"]
        lines += [f"  {name:<4} {reason}" for name, reason in model.why_not_estimable.items()]
    return lines


def _properties(model: ApModel) -> list[str]:
    half, side = properties.HALF_FORMAT_MM, properties.POINTS_A_SIDE
    if not model.parameters:
        return ["properties none"]
    apart = properties.independence_of_orientation(model, model.not_estimable)
    among, beside = properties.largest_cosines(model, *properties.grid())
    rows = [
        ("smallest singular value among the terms", f"{properties.independence(model):.3f}"),
        ("the same of the estimable terms beside the orientation", f"{apart:.3f}"),
        ("largest |cosine| between two terms", f"{among:.3f}"),
        ("largest |cosine| of a term and an orientation effect", f"{beside:.3f}"),
        ("share of a radial r^3 distortion it takes up", f"{100 * properties.share_of_radial_cubic(model):.1f} %"),
    ]
    lines = [f"properties computed on {side} x {side} points over +-{half:g} mm; terms scaled to unit length"]
    lines += [f"  {what:<55} {value}" for what, value in rows]
    if positions := model.orthogonal_on_mm:
        largest = max(properties.largest_cosines(model, *properties.product_grid(positions)))
        where = ", ".join(f"{p:g}" for p in positions)
        lines.append(f"  orthogonal, also to the orientation, on {{{where}}}^2 mm: largest |cosine| {largest:.0e}")
    return lines


@dataclass(frozen=True, eq=False)
class ParameterField:
    """One parameter's displacements over the format, scaled so that the largest is LARGEST_ARROW_UM."""

    name: str
    value: float
    """of the parameter that makes the largest displacement LARGEST_ARROW_UM"""
    x_mm: Floats
    y_mm: Floats
    dx_um: Floats
    dy_um: Floats


def vector_fields(model: ApModel) -> list[ParameterField]:
    """The field of every parameter over the 23 cm format."""
    x, y = properties.grid(HALF_FORMAT_MM, ARROWS_A_SIDE)
    fields = []
    for name, term in zip(model.parameters, np.moveaxis(model.basis(x, y), 2, 0), strict=True):
        value = LARGEST_ARROW_UM / 1000 / float(np.max(np.hypot(*term.T)))
        fields.append(ParameterField(name, value, x, y, 1000 * value * term[:, 0], 1000 * value * term[:, 1]))
    return fields


def draw_on(axes: Axes, field: ParameterField) -> None:
    """One panel: the arrows of one parameter in the frame of the format."""
    spacing = 2 * HALF_FORMAT_MM / (ARROWS_A_SIDE - 1)
    arrows = (field.x_mm, field.y_mm, field.dx_um, field.dy_um)
    axes.quiver(*arrows, angles="xy", scale_units="xy", scale=LARGEST_ARROW_UM / spacing, width=0.009, color="C0")
    edge = HALF_FORMAT_MM * np.array([-1, 1, 1, -1, -1])
    axes.plot(edge, -np.roll(edge, 1), color="0.6", linewidth=0.6)
    limit = HALF_FORMAT_MM + 1.1 * spacing
    axes.set(xlim=(-limit, limit), ylim=(-limit, limit), aspect="equal", xticks=[-100, 0, 100], yticks=[-100, 0, 100])
    axes.set_title(f"{field.name} = {field.value:.2g}", fontsize=8, pad=3)
    axes.tick_params(labelsize=7, length=2, pad=2)


def fields_figure(model: ApModel) -> Figure:
    """All parameters of a set, one panel each. Raises ValueError for a set without parameters."""
    from matplotlib.figure import Figure

    fields = vector_fields(model)
    if not fields:
        raise ValueError(f"{model.id} has no parameters to draw")
    columns = min(len(fields), max(4, int(np.ceil(np.sqrt(1.3 * len(fields))))))
    rows = -(-len(fields) // columns)
    figure = Figure(figsize=(max(1.6 * columns + 0.4, 5.5), 1.75 * rows + 1.0), layout="constrained")
    panels = figure.subplots(rows, columns, squeeze=False).ravel()
    for k, (axes, field) in enumerate(zip(panels, fields, strict=False)):
        draw_on(axes, field)
        axes.tick_params(labelleft=k % columns == 0, labelbottom=k + columns >= len(fields))
    for axes in panels[len(fields) :]:
        axes.set_axis_off()
    settings = ", ".join(f"{name} = {_number(value)}" for name, value in model.settings.items())
    figure.suptitle(f"{model.title}\n{settings}" if settings else model.title, fontsize=10)
    longest = f"longest arrow {LARGEST_ARROW_UM:g} um at the parameter's value above its panel"
    figure.supxlabel(f"x in flight direction, mm\n{longest}", fontsize=8)
    figure.supylabel("y, mm", fontsize=8)
    return figure


def draw_fields(model: ApModel, path: str | Path) -> None:
    """Write the fields of all parameters to a file: svg, png or pdf by its ending; identical bytes every time."""
    import matplotlib
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    figure = fields_figure(model)
    FigureCanvasAgg(figure)
    undated = {".svg": {"Date": None}, ".pdf": {"CreationDate": None}}.get(Path(path).suffix.lower())
    with matplotlib.rc_context({"svg.hashsalt": model.id}):
        figure.savefig(path, dpi=130, metadata=undated)


def _number(value: Any) -> str:
    if isinstance(value, tuple):
        return ",".join(value) or "-"
    return f"{value:g}" if isinstance(value, float) else str(value)


def _unit(name: str) -> str:
    return ", mm" if name.endswith("_mm") else ""


def _wrapped(label: str, text: str) -> list[str]:
    return textwrap.wrap(text, LINE, initial_indent=label, subsequent_indent=" " * len(label) + "  ")
