"""Runs of scenes, each with its folder, its outcome, and what its workers did.

`runs/NAME/` holds what the run writes, and

    outcome.json    exit code, problem, parameters and named results; the scene too if the run failed; a checksum
    workers.log     a line when a worker begins the run and when it has ended it

The outcome appears whole or not at all, after everything else, and a run that has one
is never computed again. The log is locked by the worker that computes: if two want the
same run, the second waits and takes what the first has found.
"""

from __future__ import annotations

import os
import socket
import time
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Any

from contbed.errors import ContbedError, SceneError
from contbed.many.store import Content, locked, opened, sealed
from contbed.output.summary import write_json
from contbed.scene.identity import resolved, scene_hash
from contbed.scene.tables import SceneBase

OUTCOME = "outcome.json"
LOG = "workers.log"
KILLED = 137  # what a shell returns for a process that was killed
DIED = "its worker died: out of memory, killed from outside, or crashed"
_BEGUN = "begun"


@dataclass(frozen=True)
class Case:
    """One run: its name (the hash of its scene), the values of the parameters in SI,
    and the scene.
    """

    name: str
    parameters: Mapping[str, Any]
    scene: SceneBase


def case_of(scene: SceneBase, parameters: Mapping[str, Any]) -> Case:
    """Return the run of a scene under its name."""
    return Case(scene_hash(scene), parameters, scene)


def folder_of(case: Case, out: Path) -> Path:
    """Return the folder of a run."""
    return out / "runs" / case.name


def known(case: Case, out: Path, retry_failed: bool = False) -> Content | None:
    """Return the outcome of a run; None if it is not finished, its file is damaged,
    or it failed and is tried again.
    """
    file = folder_of(case, out) / OUTCOME
    try:
        outcome = opened(file.read_text(encoding="utf-8"))
    except (FileNotFoundError, NotADirectoryError, ValueError):
        return None
    if outcome is not None and retry_failed and outcome["exit_code"]:
        file.unlink(missing_ok=True)
        return None
    return outcome


def is_damaged(case: Case, out: Path) -> bool:
    """Return whether the outcome of a run does not fit its checksum."""
    return (folder_of(case, out) / OUTCOME).is_file() and known(case, out) is None


def is_begun(case: Case, out: Path) -> bool:
    """Return whether the last entry in the log of a run is that a worker began it."""
    try:
        return (
            (folder_of(case, out) / LOG)
            .read_text(encoding="utf-8")
            .rstrip()
            .endswith(_BEGUN)
        )
    except OSError:
        return False


def compute(case: Case, out: Path) -> Content:
    """Run a scene and keep its outcome; what is already there is returned as it is.

    Raises
    ------
    ContbedError, OSError : the disk is full or cannot be written; this is no fault of
        the scene and is not kept
    """
    with _claimed(case, out) as log:
        if (found := known(case, out)) is not None:
            return found
        _note(log, _BEGUN)
        return _keep(case, out, log, lambda: _results(case, out))


def give_up(case: Case, out: Path) -> Content:
    """Return a failed outcome for a run whose workers died, or the outcome that one
    of them has found after all.
    """
    with _claimed(case, out) as log:
        if (found := known(case, out)) is not None:
            return found
        return _keep(case, out, log, lambda: (KILLED, DIED, {}))


def failure(error: Exception) -> tuple[int, str]:
    """Return the exit code and the problem, on one line, of a run that raised an
    error.
    """
    code, name = (
        (error.exit_code, "")
        if isinstance(error, ContbedError)
        else (1, f"{type(error).__name__}: ")
    )
    return code, f"{name}{error}".replace("\n", "; ")


@contextmanager
def _claimed(case: Case, out: Path) -> Iterator[IO[str]]:
    folder = folder_of(case, out)
    folder.mkdir(parents=True, exist_ok=True)
    with (
        open(folder / LOG, "a", encoding="utf-8", opener=_no_link) as log,
        locked(log.fileno()),
    ):
        yield log


def _no_link(path: str, flags: int) -> int:
    """Open a file, but not where a link leads."""
    return os.open(path, flags | os.O_NOFOLLOW, 0o666)


def _keep(
    case: Case,
    out: Path,
    log: IO[str],
    solve: Callable[[], tuple[int, str, dict[str, Any]]],
) -> Content:
    code, problem, qoi = solve()
    outcome = {
        "exit_code": code,
        "problem": problem,
        "parameters": case.parameters,
        "qoi": qoi,
    }
    if code:
        outcome["scene"] = resolved(case.scene)
    write_json(folder_of(case, out) / OUTCOME, sealed(outcome))
    _note(log, f"failed with {code}" if code else "finished")
    found = known(case, out)  # exactly what a later study will read
    assert found is not None
    return found


def _results(case: Case, out: Path) -> tuple[int, str, dict[str, Any]]:
    """Return the exit code, problem and named results of a run."""
    from contbed.runner import run

    scene: Any = case.scene
    try:
        result = run(scene, out=folder_of(case, out), quiet=True)
    except Exception as error:  # one broken run must not lose the others
        if _is_disk(error):
            raise
        return *failure(error), {}
    return 0, "", dict(result.summary.get("qoi", {}))


def _is_disk(error: Exception) -> bool:
    """Return whether a file could not be written, which the next run would also fail
    at.
    """
    return isinstance(error, OSError) or (
        isinstance(error.__cause__, OSError) and not isinstance(error, SceneError)
    )


def _note(log: IO[str], text: str) -> None:
    now = time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime())
    log.write(f"{now} {socket.gethostname()} {os.getpid()} {text}\n")
    log.flush()
