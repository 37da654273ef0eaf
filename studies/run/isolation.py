"""A suspected block on its own: once more as a whole, then in lanes, then trial by trial, until the culprit is known.

Each attempt runs in a process of its own that can die or be killed without harm. Trials that bring it down, or do not
end, are returned with their fate; the block is then computed without them.
"""

from __future__ import annotations

import contextlib
import functools
import multiprocessing
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from multiprocessing.connection import Connection

from simfield.numerics import TOGETHER
from studies.design import BlockTask
from studies.run.backends import Broken, Work, task_limit_s
from studies.run.work import Done
from studies.run.worker import BackendError, prepare

Try = Callable[[BlockTask], object]
"""computes a block and writes nothing"""


def compute_without_culprits(task: BlockTask, work: Work, attempt: Try, trial_limit_s: float) -> dict[int, str]:
    """Finish a block that failed even alone; the trials that were given up, with "crashed" or "timeout".

    Raises OSError if the shard cannot be written and BackendError if the block fails even without its culprits.
    """
    lost = _culprits(task, attempt, trial_limit_s)
    fate = _in_process(work, replace(task, lost={**task.lost, **lost}), task_limit_s(task, trial_limit_s))
    if fate is not None:
        lost = dict.fromkeys(range(task.first, task.stop), fate)
        if _in_process(work, replace(task, lost=lost), task_limit_s(task, trial_limit_s)) is not None:
            raise BackendError(f"condition {task.condition.id}, block {task.block} fails even without its trials")
    return lost


def in_order(tasks: Sequence[BlockTask], work: Work, trial_limit_s: float) -> Iterator[Done | Broken]:
    """One after the other in a single process beside this one, which is replaced when it dies or hangs."""
    left = list(tasks)
    while left:
        with _process(_serve_all, work, left) as answers:
            while left:
                try:
                    answer = answers.recv() if answers.poll(task_limit_s(left[0], trial_limit_s)) else "timeout"
                except EOFError:
                    answer = "crashed"
                if isinstance(answer, Exception):
                    raise answer
                task = left.pop(0)
                yield Broken((task,), answer) if isinstance(answer, str) else answer
                if isinstance(answer, str):
                    break


def _culprits(task: BlockTask, attempt: Try, trial_limit_s: float) -> dict[int, str]:
    """The trials that bring a process down or do not end: lanes that do, and in these every trial alone."""
    lanes = [
        replace(task, first=first, stop=min(first + TOGETHER, task.stop))
        for first in range(task.first, task.stop, TOGETHER)
    ]
    suspects = [part for broken in _broken(lanes, attempt, trial_limit_s) for part in broken.tasks]
    trials = [
        replace(part, first=trial, stop=trial + 1)
        for part in suspects
        for trial in range(part.first, part.stop)
        if trial not in part.lost
    ]
    return {broken.tasks[0].first: broken.fate for broken in _broken(trials, attempt, trial_limit_s)}


def _broken(parts: Sequence[BlockTask], attempt: Try, trial_limit_s: float) -> list[Broken]:
    tried = in_order(parts, functools.partial(_tried, attempt), trial_limit_s)
    return [answer for answer in tried if isinstance(answer, Broken)]


def _tried(attempt: Try, part: BlockTask) -> Done:
    attempt(part)
    return Done.of(part)


def _in_process(work: Callable[[BlockTask], object], task: BlockTask, limit_s: float) -> str | None:
    """None if a process of its own finished the work, else "crashed" or "timeout". What the work raises is raised."""
    with _process(_serve, work, task) as answers:
        try:
            if not answers.poll(limit_s):
                return "timeout"
            error = answers.recv()
        except EOFError:
            return "crashed"
    if error is not None:
        raise error
    return None


@contextlib.contextmanager
def _process(serve: Callable[..., None], *arguments: object) -> Iterator[Connection]:
    """A process that answers through a connection; at the end it is gone, whatever it was doing."""
    context = multiprocessing.get_context("spawn")
    ours, theirs = context.Pipe()
    process = context.Process(target=serve, args=(theirs, *arguments), daemon=True)
    process.start()
    theirs.close()
    try:
        yield ours
    finally:
        ours.close()
        process.join(0.2)
        if process.is_alive():
            process.kill()
        process.join(5.0)


def _serve(answers: Connection, work: Callable[[BlockTask], object], task: BlockTask) -> None:
    prepare()
    try:
        work(task)
    except Exception as error:
        answers.send(error)
    else:
        answers.send(None)


def _serve_all(answers: Connection, work: Work, tasks: Sequence[BlockTask]) -> None:
    prepare()
    for task in tasks:
        try:
            answers.send(work(task))
        except Exception as error:
            answers.send(error)
            return
