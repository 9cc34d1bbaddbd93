"""What studies have computed, by key: nothing is computed twice.

A `Store` is a file of JSON lines, for values; a run that has files of its own keeps its
outcome in its folder, see `runs`. Every entry has a checksum. One that does not fit, as
a killed process has written only a part of it, is computed again, and so is what a
former version of contbed kept in another form.
"""

from __future__ import annotations

import fcntl
import hashlib
import json
import os
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Any

from contbed.output.summary import plain

Content = dict[str, Any]
CHECKSUM = "checksum"
KEY = "run"  # of an entry in a line


def key_of(*parts: Any) -> str:
    """Return 16 hexadecimal digits that stand for JSON values, the same for the same
    values.
    """
    return hashlib.sha256(json.dumps(parts, sort_keys=True).encode()).hexdigest()[:16]


def sealed(content: Mapping[str, Any]) -> Content:
    """Return an entry in JSON's own types, with its checksum."""
    entry: Content = plain(content)
    return entry | {CHECKSUM: key_of(entry)}


def opened(text: str) -> Content | None:
    """Return the content of an entry without its checksum; None where it is damaged."""
    try:
        content: Content = json.loads(text)
        checksum = content.pop(CHECKSUM)
        return content if checksum == key_of(content) else None
    except (ValueError, AttributeError, KeyError, TypeError):
        return None


class Store:
    """Entries by key in a file of lines; without a file they are kept in memory only.

    A process that runs at the same time may add lines of its own: each is written whole
    under a lock.

    Attributes
    ----------
    before : number of entries that the file had
    """

    def __init__(self, file: Path | None, retry_failed: bool = False):
        self._file = file
        self._known: dict[str, Content] = {}
        if file is not None and file.is_file():
            for line in file.read_text(encoding="utf-8", errors="replace").splitlines():
                entry = opened(line)
                if entry is not None and not (retry_failed and entry.get("exit_code")):
                    self._known[entry[KEY]] = entry
        self.before = len(self._known)

    def known(self, key: str) -> Content | None:
        """Return an entry; None if there is none."""
        return self._known.get(key)

    def add(self, key: str, content: Mapping[str, Any]) -> Content:
        """Keep an entry and return it as a later process reads it."""
        line = json.dumps(sealed({KEY: key, **content}), allow_nan=False)
        if self._file is not None:
            self._file.parent.mkdir(parents=True, exist_ok=True)
            with open(self._file, "ab") as file, locked(file.fileno()):
                if file.seek(0, os.SEEK_END) and not _ends_with_a_line(self._file):
                    file.write(b"\n")
                file.write(line.encode() + b"\n")
        found = opened(line)
        assert found is not None, "it has just been written with its checksum"
        self._known[key] = found
        return found

    def kept(self, key: str, compute: Callable[[], Mapping[str, Any]]) -> Content:
        """Return an entry, computed and kept if it is not there."""
        return self.known(key) or self.add(key, compute())

    def failed(self) -> list[Content]:
        """Return the entries of runs that failed."""
        return [entry for entry in self._known.values() if entry.get("exit_code")]

    def __len__(self) -> int:
        return len(self._known)


@contextmanager
def locked(descriptor: int) -> Iterator[None]:
    """Hold the lock of an open file or folder for the block; the system releases it
    when the process ends.
    """
    with suppress(OSError):  # a file system without locks
        fcntl.flock(descriptor, fcntl.LOCK_EX)
    try:
        yield
    finally:
        with suppress(OSError):
            fcntl.flock(descriptor, fcntl.LOCK_UN)


def _ends_with_a_line(path: Path) -> bool:
    with open(path, "rb") as file:
        file.seek(-1, os.SEEK_END)
        return file.read(1) == b"\n"
