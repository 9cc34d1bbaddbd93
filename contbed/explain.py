"""Catalogue of models, closures, tables of a scene and studies, and the data sheet of each by its name."""

from __future__ import annotations

import ast
from collections.abc import Iterable, Iterator
from difflib import get_close_matches
from functools import cache
from pathlib import Path

from contbed import closures, fields
from contbed.closures import arguments, registry
from contbed.closures.reactions import LAWS, Law
from contbed.closures.reactions_solid import CHAR_LAWS
from contbed.errors import SceneError
from contbed.models import MODELS, Model
from contbed.places import places
from contbed.scene import schema
from contbed.scene.library import MATERIALS
from contbed.scene.library import data_sheet as material_sheet
from contbed.scene.toml_lines import KeyPath
from contbed.terms import TERMS

MAX_FOUND = 20  # entries that a search shows


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
    """Return all data sheets of a name.

    It may be a closure, with or without its kind, a kind of closures, a model, a table or key of a scene, a named
    result or column, a reaction with its rate laws, a material, or a term of the field.
    """
    sheets = [sheet for source in _SOURCES for sheet in source(name)] or list(_by_pattern(name))
    if sheets:
        return "\n\n".join(sheet.rstrip("\n") for sheet in sheets) + "\n"
    near = get_close_matches(name, entries(), n=3, cutoff=0.5)
    hint = f"nearest: {', '.join(near)}" if near else f"`contbed explain --search {name}` looks into all texts"
    raise SceneError(f"no model, closure, table, key, result or term is called {name!r}; {hint}")


def entries() -> dict[str, str]:
    """Return the title of everything that `explain` shows, by name."""
    found = {name: text.partition("\n")[0] for name, text in models().items()}
    found |= {name: registry.sheet(name).summary for name in closures.names()}
    found |= {kind: f"closures: {arguments.RESULTS.get(kind, kind)}" for kind in _kinds()}
    found |= {name: entry.meaning for name, entry in MATERIALS.items()}
    found |= {name: f"rate laws: {', '.join(table)}" for name, table in _laws().items()}
    found |= {name: f"rate law: {equations[0]}" for name, equations in laws_by_name().items()}
    found |= {name: entry.meaning for name, entry in arguments.ARGUMENTS.items()}
    found |= {name: entry.description for name, entry in {**fields.FIELDS, **fields.RESULTS}.items()}
    found |= {name: text.partition(". ")[0] for name, text in TERMS.items()}
    for table in tables():
        for node in at(tuple(table.split("."))):
            for option in schema.options(node):
                found.setdefault(table, str(option.get("description", "")).partition("\n")[0])
                for key, child in option.get("properties", {}).items():
                    found.setdefault(f"{table}.{key}", str(child.get("description", "")))
    return found


def search(words: str) -> str:
    """Return the names whose data sheets have the words, the best first, with their titles, as lines."""
    wanted = [word.lower().removesuffix("s") for word in words.split()]
    rows = []
    for name, title in entries().items():
        texts = (name.lower().replace("_", " ") + " " + name.lower(), title.lower(), _text(name).lower())
        score = [max(w for w, text in zip((9, 4, 1), texts, strict=True) if word in text) for word in wanted
                 if any(word in text for text in texts)]  # fmt: skip
        if len(score) == len(wanted) and wanted:
            rows.append((-sum(score), name, title))
    lines = [f"{name:40} {title}".rstrip() for _, name, title in sorted(rows)[:MAX_FOUND]]
    if not lines:
        raise SceneError(f"nothing has the words {words!r}; `contbed list` shows all names")
    more = len(rows) - len(lines)
    return "\n".join([*lines, *([f"and {more} more; more words find fewer"] if more > 0 else [])])


