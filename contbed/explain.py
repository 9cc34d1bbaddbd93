"""What there is: models, closures, the tables of a scene, studies; and the data sheet of each by its name."""

from __future__ import annotations

import ast
from collections.abc import Iterable
from difflib import get_close_matches
from pathlib import Path

from contbed import closures
from contbed.closures import registry
from contbed.errors import SceneError
from contbed.scene import schema as reference


def models() -> dict[str, str]:
    """The docstrings of the models, read without importing them."""
    folder = Path(__file__).parent / "models"
    files = sorted(file for file in folder.glob("*.py") if not file.name.startswith("_"))
    return {file.stem: ast.get_docstring(ast.parse(file.read_text(encoding="utf-8"))) or "" for file in files}


def studies(folder: Path) -> dict[str, list[str]]:
    """The scenes of each study in a folder."""
    found = {study.name: sorted(scene.name for scene in study.glob("*.toml")) for study in sorted(folder.glob("*/"))}
    return {name: scenes for name, scenes in found.items() if scenes}


def explain(name: str) -> str:
    """The data sheet of a closure, with or without its kind; of a model; of a table or key of a scene."""
    if name in models():
        return models()[name]
    known = closures.names()
    # A short name may belong to closures of several kinds; that of a dispersion stands for a pair.
    wanted = [f"{kind}{name}" for kind in ("", *(f"{registry.sheet(closure).kind}_" for closure in known))]
    wanted += [f"{stem}{end}" for stem in (name, f"dispersion_{name}") for end in ("_axial", "_transverse")]
    if matches := [closure for closure in known if closure in wanted]:
        return "\n".join(closures.data_sheet(match) for match in matches)
    try:
        return reference.explain(name)
    except SceneError:
        pass
    names = [*models(), *known, *reference.tables(), *_keys()]
    near = get_close_matches(name, names, n=3, cutoff=0.5)
    hint = f"nearest: {', '.join(near)}" if near else "`contbed list` shows all names"
    raise SceneError(f"no model, closure, table or key is called {name!r}; {hint}")


def listing(folder: Path) -> str:
    """All names under headings, each on its own line; studies from `folder`."""
    lines = _section("models", (f"{name:28} {text.partition(chr(10))[0]}" for name, text in models().items()))
    for kind in sorted({registry.sheet(name).kind for name in closures.names()}):
        lines += _section(
            f"closures: {kind}", (f"{name:44} {registry.sheet(name).summary}" for name in closures.names(kind))
        )
    lines += _section("tables of a scene", reference.tables())
    lines += _section("studies", (f"{name:28} {', '.join(scenes)}" for name, scenes in studies(folder).items()))
    return "\n".join(lines)


def _section(title: str, entries: Iterable[str]) -> list[str]:
    entries = list(entries)
    return [title, *(f"  {entry}" for entry in entries), ""] if entries else []


def _keys() -> list[str]:
    found = []
    for table in reference.tables():
        for node in reference.at(tuple(table.split("."))):
            found += [f"{table}.{key}" for key in reference.keys(node)]
    return found
