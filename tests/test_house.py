"""The rules of the house, counted over the tree: docs/house.md shows it, docs/development.md says how to build in it.

Counted are: modules a folder; circles of files and of rooms, late and type-only imports with them; what adjust knows of
simfield; names with an underscore across modules; late imports of our own; imports past a door; door signs; compiled
twins with their readable forms and agreement tests; lines a file.
"""

from __future__ import annotations

import ast
import re
from pathlib import PurePosixPath

import pytest

from tests.house import PACKAGES, TOP, House, circles, dotted

MOST_MODULES = 12
MOST_AT_ROOT = {"simfield": 2, "adjust": 4, "studies": 0}
LATE_IS_FINE = re.compile(r"^studies/(commands|lessons/apps)/")
"""a command, or the cell of a lesson, answers before it computes"""
SHARED = ("simfield.block", "simfield.numerics")
"""what the adjustment knows of the simulator: the data model, and how numbers are computed"""
MANY_LINES, MOST_LINES = 300, 400
REASON = re.compile(r"^# Over 300 lines: \S.{10,}$", re.MULTILINE)
READABLE = re.compile(r"Readable form: `?((?:simfield|adjust|studies)(?:\.\w+)+)`?")
AGREEMENT = re.compile(r"Agreement: `?(tests/[\w/]+\.py)`?")
NUMBA = re.compile(r"^\s*(?:import numba|from numba)", re.MULTILINE)


@pytest.fixture(scope="module")
def house() -> House:
    return House.standing()


def test_no_folder_is_crowded(house: House) -> None:
    folders = {str(PurePosixPath(path).parent) for path in house.files}
    assert folders >= set(PACKAGES)
    counted = {folder: len(house.modules_in(folder)) for folder in folders}
    assert {f: n for f, n in counted.items() if n > MOST_AT_ROOT.get(f, MOST_MODULES)} == {}


def test_no_circle_of_files_and_none_of_rooms(house: House) -> None:
    assert len(house.imports) > 1000
    assert circles(house.file_arrows) == []
    assert circles(house.room_arrows) == []


def test_a_circle_is_seen_through_a_door_and_through_a_late_import() -> None:
    texts = {
        "adjust/__init__.py": '"""."""\n',
        "adjust/a/__init__.py": '"""."""\n',
        "adjust/a/__init__.pyi": "from .one import first as first\n",
        "adjust/a/one.py": "from adjust.b.two import second\n",
        "adjust/b/__init__.py": '"""."""\n',
        "adjust/b/two.py": "def second():\n    from adjust.a import first\n",
    }
    built = House(texts)
    assert circles(built.file_arrows) == [["adjust/a/one.py", "adjust/b/two.py"]]
    assert circles(built.room_arrows) == [["adjust/a", "adjust/b"]]


def test_the_adjustment_is_blind(house: House) -> None:
    seen = {
        f"{found.importer}:{found.line} {found.module}"
        for found in house.imports
        if found.importer.startswith("adjust/") and found.module.startswith("simfield")
        if not found.module.startswith(SHARED)
    }
    assert seen == set()


def test_no_private_name_crosses_a_module(house: House) -> None:
    imported = [f"{i.importer}:{i.line} {i.name}" for i in house.imports if _is_private(i.name)]
    assert imported == []
    reached = []
    for path, tree in house.files.items():
        ours = {
            alias.asname or alias.name
            for node in ast.walk(tree)
            if isinstance(node, ast.ImportFrom) and node.module and node.module.split(".")[0] in PACKAGES
            for alias in node.names
        }
        reached += [
            f"{path}:{node.lineno} {node.value.id}.{node.attr}"
            for node in ast.walk(tree)
            if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name)
            if node.value.id in ours and _is_private(node.attr)
        ]
    assert reached == []


def _is_private(name: str) -> bool:
    return name.startswith("_") and not name.startswith("__")


def test_late_imports_of_our_own_stand_in_commands_and_apps_only(house: House) -> None:
    late = [f"{i.importer}:{i.line} {i.module}" for i in house.imports if i.late]
    assert [line for line in late if not LATE_IS_FINE.match(line)] == []


