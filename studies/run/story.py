"""A study, told as a story: lay it out, see what is there, compute what is missing, summarise, report."""

from __future__ import annotations

import functools
from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from simfield.files import whole_folder, write_whole
from studies.design import BlockTask, Plan, Study, StudyError
from studies.pages import study_report
from studies.run import backends, isolation
from studies.run.backends import Broken
from studies.run.work import Done, run_task
from studies.run.worker import BackendError, become_main
from studies.session import computer, program
from studies.store import (
    Shard,
    Store,
    StoreError,
    described,
    locked,
    look_at,
    other_program,
    programs_of,
    refuse_other,
)
from studies.summary import measure_faults, stopping, summary
from studies.trials import Draw, compute, image_points

TRIAL_LIMIT_S = 60.0
DERIVED = ("summary.csv", "summary.parquet", "differences.csv", "figure.svg", "figure.png", "report.md", "report.html")
"""what is made from the shards; nothing of it survives from a run with fewer trials or other methods"""
Say = Callable[[str], object]
Count = Callable[[int, int, int], object]
"""is told how many trials of how many that are known to be needed have been computed, and how many conditions are not
done"""


@dataclass(frozen=True)
class How:
    """How a study is computed; none of it touches the results.

    jobs: processes; backend: "joblib", "dask" or "here" (in this process, unwatched); part: (I, N) computes every N-th
    block from the I-th (from 1) and writes no summary; trial_limit_s: a trial that takes longer is given up; draw: what
    draws the trials; other_program: go on with a store that another version has begun, whose numbers may differ.
    """

    jobs: int = 1
    backend: str = "joblib"
    scheduler: str = ""
    part: tuple[int, int] | None = None
    trial_limit_s: float = TRIAL_LIMIT_S
    draw: Draw = image_points
    other_program: bool = False


@dataclass(frozen=True)
class Outcome:
    """What a run has come to: files written, and a line for each cell that failed and each trial that was lost."""

    files: tuple[Path, ...]
    failures: tuple[str, ...]


def run(
    study: Study,
    folder: Path,
    how: How | None = None,
    say: Say = lambda line: None,
    count: Count = lambda done, of, open_conditions: None,
) -> Outcome:
    """Run a study into a folder, or go on where it was left.

    Raises LockedError, StoreError for the store of another study, BackendError, OSError, ScenarioError.
    """
    how = how or How()
    become_main()
    plan = Plan.of(study)
    refuse_wrong_settings(plan)
    with locked(folder, "{}-of-{}".format(*how.part) if how.part else "") as swept:
        store = opened(folder, plan)
        if swept:
            say(f"{swept} unfinished files of an interrupted run removed")
        compute_missing(plan, store, how, say, count)
        if how.part:
            return Outcome((), tuple(lost_trials(plan, store)))
        return summarised(plan, store, say)


def refuse_wrong_settings(plan: Plan) -> None:
    """Raise StudyError for a setting that an AP model does not take, which only the models themselves know, and for a
    measure that none of them has.
    """
    for method in plan.methods:
        try:
            method.ap_model()
        except (KeyError, TypeError, ValueError) as error:
            raise StudyError(f"methods.ap: {method.key}: {error.args[0]}") from None
    if faults := list(measure_faults(plan)):
        raise StudyError("\n".join(faults))


def opened(folder: Path, plan: Plan) -> Store:
    """The store in a folder, new or one of this study. Raises StoreError with the differences to another study's."""
    store = Store(folder, plan.identity_hash)
    manifest = store.read_manifest()
    if manifest is not None:
        refuse_other(plan, manifest)
    write_whole(folder / "study.toml", plan.study.text.encode())
    _write_manifest(plan, store, programs_of(manifest or {}) if store.begun else [])
    return store


def _write_manifest(plan: Plan, store: Store, programs: Sequence[Mapping[str, str]]) -> None:
    store.write_manifest(plan.manifest({"columns": described(plan), "programs": list(programs), **computer()}))


def _admit_this_program(plan: Plan, store: Store, how: How, say: Say) -> None:
    """Note that this program computes trials of the store. Raises StoreError if another one has, unless it may."""
    mine, manifest = program(), store.read_manifest() or {}
    other = other_program(manifest, mine)
    if other is not None and not how.other_program:
        raise StoreError(
            f"{store.folder}: {other}; trials of both would be averaged. Run it into a new folder (--out), with the "
            "program that began it, or with --other-program if you know that the numbers are the same"
        )
    if other is not None:
        say(f"{other}; this run goes on beside them, and the manifest names both")
    store.begin()
    if mine not in programs_of(manifest):
        _write_manifest(plan, store, [*programs_of(manifest), mine])


