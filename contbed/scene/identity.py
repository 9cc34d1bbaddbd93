"""What a scene is to the files of its run: its values, and a hash of all that a run depends on."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Mapping
from typing import Any

from contbed.scene.quantities import Table
from contbed.scene.tables import SceneBase


def resolved(scene: SceneBase) -> dict[str, Any]:
    """All values in SI, defaults included, as plain JSON data. What is absent is left out."""
    return scene.model_dump(mode="json", exclude_none=True)


def scene_hash(scene: SceneBase) -> str:
    """A hash of what a run depends on: the values and the content of the files they name, not the title."""
    values = {key: value for key, value in resolved(scene).items() if key != "title"}
    digest = hashlib.sha256(json.dumps(values, sort_keys=True).encode())
    for file in _files(scene):
        digest.update((scene.origin.base / file).read_bytes())
    return digest.hexdigest()[:16]


def _files(part: Any) -> Iterator[str]:
    """The files that the tables of a scene name: a mesh, closures, particles."""
    if isinstance(part, Mapping):
        for item in part.values():
            yield from _files(item)
    elif isinstance(part, Table):
        if isinstance(file := getattr(part, "file", None), str):
            yield file
        for name in type(part).model_fields:
            yield from _files(getattr(part, name))
