"""User CPU of calls and programs; `machine` says what it was measured on."""

from __future__ import annotations

import os
import resource
import statistics
import subprocess
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from contbed.many.bench import machine

__all__ = ["Timed", "cpu", "cpu_of", "in_turn", "machine", "user_time"]
ONE_THREAD = dict.fromkeys(
    ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1"
)
LONG = 2.0  # CPU [s] of all samples together after which a call is not repeated


class Timed(NamedTuple):
    """What a call returned and the median of its user CPU [s]."""

    seconds: float
    result: Any


def user_time() -> float:
    """User CPU of this process [s]."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_utime


def cpu(call: Callable[[], Any], samples: int = 3, long: float = LONG) -> Timed:
    """Median user CPU of a call.

    Parameters
    ----------
    samples : number of samples, fewer where a call is long
    long : CPU [s] of all samples after which no other is taken
    """
    times: list[float] = []
    while not times or (len(times) < samples and sum(times) < long):
        start = user_time()
        result = call()
        times.append(user_time() - start)
    return Timed(statistics.median(times), result)


def in_turn(
    calls: Mapping[str, Callable[[], Any]], samples: int = 5
) -> dict[str, Timed]:
    """Median user CPU of several calls that take turns, so that a busy machine is
    shared fairly by all.
    """
    times: dict[str, list[float]] = {name: [] for name in calls}
    results: dict[str, Any] = {}
    for _ in range(samples):
        for name, call in calls.items():
            start = user_time()
            results[name] = call()
            times[name].append(user_time() - start)
    return {
        name: Timed(statistics.median(times[name]), results[name]) for name in calls
    }


def cpu_of(
    command: Sequence[str], folder: Path, printed: str = "printed"
) -> resource.struct_rusage:
    """Run a program with one thread in a folder, where its output is kept in a file;
    return what it used.

    Raises
    ------
    RuntimeError : the program fails
    """
    with open(folder / printed, "w") as out:
        process = subprocess.Popen(
            list(command),
            cwd=folder,
            stdout=out,
            stderr=subprocess.STDOUT,
            env={**os.environ, **ONE_THREAD},
        )
        _, status, usage = os.wait4(process.pid, 0)
    if status:
        last = (folder / printed).read_text(errors="replace")[-300:]
        raise RuntimeError(
            f"{' '.join(command)} ended with {os.waitstatus_to_exitcode(status)}: "
            f"{last}"
        )
    return usage
