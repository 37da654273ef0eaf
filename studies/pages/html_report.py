"""The report of a folder of results as one HTML file: a study, a reproduction, an error budget.

The words are those of Markdown pages: of a study studies.pages.study_page makes them from its summary, of the others
they are the folder's own report.md. Figures stand inline; there is no script, and the page asks nobody for anything.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from scipy.special import stdtrit

from simfield.files import settle
from simfield.scenario import ScenarioError
from studies.comparison import CONFIDENCE
from studies.design import Plan, StudyError
from studies.pages import study_page
from studies.pages.study_drawings import FOLLOWED, Drawn, TrialErrors, chosen_methods
from studies.pages.study_page import provenance_table
from studies.session import versions
from studies.store import DamageError, Store, StoreError, joined, read_json, study_of
from studies.summary import Cell, NothingToReportError, Summary, summarise, summary_file, trials_of
from studies.texts import MOST_BYTES, Drawing, DrawingError, converted, escaped, fenced, inline

MOST_TEXT = 8 << 20
COMMANDS = ("simfield reproduce ", "simfield budget ", "simfield detection ")
"""what the provenance of a folder that is no study begins with"""


def report(folder: Path) -> str:
    """The report of a folder as HTML, the same bytes every time.

    Raises NothingToReportError for a folder without results of ours, StoreError for one that is damaged or mixed up,
    OSError.
    """
    settle(folder)
    if (folder / "manifest.json").exists() or (folder / "study.toml").exists():
        return _of_study(folder)
    if (folder / "report.md").exists() and (folder / "provenance.json").exists():
        return _of_pages(folder)
    raise NothingToReportError(
        f"{folder}: no results of simfield are in it, neither of a study (manifest.json, study.toml) nor of "
        "`simfield reproduce` or `simfield budget` (report.md, provenance.json)"
    )


def _of_study(folder: Path) -> str:
    plan = _plan(folder)
    summed = summary_file.read_summary(plan, folder)
    summed, trials = _with_trials(summed, plan, folder)
    kept: dict[str, Drawn] = {}

    def add(drawn: Drawn) -> str:
        kept[drawn.name] = drawn
        return f"![{escaped(drawn.title)}]({drawn.name})\n"

    text = study_page.page(summed, plan, read_json(folder / "manifest.json"), trials, add)
    return _html(text, lambda name: kept[name].svg)


def _plan(folder: Path) -> Plan:
    """The plan of the study in a folder. Raises StoreError for whatever is wrong with its files."""
    try:
        return study_of(folder)
    except (StoreError, StudyError, ScenarioError) as error:
        first, *more = str(error).splitlines()
        place = "" if str(folder) in first else f"{folder}: "
        raise StoreError(place + first + (f"; and {len(more)} lines more like it" if more else "")) from None
    except (TypeError, ValueError, KeyError, AttributeError, OverflowError) as error:
        raise StoreError(f"{folder / 'manifest.json'}: damaged: {error}") from None


def _with_trials(summed: Summary, plan: Plan, folder: Path) -> tuple[Summary, list[TrialErrors]]:
    """The failures in words and the trials of the zip plots, if the shards are there; the summary must agree with them.

    Raises StoreError.
    """
    if not (folder / "trials").is_dir():
        return summed, []
    store = Store(folder, plan.identity_hash)
    try:
        computed = summarise(plan, store)
    except FileNotFoundError as error:
        raise StoreError(f"{error.filename}: missing; `simfield run` computes it again") from None
    except DamageError as error:
        raise StoreError(f"{folder / 'trials'}: damaged: {error}; `simfield run` computes it again") from None
    summary_file.refuse_other_numbers(summed, computed, folder / "summary.csv")
    return Summary(summed.rows, summed.differences, computed.failures, computed.notes), list(_followed(plan, store))


def _followed(plan: Plan, store: Store) -> Iterator[TrialErrors]:
    """Trials of the first condition under the chosen methods."""
    first = plan.conditions[0]
    columns, nominal = joined(store, plan, first, trials_of(plan, store, first))
    for method in chosen_methods(plan):
        cell = Cell.of(method, columns, nominal)
        if FOLLOWED in cell.names and len(cell.error) > 1 and cell.claims:
            at = cell.names.index(FOLLOWED)
            t = float(stdtrit(cell.constants["redundancy"], 0.5 + CONFIDENCE / 2.0))
            if np.all(cell.std[:, at] > 0.0):
                yield TrialErrors(method, cell.error[:, at], cell.std[:, at], t)


def _of_pages(folder: Path) -> str:
    """The report of a folder with pages of its own. Raises NothingToReportError, StoreError."""
    origin = read_json(folder / "provenance.json")
    command = origin.get("command")
    if not isinstance(command, str) or not command.startswith(COMMANDS):
        raise NothingToReportError(
            f"{folder / 'provenance.json'}: names no `simfield reproduce`, `budget` or `detection`"
        )
    text = _text(folder / "report.md", MOST_TEXT)
    if not text.startswith("# "):
        raise StoreError(f"{folder / 'report.md'}: damaged: it does not begin with a title")
    return _html(text.rstrip("\n") + "\n\n" + "\n".join(_provenance(origin, command, text)), _figures_of(folder))


def _figures_of(folder: Path) -> Callable[[str], str]:
    """A function that reads figures by their names, from this folder alone."""

    def read(name: str) -> str:
        path = (folder / name).with_suffix(".svg")
        if Path(name).name != name or not path.is_file() or path.is_symlink():
            raise StoreError(f"{folder / 'report.md'}: damaged: the figure {name[:60]!r} is not in the folder")
        return _text(path, MOST_BYTES)

    return read


def _text(path: Path, most: int) -> str:
    if path.stat().st_size > most:
        raise StoreError(f"{path}: too large to be ours")
    try:
        return path.read_bytes().decode("utf-8")
    except UnicodeDecodeError:
        raise StoreError(f"{path}: damaged: no UTF-8") from None


def _provenance(origin: Mapping[str, Any], command: str, text: str) -> Iterator[str]:
    packages, platform, parameters = (_table(origin, name) for name in ("packages", "platform", "parameters"))
    yield "## Provenance\n"
    yield from provenance_table(
        {
            "simfield": origin.get("simfield"),
            "commit": origin.get("commit"),
            **{name: value for name, value in parameters.items() if isinstance(value, int | float | str)},
            "python": origin.get("python"),
            **packages,
            "system": ", ".join(str(value) for value in platform.values()) or None,
            "duration, s": origin.get("duration_s"),
        }
    )
    if command not in map(str.strip, text.splitlines()):
        yield "Run it again with\n"
        yield fenced(command)
    if any(isinstance(value, dict) for value in parameters.values()):
        yield "The scenarios as they were flown stand in full in provenance.json beside this report.\n"


def _table(origin: Mapping[str, Any], name: str) -> Mapping[str, Any]:
    found = origin.get(name)
    return found if isinstance(found, dict) else {}


def _html(text: str, svg_of: Callable[[str], str]) -> str:
    """Markdown with its figures as a page."""
    import jinja2
    from markupsafe import Markup

    count = 0

    def figure(name: str, title: str) -> Drawing:
        nonlocal count
        count += 1
        try:
            return inline(svg_of(name), count, title)
        except DrawingError as error:
            raise StoreError(f"the figure {name}: damaged or not ours: {error}") from None

    page = converted(text, figure)
    environment = jinja2.Environment(
        loader=jinja2.PackageLoader("studies.pages"),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        keep_trailing_newline=True,
    )
    template = environment.get_template("report.html.jinja")
    return template.render(page=page, body=Markup(page.body), version=versions()["simfield"])
