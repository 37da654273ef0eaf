# Over 300 lines: one report, looked at from all sides
"""The report: one safe file, the same bytes every time; a folder that is damaged or not ours is refused in one line."""

import json
import os
import shutil
import subprocess
import sys
from html.parser import HTMLParser
from pathlib import Path

import pytest
from click.testing import CliRunner

from studies.commands.program import main
from studies.pages.html_report import report
from tests.studies.small_study import TEXT, run_here, study

RESULTS = Path(__file__).parents[3] / "results"
HOSTILE = "<script>alert(1)</script>"
FORMULA = r"$\\frac$ $x$"
CALL = "=HYPERLINK(1)"
LEVELS = ", ".join(
    f'{{ label = "{name}", value = {um} }}' for name, um in ((HOSTILE, 3.0), (FORMULA, 6.0), (CALL, 7.0))
)
LARGEST_COMMITTED = 1_500_000
"""bytes"""


def call(*arguments):
    return CliRunner().invoke(main, [str(a) for a in arguments])


class Reader(HTMLParser):
    """Every start tag with its attributes, and the text."""

    def __init__(self, page):
        super().__init__()
        self.tags, self.text = [], []
        self.feed(page)
        self.close()

    def handle_starttag(self, tag, attributes):
        self.tags.append((tag, dict(attributes)))

    def handle_data(self, data):
        self.text.append(data)

    def named(self, tag):
        return [attributes for name, attributes in self.tags if name == tag]


@pytest.fixture(scope="module")
def store(tmp_path_factory):
    """A small study whose names try everything."""
    asked = study(
        TEXT,
        ('question = "Does it run?"', f'question = "Does {HOSTILE} run? {FORMULA} {CALL} | a *b* [c](d)"'),
        ("noise_um = [3.0, 6.0]", f"noise_um = [{LEVELS}]"),
    )
    folder = tmp_path_factory.mktemp("report") / "store"
    run_here(folder, asked)
    return folder


@pytest.fixture(scope="module")
def page(store):
    return report(store)


@pytest.fixture
def copy(store, tmp_path):
    return Path(shutil.copytree(store, tmp_path / "copy"))


@pytest.fixture
def pages(tmp_path):
    """A folder as `simfield reproduce` leaves it, with one figure."""
    shutil.copy(RESULTS / "error-budget/budget.svg", tmp_path / "a.svg")
    (tmp_path / "report.md").write_text(f"# {HOSTILE}\n\n{HOSTILE} {FORMULA}\n\n![A](a.svg)\n", encoding="utf-8")
    origin = {"command": "simfield reproduce x --trials 2", "commit": HOSTILE, "parameters": {"seed": 7}}
    (tmp_path / "provenance.json").write_text(json.dumps(origin), encoding="utf-8")
    return tmp_path


def test_the_page_holds_nothing_that_acts(page):
    read = Reader(page)
    forbidden = {"script", "iframe", "object", "embed", "form", "input", "link", "base", "foreignobject"}
    assert forbidden.isdisjoint(name for name, _ in read.tags)
    for _, attributes in read.tags:
        assert not [name for name in attributes if name.startswith("on")]
        assert attributes.get("href", "#").startswith(("#", "data:image/png;base64,"))
        assert attributes.get("src") is None
    policy = next(m["content"] for m in read.named("meta") if m.get("http-equiv") == "Content-Security-Policy")
    assert policy.startswith("default-src 'none';")
    assert "script" not in policy
    assert page.count("http") == page.count("http-equiv") + page.count("http://www.w3.org/2000/svg")


def test_names_of_others_stand_as_they_are(page, store):
    text = "".join(Reader(page).text)
    assert f"Does {HOSTILE} run? $\\frac$ $x$ {CALL} | a *b* [c](d)" in text
    assert page.count("<script") == 0
    csv = (store / "summary.csv").read_text(encoding="utf-8")
    assert f",'{CALL}," in csv
    assert f",{CALL}," not in csv


def test_everything_a_reader_asks_for_is_there(page):
    read = Reader(page)
    text = " ".join(" ".join(read.text).split())
    for section in ("Question", "World", "Design", "Methods", "Trials and failures", "Results", "Provenance", "Again"):
        assert section in text
    assert "576 adjustments in 6 cells of condition and method; none failed" in text
    assert "±" in text
    assert "numpy" in text
    assert "simfield run study.toml --trials 96 --seed 7" in text
    assert 'preset = "grid-small"' in text
    titles = [svg["aria-label"] for svg in read.named("svg")]
    for wanted in ("Plan of the field", "Rays per point", "m0_um over noise_um", "Biases", "Zip plot", "Correlations"):
        assert any(title.startswith(wanted) for title in titles), wanted