def listing(folder: Path) -> str:
    """List all names under headings, each on its own line; studies from `folder`."""
    lines = _section("models", (f"{name:28} {text.partition(chr(10))[0]}" for name, text in models().items()))
    for kind in _kinds():
        lines += _section(
            f"closures: {kind}", (f"{name:44} {registry.sheet(name).summary}" for name in closures.names(kind))
        )
    lines += _section(
        "reactions and their rate laws", (f"{name:28} {', '.join(laws)}" for name, laws in _laws().items())
    )
    lines += _section("rate laws of reacting beds", (f"{name:28} {law[0]}" for name, law in laws_by_name().items()))
    lines += _section("materials", (f"{name:28} {entry.meaning}" for name, entry in MATERIALS.items()))
    for kind, model in _ordered():
        root = schema.of(model.scene)
        about = str(root.get("description", "")).partition("\n")[0]
        lines += _section(f"tables of a {kind} scene: {about}", _tables(root))
    lines += _section("studies", (f"{name:28} {', '.join(scenes)}" for name, scenes in studies(folder).items()))
    return "\n".join(lines)


def at(path: KeyPath) -> list[schema.Node]:
    """Return the nodes of a key path in all kinds of scenes; several if a table has several types."""
    return [node for root in _schemas() for node in schema.at(root, path)]


def unit(path: KeyPath) -> str | None:
    """Return the SI unit of a key; None if it has none or is not a number."""
    return next((found for root in _schemas() if (found := schema.unit(root, path))), None)


def tables() -> list[str]:
    """Return the tables of all scenes, with their types: "mesh", "heat", "boundary.NAME"."""
    return list(dict.fromkeys(name for root in _schemas() for name in _tables(root)))


def _tables(root: schema.Node) -> list[str]:
    """Return the tables of one kind of scene."""
    found: list[str] = []
    for name, node in root["properties"].items():
        if any(isinstance(option.get("additionalProperties"), dict) for option in schema.options(node)):
            found.append(f"{name}.NAME")
        elif any("properties" in option for option in schema.options(node)):
            found.append(name)
    return found


def _ordered() -> list[tuple[str, Model]]:
    """Return all kinds of scenes, the packed bed first."""
    return [(kind, MODELS[kind]) for kind in sorted(MODELS, key=lambda kind: kind != "packed_bed")]


def _schemas() -> list[schema.Node]:
    """Return the schemas of all kinds of scenes."""
    return [schema.of(model.scene) for _, model in _ordered()]


def _kinds() -> list[str]:
    """Return the kinds of closures."""
    return sorted({registry.sheet(name).kind for name in closures.names()})


def _laws() -> dict[str, dict[str, Law]]:
    """Return the rate laws of each reaction of a bubbling bed, the default first."""
    return {**LAWS, **CHAR_LAWS}


def _model_sheets(name: str) -> Iterator[str]:
    if name in models():
        yield models()[name]


def _closure_sheets(name: str) -> Iterator[str]:
    """Yield closures; a short name may belong to several kinds, that of a dispersion stands for a pair."""
    wanted = [f"{kind}{name}" for kind in ("", *(f"{kind}_" for kind in _kinds()))]
    wanted += [f"{stem}{end}" for stem in (name, f"dispersion_{name}") for end in ("_axial", "_transverse")]
    yield from (closures.data_sheet(match) for match in closures.names() if match in wanted)


def _kind_sheets(name: str) -> Iterator[str]:
    if name in _kinds():
        unit = registry.sheet(closures.names(name)[0]).unit
        lines = [f"closures of kind {name}: {arguments.RESULTS.get(name, name)} [{unit}]"]
        lines += [f"    {closure:44} {registry.sheet(closure).summary}" for closure in closures.names(name)]
        named = [place for place, kind in places().items() if kind == name]
        lines += [f"    named by {', '.join(named)}"] if named else []
        yield "\n".join(lines)


def _key_sheets(name: str) -> Iterator[str]:
    """Yield the tables and keys of that name, each with the kinds of scenes that it belongs to."""
    for kinds, node in _nodes(name):
        lines = [*schema.sheet(name, node)]
        if len(kinds) < len(MODELS):
            lines.insert(0, f"in scenes of kind {', '.join(kinds)}:")
        if kind := places().get(name):
            lines.append(f"    `contbed explain {kind}` shows the closures, `contbed closures --for {name}` ranks them")
        yield "\n".join(lines)


