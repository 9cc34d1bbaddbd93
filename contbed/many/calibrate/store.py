"""Runs of a calibration by the hash of their scene, one line each in `runs.jsonl`: none is computed twice.

A line has a checksum. What a killed process has written of its last line does not fit it and is computed again.
"""

from __future__ import annotations

import hashlib
import json
import os
from pathlib import Path
from typing import Any

from contbed.many.sweep.runs import locked
from contbed.output.summary import plain

FILE = "runs.jsonl"

Outcome = dict[str, Any]


class Store:
    """The runs in a folder; without a folder they are kept in memory only.

    A process that runs at the same time may add lines of its own, each is written whole under a lock.
    """

    def __init__(self, folder: Path | None, retry_failed: bool = False):
        self._file = folder / FILE if folder is not None else None
        self._known: dict[str, Outcome] = {}
        if self._file is not None and self._file.is_file():
            for line in self._file.read_text(encoding="utf-8", errors="replace").splitlines():
                if (entry := _entry(line)) is not None and not (retry_failed and entry["exit_code"]):
                    self._known[entry["run"]] = entry
        self.before = len(self._known)

    def known(self, run: str) -> Outcome | None:
        """Return the outcome of a run; None if there is none."""
        return self._known.get(run)

    def add(self, run: str, outcome: Outcome) -> Outcome:
        """Keep the outcome of a run and return it as a later process reads it."""
        entry = plain({"run": run, **outcome})
        line = json.dumps(entry | {"checksum": _checksum(entry)}, allow_nan=False)
        if self._file is not None:
            with open(self._file, "ab") as file, locked(file.fileno()):
                if file.seek(0, os.SEEK_END) and not _ends_with_a_line(self._file):
                    file.write(b"\n")
                file.write(line.encode() + b"\n")
        found = _entry(line)
        assert found is not None, "it has just been written with its checksum"
        self._known[run] = found
        return found

    def failed(self) -> list[Outcome]:
        """Return the runs that failed."""
        return [entry for entry in self._known.values() if entry["exit_code"]]

    def __len__(self) -> int:
        return len(self._known)


def _ends_with_a_line(path: Path) -> bool:
    with open(path, "rb") as file:
        file.seek(-1, os.SEEK_END)
        return file.read(1) == b"\n"


def _entry(line: str) -> Outcome | None:
    try:
        entry = json.loads(line)
        content = {key: value for key, value in entry.items() if key != "checksum"}
        return entry if entry["checksum"] == _checksum(content) and "exit_code" in entry else None
    except (ValueError, AttributeError, KeyError, TypeError):
        return None


def _checksum(content: Outcome) -> str:
    return hashlib.sha256(json.dumps(content, sort_keys=True).encode()).hexdigest()[:16]
