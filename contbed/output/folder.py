"""The folder of a run: one run at a time, files that belong together, and a summary
that never says too much.

While a run lasts it holds `.contbed.lock`, which the system takes from a process that
dies, and `summary.json` says "running". The summary lists the files that the run has
written; the next run into the folder removes them, and nothing else, before it writes
its own.

A study resumes in its folder, and `.contbed.study` lists the names of its results.
"""

from __future__ import annotations

import errno
import fcntl
import json
import os
import re
import socket
import time
from collections.abc import Collection, Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from contbed.errors import ContbedError, SceneError
from contbed.output import files
from contbed.output.summary import write_json

LOCK = ".contbed.lock"
STUDY = ".contbed.study"
SUMMARY = "summary.json"
_NAMES = (
    r"(profiles|outlet|levels|continuation|states|branches)\.csv"
    r"|(fields|particles|packing)\.vtu"
)
# names that runs give to results which a scene may read as well
RESULTS = re.compile(rf"{_NAMES}|(fields|particles)_\d+\.vtu")
_PICTURES = r"(profiles|fields|outlet|heat|continuation)\.png|(fields|particles)\.pvd"
_REPLACED = re.compile(
    rf"{_NAMES}|{_PICTURES}|summary\.json|checkpoint\.npz|closure\.toml"
)
_LEFT = re.compile(rf".+\.[0-9a-f]{{{2 * files.TOKEN}}}\.part")
_NO_LOCKS = {errno.ENOLCK, errno.ENOTSUP, errno.ENOSYS, errno.EINVAL}


class RunFolder:
    """A folder that this run alone writes to; made by `occupied`."""

    def __init__(self, path: Path):
        self.path = path
        self.files: list[str] = []
        self._running: dict[str, Any] | None = None
        self._former: dict[str, Any] = {}
        self._read: set[Path] = set()

    def begin(
        self, about: Mapping[str, Any], keep: bool, inputs: Collection[Path] = ()
    ) -> None:
        """Remove what the former run wrote, unless its files are kept because it
        resumes, and say "running".

        Parameters
        ----------
        about : what the summary says of the run from its start
        keep : the run resumes from this folder's checkpoint, and its earlier files stay
        inputs : files that the run reads; they stay too

        Raises
        ------
        ContbedError : the folder has files of others with the names of results
        """
        self._former = former = read_summary(self.path)
        names = _listed(former)
        self._read = {path.resolve() for path in inputs}
        if keep:
            self.files = [name for name in names if name != SUMMARY]
        else:
            self._require_own([*names, *([SUMMARY] if former else [])])
            for name in names:
                if (self.path / name).resolve() not in self._read:
                    with suppress(OSError):
                        (self.path / name).unlink()
        for left in self.path.iterdir():
            if _LEFT.fullmatch(left.name):
                left.unlink(missing_ok=True)
        now = time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime())
        self._running = {
            "status": "running",
            "process": os.getpid(),
            "host": socket.gethostname(),
            "begun": now,
            **about,
        }
        self._say()

    def _require_own(self, names: Collection[str]) -> None:
        """Call `_refuse` for files with the names of results, but for `names`, those
        of the former run, and files that the run reads.
        """
        found = [
            path
            for path in self.path.iterdir()
            if _REPLACED.fullmatch(path.name)
            and path.name not in names
            and path.resolve() not in self._read
        ]
        _refuse(self.path, found)

    def end(self, summary: Mapping[str, Any]) -> None:
        """Write the summary of the results, with the machine and the time at which
        the run began.
        """
        origin = (
            {key: self._running[key] for key in ("host", "begun")}
            if self._running
            else {}
        )
        self._running = None
        write_json(
            self.path / SUMMARY,
            {**summary, **origin, "files": sorted({*self.files, SUMMARY})},
        )

    def give_back(self) -> None:
        """Leave the summary as it was: the run cannot resume from this folder and
        has changed nothing in it.
        """
        self._running = None
        if self._former:
            write_json(self.path / SUMMARY, self._former)

    def mark_failed(self, status: str, problem: str) -> None:
        """Say in the summary of an earlier run that a later one has failed before it
        began; all files stay.
        """
        former = read_summary(self.path)
        if not former:
            return
        warnings = [
            warning
            for warning in former.get("warnings", ())
            if isinstance(warning, str)
        ]
        text = (
            f"a later run failed before it began: {problem}; all files here are of "
            "the run before"
        )
        write_json(
            self.path / SUMMARY,
            {**former, "status": status, "warnings": [text, *warnings]},
        )

    def note(self, name: str) -> None:
        """Add a file to those of the run, before it is written.

        Raises
        ------
        ContbedError : it is a file that the run reads, or one of others
        """
        if (self.path / name).resolve() in self._read:
            raise ContbedError(
                f"cannot write {self.path / name}: the run reads this file; give "
                "another folder"
            )
        if self._running is not None and name not in (*self.files, SUMMARY):
            _refuse(self.path, filter(Path.is_file, [self.path / name]))
            self.files.append(name)
            self._say()

    def _say(self) -> None:
        write_json(
            self.path / SUMMARY,
            {**(self._running or {}), "files": sorted({*self.files, SUMMARY})},
        )


