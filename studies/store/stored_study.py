"""The study that a store holds, and whether it is the one that is asked for."""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from studies.design import Plan, read_study
from studies.store.column_sets import column_faults
from studies.store.store import StoreError, read_json

MOST_DIFFERENCES = 10


def study_of(folder: Path) -> Plan:
    """The plan of the study that a store holds, with the trials and the seed that it was run with.

    Raises StoreError if the folder is no store or its manifest belongs to another study; StudyError, OSError.
    """
    if not (folder / "manifest.json").is_file() or not (folder / "study.toml").is_file():
        raise StoreError(f"{folder}: no study was run into this folder (manifest.json and study.toml are missing)")
    manifest = read_json(folder / "manifest.json")
    identity = manifest.get("identity")
    numbers = (manifest.get("trials"), identity.get("seed")) if isinstance(identity, dict) else ()
    if not numbers or not all(isinstance(n, int) for n in numbers):
        raise StoreError(f"{folder / 'manifest.json'}: damaged: it names no study")
    study = read_study(folder / "study.toml").with_changes(trials=manifest["trials"], seed=manifest["identity"]["seed"])
    plan = Plan.of(study)
    refuse_other(plan, manifest)
    return plan


def refuse_other(plan: Plan, manifest: Mapping[str, Any]) -> None:
    """Raise StoreError, a line for each difference, if the manifest is that of another study or of other columns."""
    lines = list(_differences("", manifest.get("identity", {}), plan.identity))
    lines += column_faults(manifest.get("columns"))
    if not lines:
        ids = {c.id for c in plan.conditions}
        gone = [labels for key, labels in manifest.get("conditions", {}).items() if key not in ids]
        lines = [f"condition {_levels(labels)} is in the store and no longer in the study" for labels in gone]
        kept = {m.key for m in plan.methods}
        lines += [
            f"method {key!r} is in the store and no longer in the study"
            for key in manifest.get("methods", [])
            if key not in kept
        ]
    if lines:
        more = [f"and {len(lines) - MOST_DIFFERENCES} more"] if len(lines) > MOST_DIFFERENCES else []
        raise StoreError("\n".join([*lines[:MOST_DIFFERENCES], *more]))


def programs_of(manifest: Mapping[str, Any]) -> list[dict[str, Any]]:
    """The programs (studies.session.program) that have computed trials of a store; of older stores what is known."""
    found = manifest.get("programs")
    if isinstance(found, list) and all(isinstance(each, dict) for each in found):
        return found
    versions = manifest.get("versions")
    return [{**versions, "code": "not recorded"}] if isinstance(versions, dict) else []


def other_program(manifest: Mapping[str, Any], mine: Mapping[str, str]) -> str | None:
    """A sentence if none of the programs that computed a store is this one; None if one is, or none has computed."""
    programs = programs_of(manifest)
    if not programs or any(all(each.get(k) == v for k, v in mine.items()) for each in programs):
        return None
    last = programs[-1]
    apart = [f"{k} {str(last.get(k, 'not recorded'))[:40]} and not {v}" for k, v in mine.items() if last.get(k) != v]
    return f"its trials were computed by {', '.join(apart)}"


def _levels(labels: Any) -> str:
    return (
        ", ".join(f"{k} {v}" for k, v in labels.items())
        if isinstance(labels, Mapping) and labels
        else "without factors"
    )


def _differences(place: str, old: Any, new: Any) -> Iterator[str]:
    if isinstance(old, Mapping) and isinstance(new, Mapping):
        for key in dict.fromkeys([*new, *old]):
            yield from _differences(f"{place}.{key}".removeprefix("."), old.get(key), new.get(key))
    elif isinstance(old, list) and isinstance(new, list) and len(old) == len(new):
        for number, pair in enumerate(zip(old, new, strict=True)):
            yield from _differences(f"{place}[{number}]", *pair)
    elif old != new:
        yield f"{place}: the store has {json.dumps(old)[:80]}, the study {json.dumps(new)[:80]}"
