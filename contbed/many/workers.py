"""Workers of runs: processes of this machine, each with one thread.

Several machines share a sweep by the same command on each, with one folder that all of
them see: a run that another process computes is waited for, and each takes the runs in
an order of its own, so that this is seldom.
"""

from __future__ import annotations

import os
import random
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path
from typing import Any, Literal

from contbed.compiled.orphans import end_with
from contbed.errors import ContbedError
from contbed.many.runs import Case, compute, give_up, is_begun, known
from contbed.many.store import Content

ATTEMPTS = 3  # times that workers may die before they begin a run

Found = Iterator[tuple[Case, Content]]


def in_this_process(cases: list[Case], out: Path) -> Found:
    """Yield one run after the other."""
    for case in cases:
        yield case, compute(case, out)


def on_this_machine(cases: list[Case], out: Path, jobs: int) -> Found:
    """Yield the runs of `jobs` processes in the order in which they end; -1 means
    one for each core.
    """
    batches, deaths = deque([random.sample(cases, len(cases))]), 0
    while batches:
        batch, done = batches.popleft(), set()
        try:
            for case, outcome in pooled(
                _pair, [(case, out) for case in batch], jobs, batch=1
            ):
                done.add(case.name)
                yield case, outcome
        except BrokenProcessPool:
            left: list[Case] = []
            for case in batch:
                if case.name in done:
                    continue
                if (found := known(case, out)) is None:
                    left.append(case)
                else:
                    yield case, found
            begun = [case for case in left if is_begun(case, out)]
            if len(batch) == 1 and begun:
                yield batch[0], give_up(batch[0], out)
                continue
            deaths = 0 if begun or len(left) < len(batch) else deaths + 1
            if deaths == ATTEMPTS:
                raise ContbedError(
                    "the worker processes die before they begin; see whether memory is "
                    "left"
                ) from None
            batches.extendleft(
                [
                    [case for case in left if case not in begun],
                    *([case] for case in begun),
                ]
            )


def pooled(
    function: Callable[..., Any],
    tasks: Iterable[tuple[Any, ...]],
    jobs: int,
    batch: int | Literal["auto"] = "auto",
) -> Iterator[Any]:
    """Yield what a function returns for the arguments of each task, from `jobs`
    processes, as they end.

    `batch` is the number of tasks that a process takes at a time.

    Raises
    ------
    BrokenProcessPool : a process died
    """
    from joblib import Parallel, delayed, parallel_config

    with parallel_config(backend="loky", inner_max_num_threads=1):
        pool = Parallel(n_jobs=jobs, batch_size=batch, return_as="generator_unordered")
        worker = delayed(_in_worker)
        yield from pool(worker(os.getpid(), function, task) for task in tasks)


def _in_worker(parent: int, function: Callable[..., Any], task: tuple[Any, ...]) -> Any:
    end_with(parent)
    return function(*task)


def _pair(case: Case, out: Path) -> tuple[Case, Content]:
    return case, compute(case, out)
