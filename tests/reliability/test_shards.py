"""Damaged shards and stores: named, computed again, and never averaged in."""

from __future__ import annotations

import ast
import hashlib
import json
import random
from pathlib import Path

import numpy as np
import pytest

from studies.design.plan import Plan
from studies.run.verification import verify
from studies.store.look import look_at
from studies.store.shards import DamageError, decode, encode
from studies.store.store import NOMINAL, LockedError, Store, StoreError, locked
from tests.studies.small_study import contents, run_here, study

TOP = Path(__file__).parents[2]
LOADERS = {"pickle", "dill", "cloudpickle", "marshal", "shelve"}
"""modules that run what a file says"""


def digest(columns: dict[str, np.ndarray]) -> str:
    """Names, types and bits of columns."""
    parts = [f"{name} {v.dtype} {len(v)} ".encode() + v.tobytes() for name, v in columns.items()]
    return hashlib.sha256(b"|".join(parts)).hexdigest()


def a_shard() -> tuple[bytes, dict[str, np.ndarray], dict[str, object]]:
    random = np.random.default_rng(1)
    columns: dict[str, np.ndarray] = {f"q{i}": random.standard_normal(32) for i in range(6)}
    columns["status"] = np.zeros(32, dtype=np.int8)
    label: dict[str, object] = {"study": "s", "condition": "c", "block": 3}
    return encode(columns, label), columns, label


def test_a_shard_comes_back_bit_by_bit() -> None:
    raw, columns, label = a_shard()
    columns_back = decode(raw, label, 32)
    assert list(columns_back) == list(columns)
    assert digest(columns_back) == digest(columns)
    odd = {"x": np.array([np.nan, -0.0, 5e-324, np.inf])}
    assert decode(encode(odd, label), label, 4)["x"].tobytes() == odd["x"].tobytes()


def read_or_damage(raw: bytes, label: dict[str, object], sha: str) -> str:
    try:
        columns = decode(raw, label, 32)
    except DamageError:
        return "damaged"
    return "right" if digest(columns) == sha else "wrong"


def test_every_single_flipped_bit_is_noticed_or_harmless() -> None:
    raw, columns, label = a_shard()
    sha = digest(columns)
    chance = random.Random(2)
    outcomes = {"damaged": 0, "right": 0, "wrong": 0}
    for _ in range(1000):
        mutated = bytearray(raw)
        mutated[chance.randrange(len(raw))] ^= 1 << chance.randrange(8)
        outcomes[read_or_damage(bytes(mutated), label, sha)] += 1
    assert outcomes["wrong"] == 0
    assert outcomes["damaged"] == 1000


def test_a_thousand_mutations_never_give_a_wrong_number() -> None:
    raw, columns, label = a_shard()
    sha = digest(columns)
    chance = random.Random(3)
    for number in range(1000):
        mutated = bytearray(raw)
        first = chance.randrange(len(raw))
        last = min(len(raw), first + chance.randrange(1, 200))
        kind = number % 5
        if kind == 0:
            del mutated[first:]
        elif kind == 1:
            mutated[first:last] = bytes(last - first)
        elif kind == 2:
            mutated[first:last] = chance.randbytes(last - first)
        elif kind == 3:
            mutated[first:first] = raw[first:last]
        else:
            del mutated[first:last]
        assert read_or_damage(bytes(mutated), label, sha) != "wrong"


def test_a_bomb_is_refused_from_its_header() -> None:
    import pyarrow as pa
    import pyarrow.parquet as pq

    with pytest.raises(DamageError, match="the header claims 3000000 rows"):
        decode(encode({"x": np.zeros(3_000_000)}, {}), {}, 32)
    sink = pa.BufferOutputStream()
    pq.write_table(pa.table({"x": pa.array(np.zeros(3_000_000))}), sink, compression="zstd")
    raw = bytes(sink.getvalue())
    assert len(raw) < 50_000
    with pytest.raises(DamageError, match="no shard of simfield"):
        decode(raw, {}, 1 << 30)


def test_there_is_no_loader_for_a_pickle(copy: Path) -> None:
    import pickle

    path = next((copy / "trials").rglob("1.parquet"))
    path.write_bytes(pickle.dumps({"x": 1}))
    assert len(verify(copy, lambda line: None)) == 1


def test_no_module_of_ours_imports_pickle_at_any_depth() -> None:
    sources = [path for package in ("simfield", "adjust", "studies") for path in (TOP / package).rglob("*.py")]
    assert {"studies/store/store.py", "studies/lessons/apps/interval.py"} <= {
        p.relative_to(TOP).as_posix() for p in sources
    }
    assert [p for p in sources if LOADERS & imported(p.read_text(encoding="utf-8"))] == []


@pytest.mark.parametrize(
    "text", ["import os, pickle as p", "if 1:\n    from pickle import loads", "import dill.source"]
)
def test_an_import_of_pickle_is_seen_in_any_form(text: str) -> None:
    assert LOADERS & imported(text)


def imported(text: str) -> set[str]:
    """The packages that a source imports anywhere."""
    nodes = list(ast.walk(ast.parse(text)))
    whole = {alias.name for node in nodes if isinstance(node, ast.Import) for alias in node.names}
    parts = {node.module or "" for node in nodes if isinstance(node, ast.ImportFrom) and not node.level}
    return {name.partition(".")[0] for name in whole | parts}


