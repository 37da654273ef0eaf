"""The smallest unit of work: one block of trials, computed and written as a shard."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from studies.design import BlockTask
from studies.run.worker import BackendError, prepare
from studies.session import program
from studies.store import NOMINAL, Store
from studies.trials import Draw, compute


@dataclass(frozen=True)
class Done:
    """A block of so many trials of this condition is computed."""

    condition_id: str
    trials: int

    @classmethod
    def of(cls, task: BlockTask) -> Done:
        return cls(task.condition.id, len(task))


def run_task(store: Store, draw: Draw, wanted: Mapping[str, str], task: BlockTask) -> Done:
    """Compute a block and write its shard, by the program that is wanted.

    Raises OSError where it cannot be written, BackendError in a process of a cluster that has another program.
    """
    if program() != wanted:
        apart = [f"{name} {mine} and not {wanted[name]}" for name, mine in program().items() if mine != wanted[name]]
        raise BackendError(f"a worker has {', '.join(apart)}: install the same simfield everywhere")
    prepare()
    columns, nominal, reasons = compute(task, draw)
    if task.block == 0:
        store.write_shard(task.condition.id, NOMINAL, nominal)
        if reasons:
            store.mark_reasons(task.condition.id, reasons)
    store.write_shard(task.condition.id, task.block, columns)
    return Done.of(task)
