"""Workers of runs: processes of this machine, each with one thread.

Several machines share a sweep by the same command on each, with one folder that all of
them see: a run that another process computes is waited for, and each takes the runs in
an order of its own, so that this is seldom.
"""

from __future__ import annotations

import os
import random
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures.process import BrokenProcessPool
from typing import Any, TypeVar

from contbed.compiled.orphans import end_with
from contbed.errors import ContbedError
from contbed.many.store import Content

ATTEMPTS = 3  # times that workers may die before they begin a run

Task = TypeVar("Task", bound=tuple[Any, ...])  # the arguments of a function


def computed(
    function: Callable[..., Content],
    tasks: Sequence[Task],
    jobs: int,
    begun: Callable[[Task], bool],
    lost: Callable[[Task], Content],
) -> Iterator[tuple[Task, Content]]:
    """Yield each task with what a function returns for it, in the order in which they
    end, from `jobs` processes; -1 means one for each core, and 1 this process.

    Where a process dies, each task that has `begun` is done again alone, and if it
    kills its process there too, its outcome is that of a `lost` one.
    """
    if jobs == 1 or not tasks:
        yield from ((task, function(*task)) for task in tasks)
        return
    batches, deaths = deque([random.sample(tasks, len(tasks))]), 0
    while batches:
        batch = batches.popleft()
        left = dict(enumerate(batch))
        try:
            for number, outcome in _pooled(function, batch, jobs):
                yield left.pop(number), outcome
        except BrokenProcessPool:
            alone = [number for number, task in left.items() if begun(task)]
            if len(batch) == 1 and alone:
                yield batch[0], lost(batch[0])
                continue
            deaths = 0 if alone or len(left) < len(batch) else deaths + 1
            if deaths == ATTEMPTS:
                raise ContbedError(
                    "the worker processes die before they begin; see whether memory is "
                    "left"
                ) from None
            batches.append([left[number] for number in left if number not in alone])
            batches.extendleft([left[number]] for number in alone)


def _pooled(
    function: Callable[..., Content], tasks: Iterable[Task], jobs: int
) -> Iterator[tuple[int, Content]]:
    """Yield the number of each task and its outcome.

    Raises
    ------
    BrokenProcessPool : a process died
    """
    from joblib import Parallel, delayed, parallel_config

    with parallel_config(backend="loky", inner_max_num_threads=1):
        pool = Parallel(n_jobs=jobs, batch_size=1, return_as="generator_unordered")
        worker = delayed(_in_worker)
        yield from pool(
            worker(os.getpid(), function, number, task)
            for number, task in enumerate(tasks)
        )


def _in_worker(
    parent: int, function: Callable[..., Content], number: int, task: Task
) -> tuple[int, Content]:
    end_with(parent)
    return number, function(*task)