def compute_missing(plan: Plan, store: Store, how: How, say: Say, count: Count) -> None:
    """Compute, round by round, what the plan asks for and the store has not."""
    known: dict[tuple[str, int], bool] = {}
    places = {condition.id: number for number, condition in enumerate(plan.conditions)}
    computed = 0
    for wanted in stopping.rounds(plan, store, how.jobs, whole_study=how.part is None):
        found = [
            look_at(store, plan, condition, block) for condition, block in wanted if _mine(plan, how, block, condition)
        ]
        _say_what_was_found(found, known, say)
        known |= {(s.condition.id, s.block): True for s in found}
        lost = {s.condition.id: store.failed(s.condition.id) for s in found}
        tasks = [plan.task(s.condition, s.block, lost[s.condition.id]) for s in found if s.state != "whole"]
        tasks.sort(key=lambda task: places[task.condition.id])  # a process keeps the geometry of its last condition
        left = Counter(task.condition.id for task in tasks)
        if tasks:
            _admit_this_program(plan, store, how, say)
        needed = computed + sum(len(task) for task in tasks)
        for done in finish(tasks, plan, store, how, say):
            computed += done.trials
            left -= Counter([done.condition_id])
            count(computed, needed, len(left))
        _refuse_absent(store, tasks)


def _refuse_absent(store: Store, tasks: Sequence[BlockTask]) -> None:
    """Raise BackendError if blocks were computed and are not in the store: the plan and the folder decide."""
    absent = [task for task in tasks if not store.shard_path(*task.name).exists()]
    if absent:
        raise BackendError(
            f"{len(absent)} of {len(tasks)} blocks were computed and are not in {store.folder}; do all workers see it?"
        )


def _mine(plan: Plan, how: How, block: int, condition: object) -> bool:
    if how.part is None:
        return True
    number, of = how.part
    place = block * len(plan.conditions) + [c is condition for c in plan.conditions].index(True)
    return place % of == number - 1


def _say_what_was_found(found: Sequence[Shard], known: dict[tuple[str, int], bool], say: Say) -> None:
    new = [shard for shard in found if (shard.condition.id, shard.block) not in known]
    whole = sum(shard.state == "whole" for shard in new)
    if whole:
        say(f"{whole} of {len(new)} blocks are there and whole")
    for shard in new:
        if shard.state in ("damaged", "short"):
            say(f"trials/{shard.condition.id}/{shard.block}.parquet is {shard.state} ({shard.reason}), computed again")


def finish(tasks: Sequence[BlockTask], plan: Plan, store: Store, how: How, say: Say) -> Iterator[Done]:
    """Compute blocks by the chosen backend, and alone those whose worker dies or does not end."""
    work = functools.partial(run_task, store, how.draw, program())
    attempt = functools.partial(compute, draw=how.draw)
    for answer in _answers(tasks, work, plan, store, how):
        if isinstance(answer, Broken):
            for task in answer.tasks:
                say(f"condition {task.condition.id}, block {task.block}: its worker died or did not end; tried alone")
            for again in isolation.in_order(answer.tasks, work, how.trial_limit_s):
                if isinstance(again, Done):
                    yield again
                    continue
                task = again.tasks[0]
                lost = isolation.compute_without_culprits(task, work, attempt, how.trial_limit_s)
                for trial, fate in lost.items():
                    store.mark_failed(task.condition.id, trial, {"status": fate, "trial": trial})
                yield Done.of(task)
        else:
            yield answer


def _answers(
    tasks: Sequence[BlockTask], work: backends.Work, plan: Plan, store: Store, how: How
) -> Iterator[Done | Broken]:
    if not tasks:
        return iter(())
    if how.backend == "here":
        return backends.here(tasks, work)
    if how.backend == "dask":
        return backends.dask_cluster(tasks, work, how.scheduler, how.trial_limit_s)
    if how.jobs == 1:
        return isolation.in_order(tasks, work, how.trial_limit_s)

    def done(task: BlockTask) -> bool:
        return look_at(store, plan, task.condition, task.block).state == "whole"

    return backends.joblib_processes(tasks, work, how.jobs, how.trial_limit_s, done)


def summarised(plan: Plan, store: Store, say: Say) -> Outcome:
    """Write summary, differences, figures and report, all from the shards alone."""
    summed = summary.summarise(plan, store)
    for note in summed.notes:
        say(note)
    with whole_folder(store.folder, DERIVED) as new:
        files = [*summary.write(summed, plan, new), *study_report.write(summed, plan, new)]
    return Outcome(tuple(store.folder / path.name for path in files), (*summed.failures, *lost_trials(plan, store)))


def lost_trials(plan: Plan, store: Store) -> list[str]:
    """A line for each trial that crashed or did not end, with the command that runs it alone."""
    return [
        f"condition {c.id}, trial {trial}: {fate}; simfield replay {store.folder} {c.id} {trial}"
        for c in plan.conditions
        for trial, fate in sorted(store.failed(c.id).items())
    ]
