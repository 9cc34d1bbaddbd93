"""One run of a sweep: its folder, its outcome, and what its workers did.

`runs/NAME/` holds what the run writes, and

    outcome.json    exit code, problem, parameters and named results; the scene too if the run failed; a checksum
    workers.log     a line when a worker begins the run and when it has ended it

The outcome appears whole or not at all, after everything else, and a run that has one is never computed again, unless
its content does not fit its checksum. The log
is locked by the worker that computes: if two want the same run, the second waits and takes what the first has found.
"""

from __future__ import annotations

import fcntl
import hashlib
import json
import os
import socket
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import IO, Any

from contbed.errors import ContbedError, SceneError
from contbed.many.sweep.study import Case
from contbed.output.summary import plain, write_json
from contbed.scene.identity import resolved

OUTCOME = "outcome.json"
LOG = "workers.log"
KILLED = 137  # what a shell returns for a process that was killed
_BEGUN = "begun"

Outcome = dict[str, Any]


def folder_of(case: Case, out: Path) -> Path:
    """Return the folder of a run."""
    return out / "runs" / case.name


def known(case: Case, out: Path) -> Outcome | None:
    """Return the outcome of a run; None if it is not finished, or if its file is damaged."""
    try:
        outcome = json.loads((folder_of(case, out) / OUTCOME).read_text(encoding="utf-8"))
        return outcome if outcome["checksum"] == _checksum(outcome) else None
    except (FileNotFoundError, NotADirectoryError, ValueError, AttributeError, KeyError, TypeError):
        return None


def is_damaged(case: Case, out: Path) -> bool:
    """Return whether the outcome of a run does not fit its checksum."""
    return (folder_of(case, out) / OUTCOME).is_file() and known(case, out) is None


def _checksum(outcome: Outcome) -> str:
    content = {key: value for key, value in outcome.items() if key != "checksum"}
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()[:16]


def forget(case: Case, out: Path) -> None:
    """Delete the outcome of a run, so that it is computed again."""
    (folder_of(case, out) / OUTCOME).unlink(missing_ok=True)


def is_begun(case: Case, out: Path) -> bool:
    """Return whether the last entry in the log of a run is that a worker began it."""
    try:
        return (folder_of(case, out) / LOG).read_text(encoding="utf-8").rstrip().endswith(_BEGUN)
    except OSError:
        return False


def compute(case: Case, out: Path) -> Outcome:
    """Run a scene and keep its outcome; what is already there is returned as it is.

    Raises
    ------
    ContbedError, OSError : the disk is full or cannot be written; this is no fault of the scene and is not kept
    """
    with _claimed(case, out) as log:
        if (found := known(case, out)) is not None:
            return found
        _note(log, _BEGUN)
        return _keep(case, out, log, lambda: _results(case, out))


def give_up(case: Case, out: Path) -> Outcome:
    """Return a failed outcome for a run whose workers died, or the outcome that one of them has found after all."""
    with _claimed(case, out) as log:
        if (found := known(case, out)) is not None:
            return found
        text = "its worker died: out of memory, killed from outside, or crashed"
        return _keep(case, out, log, lambda: (KILLED, text, {}))


@contextmanager
def _claimed(case: Case, out: Path) -> Iterator[IO[str]]:
    folder = folder_of(case, out)
    folder.mkdir(parents=True, exist_ok=True)
    with open(folder / LOG, "a", encoding="utf-8", opener=_no_link) as log, locked(log.fileno()):
        yield log


def _no_link(path: str, flags: int) -> int:
    """Open a file, but not where a link leads."""
    return os.open(path, flags | os.O_NOFOLLOW, 0o666)


@contextmanager
def locked(descriptor: int) -> Iterator[None]:
    """Hold the lock of an open file or folder for the block; the system releases it when the process ends."""
    with suppress(OSError):  # a file system without locks
        fcntl.flock(descriptor, fcntl.LOCK_EX)
    try:
        yield
    finally:
        with suppress(OSError):
            fcntl.flock(descriptor, fcntl.LOCK_UN)


def _keep(case: Case, out: Path, log: IO[str], solve: Callable[[], tuple[int, str, dict[str, Any]]]) -> Outcome:
    code, problem, qoi = solve()
    outcome = {"exit_code": code, "problem": problem, "parameters": case.parameters, "qoi": qoi}
    if code:
        outcome["scene"] = resolved(case.scene)
    outcome = plain(outcome)
    write_json(folder_of(case, out) / OUTCOME, outcome | {"checksum": _checksum(outcome)})
    _note(log, f"failed with {code}" if code else "finished")
    found = known(case, out)  # exactly what a later sweep will read
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
        code, name = (error.exit_code, "") if isinstance(error, ContbedError) else (1, f"{type(error).__name__}: ")
        return code, f"{name}{error}".replace("\n", "; "), {}
    return 0, "", dict(result.summary.get("qoi", {}))


def _is_disk(error: Exception) -> bool:
    """Return whether a file could not be written, which the next run would also fail at."""
    return isinstance(error, OSError) or (isinstance(error.__cause__, OSError) and not isinstance(error, SceneError))


def _note(log: IO[str], text: str) -> None:
    now = time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime())
    log.write(f"{now} {socket.gethostname()} {os.getpid()} {text}\n")
    log.flush()
