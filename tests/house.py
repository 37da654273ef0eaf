"""The three packages as they stand: folders, doors and imports, read from the source as text."""

from __future__ import annotations

import ast
import subprocess
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path, PurePosixPath

TOP = Path(__file__).parents[1]
PACKAGES = ("simfield", "adjust", "studies")


@dataclass(frozen=True)
class Import:
    """A name that a file imports: `module` as written, the file that it stands for, and whether it is a late import."""

    importer: str
    line: int
    module: str
    name: str
    target: str
    late: bool


@dataclass(frozen=True)
class House:
    """Source texts by path; doors are `__init__.py`, whose names stand in `__init__.pyi` where they open late."""

    texts: Mapping[str, str] = field(repr=False)

    @classmethod
    def standing(cls) -> House:
        """The house of this checkout, as git knows it, with what is new and not ignored."""
        command = ["git", "ls-files", "--cached", "--others", "--exclude-standard", "*.py", "*.pyi"]
        listed = sorted(subprocess.run(command, cwd=TOP, check=True, capture_output=True, text=True).stdout.split())
        return cls({path: (TOP / path).read_text(encoding="utf-8") for path in listed if (TOP / path).is_file()})

    @cached_property
    def files(self) -> dict[str, ast.Module]:
        """The parsed files of the packages."""
        return {
            path: ast.parse(text)
            for path, text in self.texts.items()
            if path.split("/")[0] in PACKAGES and path.endswith(".py")
        }

    @cached_property
    def modules(self) -> dict[str, str]:
        """The path of every module and package by its dotted name."""
        return {dotted(path): path for path in self.files}

    @cached_property
    def offered(self) -> dict[tuple[str, str], tuple[str, str]]:
        """What a door offers: (package, name) to (module, name); an empty name stands for the module itself."""
        found = {}
        for package, path in self.modules.items():
            if not path.endswith("/__init__.py"):
                continue
            stub = path + "i"
            tree = ast.parse(self.texts[stub]) if stub in self.texts else self.files[path]
            for node in ast.walk(tree):
                if isinstance(node, ast.ImportFrom) and (node.level or (node.module or "").split(".")[0] in PACKAGES):
                    base = ".".join(filter(None, [package if node.level else "", node.module]))
                    for alias in node.names:
                        whole = f"{base}.{alias.name}"
                        place = (whole, "") if whole in self.modules else (base, alias.name)
                        found[package, alias.asname or alias.name] = place
        return found

    def file_of(self, module: str, name: str) -> str | None:
        """The file that `from module import name` ends in, through doors."""
        if (module, name) in self.offered:
            behind, own = self.offered[module, name]
            return self.file_of(behind, own) if own else self.modules[behind]
        whole = f"{module}.{name}"
        return self.modules.get(whole) or self.modules.get(module)

    @cached_property
    def imports(self) -> tuple[Import, ...]:
        """Every import of one of our modules by another, doors left out as importers."""
        return tuple(found for path in self.files if not path.endswith("/__init__.py") for found in self._of(path))

    def _of(self, path: str) -> Iterator[Import]:
        tree = self.files[path]
        early = {id(node) for part in tree.body for node in (ast.walk(part) if isinstance(part, ast.If) else [part])}
        for node in ast.walk(tree):
            if isinstance(node, ast.ImportFrom) and node.module and not node.level:
                pairs = [(node.module, alias.name) for alias in node.names]
            elif isinstance(node, ast.Import):
                pairs = [(alias.name, "") for alias in node.names]
            else:
                continue
            for module, name in pairs:
                if module.split(".")[0] not in PACKAGES:
                    continue
                target = self.file_of(module, name)
                if target and target != path:
                    yield Import(path, node.lineno, module, name, target, id(node) not in early)

    @cached_property
    def file_arrows(self) -> dict[str, set[str]]:
        """Which file imports which, doors left out."""
        arrows: dict[str, set[str]] = {path: set() for path in self.files}
        for found in self.imports:
            if not found.target.endswith("/__init__.py"):
                arrows[found.importer].add(found.target)
        return arrows

    @cached_property
    def room_arrows(self) -> dict[str, set[str]]:
        """Which room needs which; a file at the root of a package is a room of its own."""
        arrows: dict[str, set[str]] = {room_of(path): set() for path in self.files}
        for found in self.imports:
            here, there = room_of(found.importer), room_of(found.target)
            if here != there and there not in PACKAGES:
                arrows[here].add(there)
        return arrows

    def sign(self, room: str) -> str:
        """What the door of a room, or the head of a root file, says in its first line."""
        path = room if room.endswith(".py") else f"{room}/__init__.py"
        return (ast.get_docstring(self.files[path]) or "").split("\n\n")[0].replace("\n", " ")

    def modules_in(self, folder: str) -> list[str]:
        """The modules that lie in a folder, door and `__main__` left out."""
        return [
            path
            for path in self.files
            if str(PurePosixPath(path).parent) == folder and PurePosixPath(path).stem not in ("__init__", "__main__")
        ]


def dotted(path: str) -> str:
    return path.removesuffix(".py").removesuffix("/__init__").replace("/", ".")


def room_of(path: str) -> str:
    """simfield/block/block.py is of the room simfield/block; simfield/simulate.py is its own; a root door the
    package.
    """
    parts = path.removesuffix("/__init__.py").split("/")
    return "/".join(parts[:2]) if len(path.split("/")) > 2 else "/".join(parts)


def circles(arrows: Mapping[str, set[str]]) -> list[list[str]]:
    """The sets of nodes that reach each other (Tarjan 1972, strongly connected components), single ones left out."""
    index: dict[str, int] = {}
    low: dict[str, int] = {}
    stack: list[str] = []
    found = []

    def visit(node: str) -> None:
        index[node] = low[node] = len(index)
        stack.append(node)
        for other in sorted(arrows.get(node, ())):
            if other not in index:
                visit(other)
                low[node] = min(low[node], low[other])
            elif other in stack:
                low[node] = min(low[node], index[other])
        if low[node] == index[node]:
            members = [stack.pop()]
            while members[-1] != node:
                members.append(stack.pop())
            if len(members) > 1:
                found.append(sorted(members))

    for node in sorted(arrows):
        if node not in index:
            visit(node)
    return found