@pytest.mark.parametrize("harm", ["flip", "truncate", "empty", "swap", "nominal", "garbage"])
def test_a_damaged_shard_is_named_and_computed_again(store: Path, copy: Path, harm: str) -> None:
    plan = Plan.of(study())
    path = copy / "trials" / plan.conditions[0].id / ("nominal.parquet" if harm == "nominal" else "1.parquet")
    raw = bytearray(path.read_bytes())
    if harm in ("flip", "nominal"):
        raw[len(raw) // 3] ^= 4
    elif harm == "truncate":
        del raw[-100:]
    elif harm == "empty":
        raw.clear()
    elif harm == "swap":
        raw = bytearray((path.parent / "2.parquet").read_bytes())
    else:
        raw = bytearray(b"garbage")
    path.write_bytes(raw)
    defects = verify(copy, lambda line: None)
    named = "0.parquet" if harm == "nominal" else "1.parquet"
    assert len(defects) == 1
    assert f"trials/{plan.conditions[0].id}/{named} is damaged" in defects[0]
    _, said = run_here(copy)
    assert said[0] == "5 of 6 blocks are there and whole"
    assert "is damaged" in said[1]
    assert contents(copy) == contents(store)


def test_verify_computes_again_and_finds_a_forged_number(copy: Path) -> None:
    """A shard that is whole in every respect and holds another number: only computing it again can tell."""
    plan = Plan.of(study())
    own = Store(copy, plan.identity_hash)
    columns = {k: v.copy() for k, v in own.read_shard(plan.conditions[0].id, 0, 32).items()}
    columns["none, cameras all, with aux|m0_um"][7] += 1e-12
    own.write_shard(plan.conditions[0].id, 0, columns)
    assert look_at(own, plan, plan.conditions[0], 0).state == "whole"
    defects = verify(copy, lambda line: None)
    assert len(defects) == 1
    assert "m0_um, trial 7: stored" in defects[0]


def test_foreign_files_are_named(copy: Path) -> None:
    (copy / "trials" / "0123456789abcdef").mkdir()
    (copy / "trials" / "0123456789abcdef" / "0.parquet").write_bytes(b"x")
    assert verify(copy, lambda line: None) == ["trials/0123456789abcdef/0.parquet belongs to no condition of the study"]


def test_unfinished_files_of_a_killed_run_are_removed(store: Path, copy: Path) -> None:
    left = next((copy / "trials").iterdir()) / "1.parquet.123.unfinished"
    left.write_bytes(b"half")
    _, said = run_here(copy)
    assert said[0] == "1 unfinished files of an interrupted run removed"
    assert contents(copy) == contents(store)


def test_two_runs_on_one_store_the_second_is_refused(copy: Path) -> None:
    with locked(copy), pytest.raises(LockedError, match="in use by another run"):
        run_here(copy)
    with locked(copy, "1-of-2"):
        run_here(copy, part=(2, 2))
        with pytest.raises(LockedError):
            run_here(copy, part=(1, 2))
        with pytest.raises(LockedError):
            run_here(copy)
    run_here(copy)


@pytest.mark.parametrize("name", ["trials", "failures", "manifest.json", "study.toml", "lock"])
def test_symbolic_links_out_of_the_store_are_refused(tmp_path: Path, name: str) -> None:
    outside = tmp_path / "outside"
    outside.mkdir()
    folder = tmp_path / "store"
    folder.mkdir()
    (folder / name).symlink_to(outside)
    with pytest.raises(StoreError, match="symbolic link"):
        run_here(folder)
    assert list(outside.iterdir()) == []


def test_a_link_in_the_place_of_a_shard_is_named_and_replaced(store: Path, copy: Path, tmp_path: Path) -> None:
    path = copy / "trials" / Plan.of(study()).conditions[0].id / "1.parquet"
    outside = tmp_path / "outside.parquet"
    path.rename(outside)
    path.symlink_to(outside)
    whole = outside.read_bytes()
    (defect,) = verify(copy, lambda line: None)
    assert "a link" in defect
    run_here(copy)
    assert not path.is_symlink()
    assert outside.read_bytes() == whole
    assert contents(copy) == contents(store)


def test_a_damaged_manifest_is_named(copy: Path) -> None:
    (copy / "manifest.json").write_text("{", encoding="utf-8")
    with pytest.raises(StoreError, match=r"manifest.json: damaged"):
        run_here(copy)
    (copy / "manifest.json").write_text(json.dumps([1]), encoding="utf-8")
    with pytest.raises(StoreError, match=r"manifest.json: damaged"):
        verify(copy, lambda line: None)


def test_a_shard_of_another_schema_is_no_shard(store: Path) -> None:
    plan = Plan.of(study())
    own = Store(store, plan.identity_hash)
    columns = own.read_shard(plan.conditions[0].id, NOMINAL, 1 << 16)
    raw = encode(columns, {"study": plan.identity_hash, "schema": 2})
    with pytest.raises(DamageError, match="schema is 2, not 1"):
        decode(raw, {"study": plan.identity_hash, "schema": 1}, 1 << 16)
