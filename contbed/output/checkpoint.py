"""Checkpoints: arrays and a few plain values in one file that is always either the
old or the new one.
"""

from __future__ import annotations

import hashlib
import json
import time as clock
import zipfile
import zlib
from collections.abc import Callable, Collection, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from contbed.errors import ContbedError, SceneError
from contbed.output.files import atomic

NAME = "checkpoint.npz"
_ARRAY = "array."  # keeps the names of arrays apart from those of the file itself
_TYPES = {np.dtype(kind) for kind in ("f8", "i8", "i4", "u4", "?")}  # of arrays

# what zipfile and numpy raise on bytes that are not as they were written; a zip may
# even seem to be encrypted
_DAMAGE = (
    OSError,
    ValueError,
    TypeError,
    KeyError,
    EOFError,
    RuntimeError,
    MemoryError,
    zipfile.BadZipFile,
    zlib.error,
)


def save(
    folder: Path | str, arrays: Mapping[str, NDArray[Any]], meta: Mapping[str, Any]
) -> None:
    """Write `checkpoint.npz` in a folder; `meta` holds what JSON can hold, numbers
    exactly.

    Raises
    ------
    ContbedError : the file cannot be written; says what became of the previous
        checkpoint
    """
    path = Path(folder) / NAME
    stored = {name: np.asarray(array) for name, array in arrays.items()}
    if any(array.dtype.hasobject for array in stored.values()):
        raise TypeError("a checkpoint holds arrays of numbers, not of objects")
    text = json.dumps(dict(meta), default=_plain)
    entries = {_ARRAY + name: array for name, array in stored.items()}
    entries |= {"meta": np.array(text), "checksum": np.array(_checksum(stored, text))}
    try:
        # np.savez of NumPy 1.24 leaves its file half open where the disk is full
        with atomic(path) as temporary, zipfile.ZipFile(temporary, "w") as file:
            for name, array in entries.items():
                with file.open(f"{name}.npy", "w", force_zip64=True) as entry:
                    np.lib.format.write_array(entry, array, allow_pickle=False)
    except ContbedError as error:
        before = (
            "the previous checkpoint is intact"
            if path.is_file()
            else "there is no earlier checkpoint"
        )
        raise ContbedError(f"{error}; {before}") from error


class Keeper:
    """Writes states of a run at intervals of wall time, and the last one when the block
    ends, however it ends.

    Parameters
    ----------
    folder : takes the checkpoint; None: nothing is written
    label : identity of the scene
    every : wall-clock time between checkpoints [s]
    """

    def __init__(self, folder: Path | None, label: Mapping[str, Any], every: float):
        self.folder, self.label, self.every = folder, label, every
        self._saved = clock.monotonic()
        self._waiting: tuple[dict[str, NDArray[Any]], dict[str, Any]] | None = None

    def offer(
        self, arrays: Mapping[str, NDArray[Any]], meta: Mapping[str, Any] | None = None
    ) -> None:
        """Write a state if it is time, else keep a copy of it."""
        if self.folder is None:
            return
        state = {name: np.array(array) for name, array in arrays.items()}
        self._waiting = state, {"identity": self.label, **(meta or {})}
        if clock.monotonic() - self._saved >= self.every:
            self._write()

    def _write(self) -> None:
        if self.folder is not None and self._waiting is not None:
            save(self.folder, *self._waiting)
        self._waiting, self._saved = None, clock.monotonic()

    def __enter__(self) -> Keeper:
        return self

    def __exit__(self, *error: object) -> None:
        self._write()


class Parts(dict[str, Any]):
    """Arrays or values of the checkpoint `path` by name."""

    def __init__(self, path: Path, parts: Mapping[str, Any]):
        super().__init__(parts)
        self._path = path

    def __missing__(self, name: str) -> Any:
        """Refuse what another version of contbed has not written.

        Raises
        ------
        SceneError : always
        """
        raise SceneError(
            f"{self._path}: it lacks {name!r}, as of another version; run the scene "
            "without --restart"
        )


def load(folder: Path | str) -> tuple[Parts, Parts]:
    """Read the arrays and meta data of the checkpoint in a folder.

    Raises
    ------
    SceneError : there is none, or it is damaged
    """
    require_there(folder)
    path = Path(folder) / NAME
    try:
        # what contbed writes is not packed: no file takes more memory than its size
        with open(path, "rb") as stream, zipfile.ZipFile(stream) as entries:
            if any(entry.compress_type for entry in entries.infolist()):
                raise ValueError(
                    "it is compressed, and contbed does not write such checkpoints"
                )
        with open(path, "rb") as stream, np.load(stream, allow_pickle=False) as file:
            arrays = {
                name.removeprefix(_ARRAY): file[name]
                for name in file.files
                if name.startswith(_ARRAY)
            }
            text, checksum = str(file["meta"]), str(file["checksum"])
        if checksum != _checksum(arrays, text):
            raise ValueError("its checksum is wrong: the file was changed or damaged")
        for name, array in arrays.items():
            if array.dtype not in _TYPES:
                raise ValueError(f"{name} is of type {array.dtype}")
        return Parts(path, arrays), Parts(path, json.loads(text))
    except PermissionError as error:
        raise SceneError(f"cannot read {path}: {error.strerror}") from error
    except _DAMAGE as error:
        reason = " ".join(str(error).split())
        raise SceneError(
            f"{path}: damaged checkpoint ({reason}); run the scene without --restart"
        ) from error


