"""Catalogue of models, closures, tables of a scene and studies, and the data sheet of each by its name."""

from __future__ import annotations

import ast
from collections.abc import Iterable, Iterator
from difflib import get_close_matches
from functools import cache
from pathlib import Path

from contbed import closures
from contbed.closures import registry
from contbed.errors import SceneError
from contbed.models import MODELS
from contbed.scene import schema
from contbed.scene.toml_lines import KeyPath


@cache
def models() -> dict[str, str]:
    """Return the docstrings of all equations by name, read without importing them."""
    files = {name: file for model in MODELS.values() for name, file in model.sheets().items()}
    return {name: ast.get_docstring(ast.parse(files[name].read_text(encoding="utf-8"))) or "" for name in sorted(files)}


def studies(folder: Path) -> dict[str, list[str]]:
    """Return the scenes of each study in a folder."""
    found = {study.name: sorted(scene.name for scene in study.glob("*.toml")) for study in sorted(folder.glob("*/"))}
    return {name: scenes for name, scenes in found.items() if scenes}


def explain(name: str) -> str:
    """Return the data sheet of a closure (with or without its kind), a model, or a table or key of a scene."""
    known = closures.names()
    # A short name may belong to closures of several kinds; that of a dispersion stands for a pair.
    wanted = [f"{kind}{name}" for kind in ("", *(f"{registry.sheet(closure).kind}_" for closure in known))]
    wanted += [f"{stem}{end}" for stem in (name, f"dispersion_{name}") for end in ("_axial", "_transverse")]
    sheets = [models()[name]] if name in models() else []
    sheets += [closures.data_sheet(match) for match in known if match in wanted]
    if lines := [line for node in _nodes(name) for line in schema.sheet(name, node)]:
        sheets.append("\n".join(lines))
    if sheets:
        return "\n\n".join(sheet.rstrip("\n") for sheet in sheets) + "\n"
    names = [*models(), *known, *tables(), *_keys()]
    near = get_close_matches(name, names, n=3, cutoff=0.5)
    hint = f"nearest: {', '.join(near)}" if near else "`contbed list` shows all names"
    raise SceneError(f"no model, closure, table or key is called {name!r}; {hint}")


def listing(folder: Path) -> str:
    """List all names under headings, each on its own line; studies from `folder`."""
    lines = _section("models", (f"{name:28} {text.partition(chr(10))[0]}" for name, text in models().items()))
    for kind in sorted({registry.sheet(name).kind for name in closures.names()}):
        lines += _section(
            f"closures: {kind}", (f"{name:44} {registry.sheet(name).summary}" for name in closures.names(kind))
        )
    lines += _section("tables of a scene", tables())
    lines += _section("studies", (f"{name:28} {', '.join(scenes)}" for name, scenes in studies(folder).items()))
    return "\n".join(lines)


def at(path: KeyPath) -> list[schema.Node]:
    """Return the nodes of a key path in all kinds of scenes; several if a table has several types."""
    return [node for root in _schemas() for node in schema.at(root, path)]


def unit(path: KeyPath) -> str | None:
    """Return the SI unit of a key; None if it has none or is not a number."""
    return next((found for root in _schemas() if (found := schema.unit(root, path))), None)


def tables() -> list[str]:
    """Return the tables of a scene, with their types: "mesh", "heat", "boundary.NAME"."""
    found: list[str] = []
    for name, node in (item for root in _schemas() for item in root["properties"].items()):
        if any(isinstance(option.get("additionalProperties"), dict) for option in schema.options(node)):
            found.append(f"{name}.NAME")
        elif any("properties" in option for option in schema.options(node)):
            found.append(name)
    return list(dict.fromkeys(found))


def _schemas() -> list[schema.Node]:
    """Return the schemas of all kinds of scenes, the packed bed first."""
    return [schema.of(MODELS[kind].scene) for kind in sorted(MODELS, key=lambda kind: kind != "packed_bed")]


def _nodes(name: str) -> Iterator[schema.Node]:
    """Yield the schemas of a table or key in all kinds of scenes, each different one once.

    Names are such as "heat", "heat.nusselt", "boundary.NAME.fluid" or "mesh.line".
    """
    path: KeyPath = tuple(name.split("."))
    nodes = at(path)
    if not nodes and len(path) > 1:  # mesh.line: one type of a table
        nodes = [
            option
            for node in at(path[:-1])
            for option in schema.options(node)
            if any(value == path[-1] for key in option.get("properties", {}).values() for value in schema.choices(key))
        ]
    shown: list[str] = []
    for node in nodes:
        text = "\n".join(schema.sheet(name, node))
        if text not in shown:
            shown.append(text)
            yield node


def _section(title: str, entries: Iterable[str]) -> list[str]:
    entries = list(entries)
    return [title, *(f"  {entry}" for entry in entries), ""] if entries else []


def _keys() -> list[str]:
    found = []
    for table in tables():
        for node in at(tuple(table.split("."))):
            found += [f"{table}.{key}" for key in schema.keys(node)]
    return found