def _law_sheets(name: str) -> Iterator[str]:
    if laws := _laws().get(name.removeprefix("reactions.").removesuffix(".law")):
        lines = [f"rate laws of {name.removeprefix('reactions.').removesuffix('.law')}, the first is the default"]
        for law, facts in laws.items():
            low, high = facts.T_range
            lines.append(f"    {law}: {facts.reaction} [{facts.unit}], {low:g} to {high:g} K")
            lines.append(f"        {facts.source}")
        yield "\n".join(lines)


def laws_by_name() -> dict[str, tuple[str, ...]]:
    """Return the equations of the rate laws that a reacting bed names, `[reactions.NAME] law`."""
    from contbed.reacting_bed.laws import LAWS_WITH_EQUATION

    found = {name: (text,) if isinstance(text, str) else text for name, text in LAWS_WITH_EQUATION.items()}
    return {name: equations for name, equations in found.items() if "." not in name}


def _named_law_sheets(name: str) -> Iterator[str]:
    if equations := laws_by_name().get(name):
        yield "\n".join([f"{name} - rate law of a reacting bed", *(f"    {equation}" for equation in equations)])


def _result_sheets(name: str) -> Iterator[str]:
    for what, table in (("column or field", fields.FIELDS), ("named result", fields.RESULTS)):
        if name in table:
            yield _quantity(what, name, table[name])


def _argument_sheets(name: str) -> Iterator[str]:
    if (known := arguments.ARGUMENTS.get(name)) is not None:
        takers = [closure for closure in closures.names() if name in registry.sheet(closure).arguments]
        yield f"{name} - argument of {len(takers)} closures, [{known.unit}]: {known.meaning}"


def _by_pattern(name: str) -> Iterator[str]:
    """Yield results whose name has a part that the scene chooses: "heat_left_W" is a "heat_NAME_W"."""
    for what, found in (("column or field", fields.field(name)), ("named result", fields.result(name))):
        # a name without a part of the entry's own, such as T_NAME's, would fit anything
        if found is not None and ("_" in name or " " in name):
            yield _quantity(what, name, found)


def _quantity(what: str, name: str, entry: fields.Field) -> str:
    pattern = "" if entry.name == name else f", an entry {entry.name}"
    unit = "without unit" if entry.unit == "1" else f"[{entry.unit}]"
    return f"{name} - {what}{pattern}, {unit}: {entry.description}"


def _material_sheets(name: str) -> Iterator[str]:
    if name in MATERIALS:
        yield material_sheet(name)


def _term_sheets(name: str) -> Iterator[str]:
    for term, text in TERMS.items():
        if term.lower() == name.lower():
            yield f"{term} - {text}"


_SOURCES = (
    _model_sheets,
    _closure_sheets,
    _kind_sheets,
    _key_sheets,
    _law_sheets,
    _named_law_sheets,
    _material_sheets,
    _result_sheets,
    _argument_sheets,
    _term_sheets,
)


@cache
def _text(name: str) -> str:
    """Return the whole text of an entry, for a search."""
    return "\n".join(sheet for source in _SOURCES if source is not _kind_sheets for sheet in source(name))


def _nodes(name: str) -> list[tuple[list[str], schema.Node]]:
    """Return the different schemas of a table or key, each with the kinds of scenes that have it.

    Names are such as "heat", "heat.nusselt", "boundary.NAME.fluid" or "mesh.line".
    """
    path: KeyPath = tuple(name.split("."))
    found: dict[str, tuple[list[str], schema.Node]] = {}
    for kind, model in _ordered():
        for node in _of_kind(schema.of(model.scene), path):
            kinds, _ = found.setdefault("\n".join(schema.sheet(name, node)), ([], node))
            kinds.append(kind)
    return list(found.values())


def _of_kind(root: schema.Node, path: KeyPath) -> list[schema.Node]:
    """Return the nodes of a key path, or those of one type of a table: mesh.line."""
    nodes = schema.at(root, path)
    if nodes or len(path) == 1:
        return nodes
    return [
        option
        for node in schema.at(root, path[:-1])
        for option in schema.options(node)
        if any(value == path[-1] for key in option.get("properties", {}).values() for value in schema.choices(key))
    ]


def _section(title: str, entries: Iterable[str]) -> list[str]:
    entries = list(entries)
    return [title, *(f"  {entry}" for entry in entries), ""] if entries else []