def test_every_figure_has_alternative_text(page):
    read = Reader(page)
    says = {attributes["id"] for attributes in read.named("desc")}
    figures = read.named("svg")
    assert len(figures) == len(says) > 5
    for svg in figures:
        assert svg["role"] == "img"
        assert svg["aria-label"]
        assert svg["aria-describedby"] in says


def test_ids_are_unique(page):
    ids = [attributes["id"] for _, attributes in Reader(page).tags if "id" in attributes]
    assert len(ids) == len(set(ids))


def test_the_same_bytes_again_and_elsewhere(page, store, tmp_path):
    assert report(store) == page
    moved = shutil.copytree(store, tmp_path / "elsewhere")
    made = "import sys; from studies.commands.program import main; main(sys.argv[1:])"
    out = tmp_path / "page.html"
    subprocess.run(
        [sys.executable, "-c", made, "report", str(moved), "-o", str(out)],
        check=True, capture_output=True, env={**os.environ, "PYTHONHASHSEED": "1", "TZ": "Asia/Tokyo"},
    )  # fmt: skip
    assert out.read_bytes() == page.encode()


def test_a_store_without_its_trials_says_so(copy):
    shutil.rmtree(copy / "trials")
    done = call("report", copy)
    assert done.exit_code == 0, done.stderr
    assert done.stdout == f"{copy / 'report.html'}\n"
    text = (copy / "report.html").read_text(encoding="utf-8")
    assert "Zip plots of coverage need the single trials" in text


def test_a_report_runs_no_code_of_a_folder(tmp_path, monkeypatch):
    """A set of the user's own is a Python file; whoever reads a folder of somebody else must not run it."""
    monkeypatch.chdir(tmp_path)
    own = "from adjust.ap_models.catalogue.mauelshagen import Optical\n\n\nclass Own(Optical):\n    pass\n"
    (tmp_path / "own.py").write_text(own, encoding="utf-8")
    run_here(tmp_path / "store", study(TEXT, ('ap = ["none", "optical"]', 'ap = ["none", "own.py:Own"]')))
    (tmp_path / "own.py").write_text("raise SystemExit('run')\n", encoding="utf-8")
    assert "own.py:Own" in report(tmp_path / "store")


def test_a_study_without_trials_has_a_report(tmp_path):
    run_here(tmp_path, study(TEXT, ("max = 96", "max = 0")))
    assert "0 adjustments" in report(tmp_path)


def edited(name, old, new):
    def edit(folder):
        path = folder / name
        raw = path.read_bytes()
        assert old in raw
        path.write_bytes(raw.replace(old, new, 1))

    return edit


def cut(name, share):
    def edit(folder):
        raw = (folder / name).read_bytes()
        (folder / name).write_bytes(raw[: int(share * len(raw))])

    return edit


def without(name):
    return lambda folder: (folder / name).unlink()


