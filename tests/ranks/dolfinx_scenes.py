"""Small scenes that together use every form and every model that both engines have."""

import tomllib
from pathlib import Path
from typing import Any

MESHES = Path(__file__).parents[2] / "meshes"


def _scenes() -> dict[str, dict[str, Any]]:
    """Return the scenes of the file: the tables of each take the place of its base's."""
    text = Path(__file__).with_suffix(".toml").read_text(encoding="utf-8")
    tables, scenes = tomllib.loads(text), {}
    for base in ("bed", "medium"):
        for name, own in tables[f"of_{base}"].items():
            scene = tables[base] | own
            if "file" in scene["mesh"]:
                scene["mesh"]["file"] = str(MESHES / scene["mesh"]["file"])
            scenes[name] = {key: table for key, table in scene.items() if table != []}
    return scenes


SCENES = _scenes()