def test_nothing_outside_a_room_imports_past_its_door(house: House) -> None:
    """A compiled twin and its readable form may know each other by file."""
    past = []
    for found in house.imports:
        place = house.modules.get(f"{found.module}.{found.name}") or house.modules.get(found.module)
        if place is None or place.endswith("/__init__.py"):
            continue
        room = str(PurePosixPath(place).parent)
        twins = found.importer.endswith("_compiled.py") and dotted(place) in house.texts[found.importer]
        offered = (dotted(room + "/__init__.py"), found.name) in house.offered
        if not found.importer.startswith(room + "/") and not twins and not offered:
            past.append(f"{found.importer}:{found.line} {found.module}.{found.name}")
    assert past == []


def test_what_a_door_offers_is_there_and_no_module_shares_its_name(house: House) -> None:
    """A module of the same name would take the place of the thing as soon as anybody has imported it."""
    lost, shadowed = [], []
    for (package, name), (module, own) in house.offered.items():
        tree = house.files.get(house.modules.get(module, ""))
        if tree is None or (own and own not in _defined(tree) and (module, own) not in house.offered):
            lost.append(f"{package}: {name} of {module}")
        stub = f"{package.replace('.', '/')}/__init__.pyi"
        if own and f"{package}.{name}" in house.modules and stub in house.texts:
            shadowed.append(f"{package}.{name}")
    assert lost == []
    assert shadowed == []


def _defined(tree: ast.Module) -> set[str]:
    names: set[str] = set()
    for node in ast.walk(tree):
        if isinstance(node, ast.FunctionDef | ast.ClassDef):
            names.add(node.name)
        elif isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store):
            names.add(node.id)
        elif isinstance(node, ast.ImportFrom | ast.Import):
            names |= {alias.asname or alias.name for alias in node.names}
    return names


def test_every_door_has_a_sign(house: House) -> None:
    doors = [path for path in house.files if path.endswith("/__init__.py")]
    unsigned = [path for path in doors if len(ast.get_docstring(house.files[path]) or "") < 40]
    assert unsigned == []
    folders = {str(PurePosixPath(path).parent) for path in house.files}
    assert {folder for folder in folders if f"{folder}/__init__.py" not in house.files} == set()


def test_every_compiled_twin_names_its_readable_form_and_its_agreement(house: House) -> None:
    compiled = [path for path in house.files if path.endswith("_compiled.py")]
    assert len(compiled) >= 10
    faults = []
    for path in compiled:
        said = ast.get_docstring(house.files[path]) or ""
        form, test = READABLE.search(said), AGREEMENT.search(said)
        if not form or not _exists(house, form[1]):
            faults.append(f"{path}: readable form {form and form[1]}")
        if not test or not (TOP / test[1]).is_file():
            faults.append(f"{path}: agreement test {test and test[1]}")
    assert faults == []


def _exists(house: House, name: str) -> bool:
    """Whether a dotted name is a module, or a thing defined in one."""
    if name in house.modules:
        return True
    parts = name.split(".")
    for cut in range(len(parts) - 1, 0, -1):
        module = ".".join(parts[:cut])
        if module in house.modules:
            path = house.modules[module]
            return parts[cut] in _defined(house.files[path]) or (module, parts[cut]) in house.offered
    return False


def test_what_is_compiled_is_called_so(house: House) -> None:
    numerics = "simfield/numerics/"
    asks = [path for path in house.files if NUMBA.search(house.texts[path])]
    assert [path for path in asks if not path.endswith("_compiled.py") and not path.startswith(numerics)] == []


def test_no_file_is_too_long(house: House) -> None:
    lines = {path: text.count("\n") for path, text in house.texts.items()}
    assert {path: n for path, n in lines.items() if n > MOST_LINES} == {}
    without_reason = [p for p, n in lines.items() if n > MANY_LINES and not REASON.search(house.texts[p][:400])]
    assert without_reason == []


def test_one_name_means_one_thing(house: House) -> None:
    """No two files define a class of the same name; a private one counts as well."""
    places: dict[str, set[str]] = {}
    for path, tree in house.files.items():
        for node in ast.walk(tree):
            if isinstance(node, ast.ClassDef):
                places.setdefault(node.name, set()).add(path)
    assert {name: paths for name, paths in places.items() if len(paths) > 1} == {}
