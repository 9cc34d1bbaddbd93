"""Checkpoints: arrays and a few plain values in one file that is always either the old or the new one."""

from __future__ import annotations

import hashlib
import json
import zipfile
import zlib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from contbed.errors import ContbedError, SceneError
from contbed.output.files import atomic

NAME = "checkpoint.npz"
_ARRAY = "array."  # keeps the names of arrays apart from those of the file itself

# what zipfile and numpy raise on bytes that are not as they were written; a zip may even seem to be encrypted
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


def save(folder: Path | str, arrays: Mapping[str, NDArray], meta: Mapping[str, Any]) -> None:
    """Write `checkpoint.npz` in a folder; `meta` holds what JSON can hold, numbers exactly.

    Raises
    ------
    ContbedError : the file cannot be written; says what became of the previous checkpoint
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
        before = "the previous checkpoint is intact" if path.is_file() else "there is no earlier checkpoint"
        raise ContbedError(f"{error}; {before}") from error


def load(folder: Path | str) -> tuple[dict[str, NDArray], dict[str, Any]]:
    """Arrays and meta data of the checkpoint in a folder.

    Raises
    ------
    SceneError : there is none, or it is damaged
    """
    require_there(folder)
    path = Path(folder) / NAME
    try:
        with open(path, "rb") as stream, np.load(stream, allow_pickle=False) as file:
            arrays = {name.removeprefix(_ARRAY): file[name] for name in file.files if name.startswith(_ARRAY)}
            text, checksum = str(file["meta"]), str(file["checksum"])
        if checksum != _checksum(arrays, text):
            raise ValueError("its checksum differs from its content")
        return arrays, json.loads(text)
    except PermissionError as error:
        raise SceneError(f"cannot read {path}: {error.strerror}") from error
    except _DAMAGE as error:
        reason = " ".join(str(error).split())
        raise SceneError(f"{path}: damaged checkpoint ({reason}); run the scene without --restart") from error


def require_there(folder: Path | str) -> None:
    """Refuse a folder without a checkpoint.

    Raises
    ------
    SceneError : there is none
    """
    if not Path(folder).is_dir():
        raise SceneError(f"{folder}: no such folder to restart from")
    if not (Path(folder) / NAME).is_file():
        raise SceneError(f"{folder}: no {NAME} to restart from; run the scene without --restart")


def require_same(meta: Mapping[str, Any], scene_hash: str) -> None:
    """Refuse the checkpoint of another scene.

    Raises
    ------
    SceneError : `meta["scene_hash"]` is not `scene_hash`
    """
    found = meta.get("scene_hash")
    if found != scene_hash:
        detail = f"scene hash {str(found)[:12]}, expected {scene_hash[:12]}"
        raise SceneError(f"the checkpoint belongs to another scene ({detail}); restart with the scene that wrote it")


def _checksum(arrays: Mapping[str, NDArray], text: str) -> str:
    digest = hashlib.sha256(text.encode())
    for name, array in sorted(arrays.items()):
        digest.update(f"{name} {array.dtype.str} {array.shape} ".encode())
        digest.update(array.tobytes())
    return digest.hexdigest()


def _plain(value: Any) -> Any:
    if isinstance(value, np.generic | np.ndarray):
        return value.tolist()
    raise TypeError(f"a checkpoint cannot hold {type(value).__name__}")