def require_there(folder: Path | str) -> None:
    """Refuse a folder without a checkpoint.

    Raises
    ------
    SceneError : there is none
    """
    if not Path(folder).is_dir():
        raise SceneError(f"{folder}: no such folder to restart from")
    if not (Path(folder) / NAME).is_file():
        raise SceneError(
            f"{folder}: no {NAME} to restart from; run the scene without --restart"
        )


def require_same(
    meta: Mapping[str, Any],
    identity: Mapping[str, Any],
    may_change: Sequence[str] = (),
    at: Callable[[str], str] = lambda key: "scene",
) -> None:
    """Refuse the checkpoint of another scene.

    Parameters
    ----------
    meta : of the checkpoint; `meta["identity"]` is that of the scene that wrote it
    identity : of the scene that resumes, see `contbed.scene.identity`
    may_change : keys of the scene that may differ, tables with all their keys
    at : file and line of a key

    Raises
    ------
    SceneError : with a line for each key that differs and may not
    """
    found = meta.get("identity")
    if not isinstance(found, Mapping):
        raise SceneError(
            "the checkpoint does not name its scene, so that another version "
            "of contbed wrote it; run without --restart"
        )
    if found.get("contbed") != identity["contbed"]:
        versions = f"contbed {found.get('contbed')}, this is {identity['contbed']}"
        raise SceneError(
            f"the checkpoint was written by {versions}; run without --restart"
        )
    problems = []
    was, now = _flat(found.get("values", {})), _flat(identity["values"])
    for key in dict.fromkeys((*now, *was)):
        free = any(key == name or key.startswith(f"{name}.") for name in may_change)
        if not free and was.get(key) != now.get(key):
            problems.append(
                f"{at(key)}: {key} = {_shown(now.get(key))}: the checkpoint has "
                f"{_shown(was.get(key))}"
            )
    was, now = found.get("files", {}), identity["files"]
    problems += [
        f"{name}: another file than that of the checkpoint"
        for name in now
        if was.get(name) != now[name]
    ]
    if problems:
        allowed = f"; only {', '.join(may_change)} may change" if may_change else ""
        raise SceneError(
            [*problems, f"the checkpoint belongs to another scene{allowed}"]
        )


def require_form(
    found: Any, own: Any, free: Collection[str] = (), name: str = ""
) -> None:
    """Refuse values of a checkpoint whose type or shape is not that which the run
    itself has at its start.

    Parameters
    ----------
    found, own : of the checkpoint and of the run: mappings, arrays, numbers
    free : names of arrays whose axes may have other lengths, or that begin empty
    name : of the values in the checkpoint

    Raises
    ------
    SceneError : the checkpoint does not fit
    """
    if isinstance(own, Mapping):
        for key, value in own.items():
            require_form(found[key], value, free, str(key))
    elif own is not None and not _fits(found, own, name in free):
        raise SceneError(
            f"the checkpoint does not fit this scene: {name} is {_form(found)}, "
            f"expected {_form(own)}; run without --restart"
        )


def _fits(found: Any, own: Any, is_free: bool) -> bool:
    if not isinstance(own, float | np.ndarray):
        return type(found) is type(own)
    if isinstance(own, np.ndarray):
        if not isinstance(found, np.ndarray) or found.dtype != own.dtype:
            return False
        may_differ = is_free and (found.ndim == own.ndim or not own.size)
        if found.shape != own.shape and not may_differ:
            return False
    elif type(found) is bool or not isinstance(found, int | float | np.ndarray):
        return False  # integrals begin with 0.0 and may become arrays
    return bool(np.isfinite(found).all() or not np.isfinite(own).all())


def _form(value: Any) -> str:
    if not isinstance(value, np.ndarray):
        return str(value)[:40]
    known = "" if np.isfinite(value).all() else ", not all finite"
    return f"{value.dtype} of shape {value.shape}{known}"


def _flat(values: Any, above: str = "") -> dict[str, Any]:
    """Values by dotted key."""
    if not isinstance(values, Mapping):
        return {above: values}
    found: dict[str, Any] = {}
    for key, value in values.items():
        found |= _flat(value, f"{above}.{key}" if above else str(key))
    return found


def _shown(value: Any) -> str:
    return "absent" if value is None else json.dumps(value)


def _checksum(arrays: Mapping[str, NDArray[Any]], text: str) -> str:
    digest = hashlib.sha256(text.encode())
    for name, array in sorted(arrays.items()):
        digest.update(f"{name} {array.dtype.str} {array.shape} ".encode())
        digest.update(array.tobytes())
    return digest.hexdigest()


def _plain(value: Any) -> Any:
    if isinstance(value, np.generic | np.ndarray):
        return value.tolist()
    raise TypeError(f"a checkpoint cannot hold {type(value).__name__}")
