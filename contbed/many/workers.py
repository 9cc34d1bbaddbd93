"""Workers of runs: processes of this machine, or workers of a dask cluster, each
with one thread.
"""

from __future__ import annotations

import os
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from concurrent.futures.process import BrokenProcessPool
from pathlib import Path
from tempfile import NamedTemporaryFile
from typing import Any, Literal

from contbed.compiled.orphans import end_with
from contbed.errors import ContbedError
from contbed.many.runs import Case, compute, give_up, is_begun, known
from contbed.many.store import Content

WAIT = 30.0  # s for the scheduler to answer, and for its first worker
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
    batches, deaths = deque([cases]), 0
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


def on_cluster(cases: list[Case], out: Path, scheduler: str) -> Found:
    """Yield the runs on the workers of a dask scheduler, in the order in which they
    end.

    Raises
    ------
    ContbedError : dask is not installed, the scheduler does not answer, or its workers
        cannot compute these runs
    """
    distributed = require_dask()
    try:
        client = distributed.Client(scheduler, timeout=WAIT, set_as_default=False)
    except (OSError, ValueError) as error:
        raise ContbedError(
            f"no dask scheduler answers at {scheduler}: {' '.join(str(error).split())}"
        ) from error
    with client:
        _inspect(client, out, scheduler)
        futures = {
            client.submit(_on_cluster_worker, case, out, pure=False): case
            for case in cases
        }
        deaths: dict[str, int] = {}
        ended = distributed.as_completed(futures, loop=client.loop)
        for future in ended:
            case = futures.pop(future)
            if future.status == "finished":
                try:
                    outcome = future.result()
                except (OSError, distributed.CancelledError) as error:
                    raise _lost(scheduler) from error
                yield case, outcome
            elif future.status == "error" and isinstance(
                future.exception(), distributed.KilledWorker
            ):
                deaths[case.name] = deaths.get(case.name, 0) + 1
                if is_begun(case, out) or deaths[case.name] == ATTEMPTS:
                    yield case, give_up(case, out)
                else:  # it only waited where others died
                    again = client.submit(_on_cluster_worker, case, out, pure=False)
                    futures[again] = case
                    ended.add(again)
            elif future.status == "error":
                raise future.exception()
            # it died with the worker that held it, and comes again
            elif future.status in ("pending", "lost"):
                futures[future] = case
                ended.add(future)
            else:
                raise _lost(scheduler)


def _lost(scheduler: str) -> ContbedError:
    return ContbedError(
        f"lost the scheduler at {scheduler}; the same command resumes from here"
    )


def _on_cluster_worker(case: Case, out: Path) -> Content:
    os.environ.setdefault("NUMBA_NUM_THREADS", "1")  # `_inspect` has checked the others
    return compute(case, out)


def require_dask() -> Any:
    """Return the module of dask's scheduler, or raise ContbedError with what to
    install.
    """
    try:
        import distributed
    except ImportError:
        raise ContbedError(
            "--scheduler needs dask: pip install 'contbed[cluster]', here and on the "
            "workers"
        ) from None
    return distributed


def _inspect(client: Any, out: Path, scheduler: str) -> None:
    """Refuse workers that have another contbed, do not see the folder, or run
    several scenes in one process.
    """
    from contbed import __version__

    try:
        client.wait_for_workers(1, timeout=WAIT)
    except TimeoutError:
        raise ContbedError(
            f"the scheduler at {scheduler} has no worker; start some: dask worker "
            f"{scheduler}"
        ) from None
    with NamedTemporaryFile(dir=out) as token:
        try:
            found = client.run(_probe, token.name)
        except Exception as error:
            raise ContbedError(
                f"a worker cannot run contbed: {type(error).__name__}: {error}"
            ) from error
    for worker, (version, sees, pinned) in found.items():
        if version != __version__:
            raise ContbedError(
                f"worker {worker} has contbed {version}, here it is {__version__}; "
                "install the same"
            )
        if not sees:
            raise ContbedError(
                f"worker {worker} does not see {out}; give a folder that all machines "
                "share with --out"
            )
        if not pinned:
            raise ContbedError(
                f"worker {worker} may use several threads a run; start it with "
                "OMP_NUM_THREADS=1"
            )
    for worker, threads in client.nthreads().items():
        if threads > 1:
            raise ContbedError(
                f"worker {worker} has {threads} threads; start it with --nthreads 1 "
                "--nworkers -1"
            )


def _probe(token: str) -> tuple[str, bool, bool]:
    """Return version, whether the folder is seen, and whether linear algebra keeps
    to one thread, of a worker.
    """
    from contbed import __version__

    return __version__, Path(token).exists(), os.environ.get("OMP_NUM_THREADS") == "1"
