"""Identity of a scene in the files of its run: its values, and all that a run
depends on.
"""

from __future__ import annotations

import hashlib
import json
from functools import lru_cache
from pathlib import Path
from typing import Any

from contbed import __version__
from contbed.scene.inputs import all_inputs
from contbed.scene.stamp import Stamp, stamp_of
from contbed.scene.tables import SceneBase


def resolved(scene: SceneBase) -> dict[str, Any]:
    """Return all values in SI, defaults included, as plain JSON data; absent values
    are left out.
    """
    return scene.model_dump(mode="json", exclude_none=True)


def identity(scene: SceneBase) -> dict[str, Any]:
    """Return all that a run depends on: the values but the title, a hash of each
    input file, contbed's version.
    """
    values = {key: value for key, value in resolved(scene).items() if key != "title"}
    base = scene.origin.base
    files = {}
    for path in all_inputs(scene, base):
        name = str(path.relative_to(base)) if path.is_relative_to(base) else path.name
        files[name] = _digest(path, stamp_of(path))
    return {"values": values, "files": files, "contbed": __version__}


def scene_hash(scene: SceneBase) -> str:
    """Return a hash of `identity`."""
    return hashlib.sha256(
        json.dumps(identity(scene), sort_keys=True).encode()
    ).hexdigest()[:16]


@lru_cache(maxsize=256)
def _digest(path: Path, stamp: Stamp) -> str:
    """Return a hash of the content of a file, which is read again only when it has
    changed.
    """
    with open(path, "rb") as file:
        return hashlib.file_digest(file, "sha256").hexdigest()[:16]
