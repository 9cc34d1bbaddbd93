"""What a report shows of the folder of a run: its summary, its tables and its
fields.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from contbed.arrays import Array
from contbed.errors import ContbedError
from contbed.models import MODELS, kind_of
from contbed.output.folder import SUMMARY
from contbed.output.shapes import RunSummary, read_json
from contbed.output.stored import read_series
from contbed.output.tables import read_table
from contbed.scene import schema
from contbed.scene.toml_lines import KeyPath, dotted

AGAIN = "run the scene again"


@dataclass(frozen=True)
class Key:
    """One key of a scene: its value in SI, the unit, and whether it is the default."""

    name: str
    value: Any
    unit: str
    default: bool


@dataclass(frozen=True)
class Snapshot:
    """Where the fields of one time are stored; the time [s] is None in a steady run."""

    time: float | None
    file: Path


@dataclass(frozen=True)
class Run:
    """One run: its name in the report, the content of summary.json, its tables by
    name, the files of its fields.
    """

    name: str
    folder: Path
    summary: dict[str, Any]
    tables: dict[str, dict[str, Array]]
    snapshots: tuple[Snapshot, ...]

    @property
    def title(self) -> str:
        """Title of the scene, or the name of the folder."""
        return str(self.summary.get("scene", {}).get("title") or self.name)

    def scene_keys(self) -> list[Key]:
        """Return the keys of the scene in their order, each with its unit and
        whether it is as by default.
        """
        scene = {
            key: value
            for key, value in self.summary.get("scene", {}).items()
            if key != "title"
        }
        kind = kind_of(scene) if scene else "packed_bed"
        return list(_keys(schema.of(MODELS[kind].scene), scene, ()))


def read_run(folder: Path, name: str) -> Run:
    """Read the folder of a run.

    Raises
    ------
    ContbedError : there is no run in it, it has not ended, or a file of it is damaged
    """
    if not (folder / SUMMARY).is_file():
        raise ContbedError(
            f"{folder}: no summary.json of a run; give the folder of `contbed run "
            "--out`"
        )
    summary = read_json(folder / SUMMARY, RunSummary, "the summary of a run", AGAIN)
    if summary["status"] == "running":
        raise ContbedError(
            f"{folder}: the run has not ended; wait for it, or run the scene again if "
            "it was stopped"
        )
    tables = {}
    for file in sorted(
        folder.glob("*.csv"), key=lambda file: (file.stem != "profiles", file.stem)
    ):
        if file.name in summary.get("files", [file.name]):
            tables[file.stem] = read_table(file)
    return Run(name, folder, summary, tables, tuple(_snapshots(folder)))


def _keys(root: schema.Node, values: Any, path: KeyPath) -> list[Key]:
    found: list[Key] = []
    for name, value in values.items():
        here = (*path, name)
        if isinstance(value, dict):
            found += _keys(root, value, here)
            continue
        if value and isinstance(value, list) and isinstance(value[0], dict):
            for k, each in enumerate(value):
                found += _keys(root, each, (*here, k))
            continue
        nodes = schema.at(root, here)
        defaults = [node["default"] for node in nodes if "default" in node]
        unit = schema.unit(root, here)
        found.append(
            Key(
                dotted(here),
                value,
                "" if unit in (None, "1") else str(unit),
                value in defaults,
            )
        )
    return found


def _snapshots(folder: Path) -> list[Snapshot]:
    """Return the files of the fields in order of time."""
    series = sorted(folder.glob("*.pvd"))
    if series:
        return [
            Snapshot(time, file)
            for time, file in read_series(series[0])
            if file.suffix == ".vtu"
        ]
    return [Snapshot(None, file) for file in sorted(folder.glob("*.vtu"))]