def flipped(folder):
    path = next(iter(sorted(folder.rglob("0.parquet"))))
    raw = bytearray(path.read_bytes())
    raw[len(raw) // 2] ^= 4
    path.write_bytes(raw)


def one_number_changed(folder):
    lines = (folder / "summary.csv").read_text(encoding="utf-8").splitlines(keepends=True)
    cells = lines[1].rsplit(",", 2)
    lines[1] = f"{cells[0]},{1.001 * float(cells[1])},{cells[2]}"
    (folder / "summary.csv").write_text("".join(lines), encoding="utf-8")


@pytest.mark.parametrize(
    ("injury", "code", "word"),
    [
        (cut("manifest.json", 0.5), 3, "manifest.json"),
        (edited("manifest.json", b'"small"', b'"other"'), 3, "name"),
        (edited("manifest.json", b'"identity"', b'"entity"'), 3, "manifest.json"),
        (edited("manifest.json", b'"seed": 7', b'"seed": [7]'), 3, "manifest.json"),
        (edited("manifest.json", b'"conditions": {', b'"conditions": 7, "rest": {'), 3, "manifest.json"),
        (without("manifest.json"), 3, "manifest.json"),
        (without("study.toml"), 3, "study.toml"),
        (edited("study.toml", b"[study]", b"[study"), 3, "study.toml"),
        (edited("study.toml", b"nx = 5, ny = 5", b"nx = 4, ny = 4"), 3, "more like it"),
        (edited("study.toml", b'preset = "grid-small"', b'preset = "rheidt-1980"'), 3, "study.toml: scenario.field"),
        (without("summary.csv"), 2, "simfield run"),
        (cut("summary.csv", 0.5), 3, "summary.csv"),
        (cut("summary.csv", 0.0), 3, "summary.csv"),
        (edited("summary.csv", b"condition,", b"conditions,"), 3, "summary.csv"),
        (edited("summary.csv", b"none,", b"nine,"), 3, "summary.csv, line 2"),
        (edited("summary.csv", b",um,", b",mm,"), 3, "unit"),
        (edited("summary.csv", b",96,0,", b",96,x,"), 3, "summary.csv, line 2"),
        (edited("summary.csv", b",96,0,", b",-1,0,"), 3, "impossible"),
        (edited("summary.csv", b",96,0,", b",96,0,1,"), 3, "cells"),
        (edited("summary.csv", b"m0_um", b"mu_xy_mm"), 3, "summary.csv"),
        (edited("summary.csv", b"m0_um", b"\xff"), 3, "summary.csv"),
        (edited("differences.csv", b"none", b"nine"), 3, "differences.csv"),
        (one_number_changed, 3, "not what the trials say"),
        (flipped, 3, "damaged"),
        (lambda folder: next(iter(sorted(folder.rglob("0.parquet")))).unlink(), 3, "missing"),
    ],
)
def test_a_damaged_or_foreign_store_is_refused_in_one_line(copy, injury, code, word):
    injury(copy)
    done = call("report", copy, "-o", copy / "page.html")
    assert done.exit_code == code, done.output
    assert word in done.stderr
    assert str(copy) in done.stderr
    assert len([line for line in done.stderr.splitlines() if line.startswith("Error")]) == 1
    if code == 3:
        assert len(done.stderr.splitlines()) == 1
    assert not (copy / "page.html").exists()


def test_pages_of_a_reproduction_become_one_file(pages):
    found = Reader(report(pages))
    text = "".join(found.text)
    assert f"{HOSTILE} $\\frac$ $x$" in text
    assert "simfield reproduce x --trials 2" in text
    assert not found.named("script")
    assert found.named("svg")[0]["aria-label"] == "Error budget, stage by stage"


@pytest.mark.parametrize(
    ("injury", "code", "word"),
    [
        (edited("a.svg", b"<defs>", b"<defs><script>alert(1)</script>"), 3, "a.svg"),
        (cut("a.svg", 0.5), 3, "a.svg"),
        (without("a.svg"), 3, "a.svg"),
        (edited("report.md", b"(a.svg)", b"(../a.svg)"), 3, "../a.svg"),
        (edited("report.md", b"(a.svg)", b"(/etc/passwd)"), 3, "passwd"),
        (edited("report.md", b"# ", b"\xff "), 3, "report.md"),
        (cut("report.md", 0.0), 3, "report.md"),
        (cut("provenance.json", 0.5), 3, "provenance.json"),
        (edited("provenance.json", b"simfield reproduce", b"another program"), 2, "provenance.json"),
        (without("provenance.json"), 2, "no results"),
        (without("report.md"), 2, "no results"),
    ],
)
def test_damaged_or_foreign_pages_are_refused_in_one_line(pages, injury, code, word):
    injury(pages)
    done = call("report", pages)
    assert done.exit_code == code, done.output
    assert word in done.stderr
    assert len([line for line in done.stderr.splitlines() if line.startswith("Error")]) == 1
    assert not (pages / "report.html").exists()


def test_a_link_is_no_figure(pages):
    (pages / "b.svg").symlink_to(pages / "a.svg")
    edited("report.md", b"(a.svg)", b"(b.svg)")(pages)
    assert call("report", pages).exit_code == 3


def test_wrong_places_exit_2_and_unwritable_ones_1(pages, tmp_path):
    assert call("report", tmp_path / "absent").exit_code == 2
    (tmp_path / "empty").mkdir()
    assert call("report", tmp_path / "empty").exit_code == 2
    done = call("report", pages, "-o", tmp_path / "no/such/folder.html")
    assert done.exit_code == 1
    assert len(done.stderr.splitlines()) == 1


@pytest.mark.parametrize("name", ["mauelshagen-1980", "error-budget"])
def test_the_shipped_reports_are_those_of_their_folders(name):
    """What does not depend on the last bits of a drawing: the words, and that the file is small enough to ship."""
    shipped = RESULTS / name / "report.html"
    assert shipped.stat().st_size < LARGEST_COMMITTED
    written, made = (Reader(text) for text in (shipped.read_text(encoding="utf-8"), report(RESULTS / name)))
    assert [t.strip() for t in written.text if t.strip()] == [t.strip() for t in made.text if t.strip()]


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(p.name for p in RESULTS.iterdir() if p.is_dir()))
def test_every_shipped_folder_has_a_report(name):
    found = Reader(report(RESULTS / name))
    assert found.named("h2")
