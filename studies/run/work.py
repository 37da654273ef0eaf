"""The smallest unit of work: one block of trials, computed and written as a shard."""

from __future__ import annotations

from dataclasses import dataclass

from studies.design import BlockTask
from studies.run.worker import prepare
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


def run_task(store: Store, draw: Draw, task: BlockTask) -> Done:
    """Compute a block and write its shard. Raises OSError where it cannot be written."""
    prepare()
    columns, nominal, reasons = compute(task, draw)
    if task.block == 0:
        store.write_shard(task.condition.id, NOMINAL, nominal)
        if reasons:
            store.mark_reasons(task.condition.id, reasons)
    store.write_shard(task.condition.id, task.block, columns)
    return Done.of(task)
