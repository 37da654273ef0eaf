"""Where blocks are computed: here, in processes of this machine (joblib with loky), or on a cluster (dask).

A worker writes its shards itself, so nothing travels back, and the store tells what is done. A block whose worker died
or did not end is taken to `isolation`, which finds the trial that did it; everything else goes on.
"""

from __future__ import annotations

import contextlib
import logging
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Any

from studies.design import BlockTask
from studies.run.work import Done
from studies.run.worker import BackendError, prepare

Work = Callable[[BlockTask], Done]
"""computes a block and writes its shard"""

LOST_SCHEDULER_S = 20.0
LOOK_EVERY_S = 0.1


@dataclass(frozen=True)
class Broken:
    """These blocks were under way when a worker died or a time limit passed; fate is "crashed" or "timeout"."""

    tasks: tuple[BlockTask, ...]
    fate: str = "crashed"


def task_limit_s(task: BlockTask, trial_limit_s: float) -> float:
    """How long a block may take: a trial's limit, and as long again for every thousand adjustments."""
    return trial_limit_s * (2.0 + len(task) * len(task.methods) / 1000.0)


def here(tasks: Sequence[BlockTask], work: Work) -> Iterator[Done | Broken]:
    """One after the other in this process: for tests and small studies; nothing watches over it."""
    for task in tasks:
        yield work(task)


def joblib_processes(
    tasks: Sequence[BlockTask], work: Work, jobs: int, trial_limit_s: float, done: Callable[[BlockTask], bool]
) -> Iterator[Done | Broken]:
    """In processes of this machine; after a break the pool is started anew without the blocks under suspicion."""
    from concurrent.futures.process import BrokenProcessPool

    from joblib import Parallel, delayed

    left = list(tasks)
    while left:
        limit = max(task_limit_s(task, trial_limit_s) for task in left)
        parallel: Any = Parallel(
            n_jobs=jobs, backend="loky", return_as="generator_unordered", batch_size=1, pre_dispatch="2*n_jobs",
            timeout=limit, initializer=prepare,
        )  # fmt: skip
        finished = parallel(delayed(work)(task) for task in left)
        try:
            yield from finished
            return
        except (BrokenProcessPool, TimeoutError):
            _kill_pool()
        except BaseException:
            _kill_pool()
            raise
        finally:
            with contextlib.suppress(BaseException):
                finished.close()
        left = [task for task in left if not done(task)]
        suspects = tuple(left[: 2 * jobs])  # no more than these can have been under way
        left = left[2 * jobs :]
        if suspects:
            yield Broken(suspects)


def _kill_pool() -> None:
    from joblib.externals.loky import reusable_executor

    executor = reusable_executor._executor
    if executor is not None:
        executor.shutdown(wait=True, kill_workers=True)


def dask_cluster(
    tasks: Sequence[BlockTask], work: Work, scheduler: str, trial_limit_s: float
) -> Iterator[Done | Broken]:
    """On a running dask cluster. Raises BackendError if there is none or its scheduler is lost."""
    try:
        import distributed
    except ImportError:
        raise BackendError("--backend dask needs the extra `cluster`: pip install 'simfield[cluster]'") from None
    client_of: Any = distributed.Client
    with _without_its_log():
        try:
            client: Any = client_of(scheduler, timeout=10, set_as_default=False)
        except (OSError, TimeoutError, ValueError) as error:
            raise BackendError(f"no dask scheduler at {scheduler}: {str(error).splitlines()[0]}") from None
        yield from _answers(client, tasks, work, scheduler, trial_limit_s)


def _answers(
    client: Any, tasks: Sequence[BlockTask], work: Work, scheduler: str, trial_limit_s: float
) -> Iterator[Done | Broken]:
    """What a connected cluster gives; the client is closed at the end."""
    try:
        waiting = client.map(work, tasks, pure=False, retries=1, batch_size=None)
        by_key = dict(zip((f.key for f in waiting), tasks, strict=True))
        patience = max((task_limit_s(task, trial_limit_s) for task in tasks), default=trial_limit_s)
        ends = time.monotonic() + patience
        while waiting:
            _refuse_lost(client, scheduler)
            finished = [f for f in waiting if f.done()]
            if any(f.cancelled() for f in finished):  # nobody else cancels: the scheduler has gone
                raise BackendError(f"the dask scheduler at {scheduler} is lost")
            time.sleep(0.0 if finished else LOOK_EVERY_S)
            if finished:
                ends = time.monotonic() + patience
            elif time.monotonic() > ends:
                client.cancel(list(waiting), force=True)
                yield Broken(tuple(by_key[f.key] for f in waiting))
                return
            # what is finished is forgotten at once: a cluster computes again what a dying worker had kept for us
            waiting = [f for f in waiting if f not in finished]
            answers = [_outcome(f, by_key[f.key]) for f in finished]
            finished.clear()
            yield from answers
    finally:
        with contextlib.suppress(Exception):
            client.close(timeout=5)


@contextlib.contextmanager
def _without_its_log() -> Iterator[None]:
    """What dask logs on a lost connection are tracebacks; we say it in a line."""
    loggers = [logging.getLogger(name) for name in ("distributed", "distributed.client", "tornado", "asyncio")]
    before = [logger.level for logger in loggers]
    for logger in loggers:
        logger.setLevel(logging.CRITICAL + 1)
    try:
        yield
    finally:
        for logger, level in zip(loggers, before, strict=True):
            logger.setLevel(level)


def _outcome(future: Any, task: BlockTask) -> Done | Broken:
    from distributed.scheduler import KilledWorker

    if future.status == "finished":
        return Done.of(
            task
        )  # the shard is on the disk; to fetch a result from a worker that has died would take for ever
    try:
        error = future.exception(timeout=LOST_SCHEDULER_S)
    except TimeoutError:
        return Broken((task,))
    if error is None or isinstance(error, KilledWorker):
        return Broken((task,))
    raise error


def _refuse_lost(client: Any, scheduler: str) -> None:
    """Raise BackendError when the scheduler has been away for LOST_SCHEDULER_S."""
    ends = time.monotonic() + LOST_SCHEDULER_S
    while client.status != "running":
        if client.status in ("closed", "closing") or time.monotonic() > ends:
            raise BackendError(f"the dask scheduler at {scheduler} is lost")
        time.sleep(LOOK_EVERY_S)