def require_inputs_elsewhere(folder: Path, inputs: Iterable[tuple[str, Path]]) -> None:
    """Refuse a folder for results in which a file that a run reads has the name of a
    result.

    `inputs` are these files, each with its place in the scene.

    Raises
    ------
    SceneError : the run would replace what it reads
    """
    there = folder.resolve()
    problems = [
        f"{place}: {file.name} lies in {folder}, the folder for the results, which "
        "would replace it; give another "
        "folder by --out, or copy the file out of this one"
        for place, file in inputs
        for each in dict.fromkeys((file, file.resolve()))
        if each.parent.resolve() == there and RESULTS.fullmatch(each.name)
    ]
    if problems:
        raise SceneError(problems)


def prepare_study(folder: Path, *names: str) -> None:
    """Make the folder of a study before its first run; one that the study has written
    to stays as it is.

    Parameters
    ----------
    folder : made where it is missing
    names : names of the results below the folder; * stands for any characters

    Raises
    ------
    ContbedError : the system cannot write there, or the folder has files of others
        with the names of results
    """
    files.prepare(folder)
    mark = folder / STUDY
    listed = mark.read_text(encoding="utf-8").split() if mark.is_file() else []
    new = [name for name in names if name not in listed]
    own = {folder / name for name in _listed(read_summary(folder))}
    _refuse(folder, {path for name in new for path in folder.glob(name)} - own)
    if new:
        with files.atomic(mark) as temporary:
            temporary.write_text("\n".join([*listed, *new]), encoding="utf-8")


def require_own(file: Path, mark: str = "") -> None:
    """Refuse to replace a file that no run lists and that does not hold a mark.

    Raises
    ------
    ContbedError : it is a file of others
    """
    if not file.is_file() or file.name in _listed(read_summary(file.parent)):
        return
    if not mark or mark.encode() not in file.read_bytes():
        _refuse(file.parent, [file])


def list_file(file: Path) -> None:
    """Add a file to those of the run in its folder, which the next run there removes."""
    summary = read_summary(file.parent)
    listed = summary.get("files")
    if listed is not None and file.name not in listed:
        write_json(
            file.parent / SUMMARY, {**summary, "files": sorted([*listed, file.name])}
        )


def _refuse(folder: Path, found: Iterable[Path]) -> None:
    """Refuse files of others; links are replaced and not followed.

    Raises
    ------
    ContbedError : a run would replace them
    """
    foreign = [
        str(path.relative_to(folder)) for path in sorted(found) if not path.is_symlink()
    ]
    if foreign:
        raise ContbedError(
            f"{folder}: {', '.join(foreign)}: not written by a run of contbed, "
            "which would replace it; move it, or give another folder by --out"
        )


@contextmanager
def occupied(folder: Path) -> Iterator[RunFolder]:
    """Make a folder and hold it for the block.

    Raises
    ------
    ContbedError : the system cannot write there, or another run does
    """
    new = not folder.exists()
    files.prepare(folder)
    lock = _lock(folder)
    place = RunFolder(folder)
    key = folder.resolve()
    files.watchers[key] = place.note
    try:
        yield place
    finally:
        del files.watchers[key]
        with suppress(OSError):
            (folder / LOCK).unlink()
        os.close(lock)
        if new:
            with suppress(OSError):  # it holds something
                folder.rmdir()


def mark_failed(folder: Path, status: str, problem: str) -> None:
    """Call `RunFolder.mark_failed` where no run has been started; nothing is made
    where no run was before.
    """
    if read_summary(folder):
        with suppress(ContbedError), occupied(folder) as place:
            place.mark_failed(status, problem)


def read_summary(folder: Path) -> dict[str, Any]:
    """Read summary.json; empty if there is none that can be read."""
    try:
        content = json.loads((folder / SUMMARY).read_text(encoding="utf-8"))
    except (OSError, ValueError, RecursionError):
        return {}
    return content if isinstance(content, dict) else {}


def _listed(summary: Mapping[str, Any]) -> list[str]:
    """Return the files of a run: plain names in its folder."""
    names = summary.get("files")
    return [
        name
        for name in (names if isinstance(names, list) else ())
        if isinstance(name, str) and Path(name).name == name and name not in ("", "..")
    ]


def _lock(folder: Path) -> int:
    """Return the open lock of a folder."""
    path = folder / LOCK
    while True:
        try:
            lock = os.open(path, os.O_RDWR | os.O_CREAT | os.O_NOFOLLOW, 0o666)
        except OSError as error:
            raise ContbedError(
                f"cannot lock {folder}: {path.name}: {error.strerror}; remove it"
            ) from error
        try:
            fcntl.flock(lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError as error:
            holder = os.pread(lock, 200, 0).decode(errors="replace")
            if error.errno not in _NO_LOCKS or _lives(holder):
                os.close(lock)
                who = f" ({holder})" if holder else ""
                raise ContbedError(
                    f"{folder}: another run is writing there{who}; wait for it or give "
                    "another folder"
                ) from None
        with suppress(FileNotFoundError):
            if os.stat(path).st_ino == os.fstat(lock).st_ino:
                break
        os.close(lock)  # the run before has just removed it
    text = f"process {os.getpid()} on {socket.gethostname()}"
    os.ftruncate(lock, 0)
    os.pwrite(lock, text.encode(), 0)
    return lock


def _lives(holder: str) -> bool:
    """Return whether the process named in a lock may still run; for file systems
    without locks.
    """
    found = re.fullmatch(r"process (\d+) on (.*)", holder)
    if found is None:
        return False
    if found[2] != socket.gethostname():
        return True
    try:
        os.kill(int(found[1]), 0)
    except ProcessLookupError:
        return False
    except PermissionError:
        return True
    return int(found[1]) != os.getpid()
