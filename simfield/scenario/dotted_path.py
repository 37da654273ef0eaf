"""Changes to nested tables by dotted path: "flights[0].scale", "noise.image_um.ww", "flights[*].position_sigma_m"."""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import Any

from simfield.block import nearest, shown
from simfield.scenario.scenario import ScenarioError

STEP = re.compile(r"([^.\[\]]+)((?:\[(?:\d+|\*)\])*)(?:\.|$)")


def put(table: dict[str, Any], path: str, value: object) -> None:
    """Change what the path leads to, in place. A last name may be new; [*] means every entry of a list.

    Raises ScenarioError for a path that leads nowhere.
    """
    steps = _steps(path)
    for holder in _holders(table, steps[:-1], path):
        for key in _keys(holder, steps[-1], path, may_be_new=True):
            holder[key] = value


def _steps(path: str) -> list[str | int]:
    """ "flights[0].scale" as ["flights", 0, "scale"]; [*] stays "*"."""
    steps: list[str | int] = []
    end = 0
    for match in STEP.finditer(path):
        if match.start() != end:
            break
        end = match.end()
        steps.append(match[1])
        steps.extend(int(i) if i != "*" else "*" for i in re.findall(r"\[(\d+|\*)\]", match[2]))
    if not steps or end != len(path) or path.endswith("."):
        raise ScenarioError(
            f"{path!r} is no path; allowed are names with dots and [number] or [*], as flights[0].scale"
        )
    return steps


def _holders(node: Any, steps: list[str | int], path: str) -> Iterator[Any]:
    """Every table or list that the steps lead to."""
    if not steps:
        yield node
        return
    for key in _keys(node, steps[0], path):
        yield from _holders(node[key], steps[1:], path)


def _keys(node: Any, step: str | int, path: str, *, may_be_new: bool = False) -> list[Any]:
    if isinstance(node, list) and step == "*":
        return list(range(len(node)))
    if isinstance(node, list) and isinstance(step, int):
        if step >= len(node):
            raise ScenarioError(f"{path}: there is no entry [{step}], the list has {len(node)}, counted from 0")
        return [step]
    if isinstance(node, dict) and isinstance(step, str) and (step in node or may_be_new):
        # A new name is left to the check of the whole, which knows the tables with free names.
        return [step]
    if isinstance(node, dict) and isinstance(step, str):
        raise ScenarioError(f"{path}: unknown key {step!r}{nearest(step, node)}")
    raise ScenarioError(f"{path}: {step!r} does not lead into {shown(node)}")
