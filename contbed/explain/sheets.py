"""Data sheets by name: closures, models, tables and keys, results, reactions,
materials, terms, commands.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from difflib import get_close_matches

from contbed import closures, fields
from contbed.chemistry.power_law import PowerLaw
from contbed.closures import arguments, registry
from contbed.errors import SceneError
from contbed.explain import catalogue
from contbed.explain.catalogue import (
    kinds,
    laws,
    laws_by_name,
    models,
    ordered,
    own_laws,
    schemas,
    text_of_law,
)
from contbed.explain.closure_keys import closure_keys, kinds_by_model
from contbed.explain.terms import TERMS
from contbed.models import MODELS
from contbed.scene import schema
from contbed.scene.library import MATERIALS
from contbed.scene.library import data_sheet as material_sheet
from contbed.scene.names import first_paragraph
from contbed.scene.toml_lines import KeyPath


def explain(name: str, commands: Mapping[str, str] | None = None) -> str:
    """Return all data sheets of a name.

    Parameters
    ----------
    name : a closure, with or without its kind, a kind of closures, a model, a table or
        key of a scene, whole or its last part, a choice of a key, a named result or
        column, a reaction, a rate law, a material, a term of the field, a command, or a
        word for a group of these: "closures", "rate laws", "materials"
    commands : what each command of the command line does

    Raises
    ------
    SceneError : nothing has the name; the message names the nearest
    """
    sheets = [sheet for source in _SOURCES for sheet in source(name)]
    if name in (commands or {}):
        sheets.append(
            f"contbed {name} - command: {(commands or {})[name]}\n    `contbed {name} "
            "--help` shows its options"
        )
    sheets = sheets or list(_by_pattern(name))
    if sheets:
        return "\n\n".join(sheet.rstrip("\n") for sheet in sheets) + "\n"
    names = [
        *entries(),
        *catalogue.last_parts(catalogue.keys()),
        *catalogue.choices(),
        *catalogue.WORDS,
        *(commands or {}),
    ]
    near = get_close_matches(name, dict.fromkeys(names), n=3, cutoff=0.5)
    hint = f"nearest: {', '.join(near)}" if near else "`contbed list` shows all names"
    raise SceneError(f"nothing is called {name!r}; {hint}")


def entries() -> list[str]:
    """Return the names of everything that `explain` shows."""
    return [
        *models(),
        *closures.names(),
        *kinds(),
        *MATERIALS,
        *laws(),
        *laws_by_name(),
        *arguments.ARGUMENTS,
        *fields.FIELDS,
        *fields.RESULTS,
        *TERMS,
        *catalogue.keys(),
    ]


def listing() -> str:
    """List all names under headings, each on its own line."""
    lines: list[str] = []
    for group in ("models", "closures", "reactions", "materials", "tables"):
        for title, names in catalogue.sections(group).items():
            lines += _section(title, names)
    return "\n".join(lines)


def at(path: KeyPath) -> list[schema.Node]:
    """Return the nodes of a key path in all kinds of scenes; several if a table has
    several types.
    """
    return [node for root in schemas() for node in schema.at(root, path)]


def unit(path: KeyPath) -> str | None:
    """Return the SI unit of a key; None if it has none or is not a number."""
    return next(
        (found for root in schemas() if (found := schema.unit(root, path))), None
    )


def _function_sheets(name: str) -> Iterator[str]:
    """Yield models and closures; a short name may belong to several kinds, that of a
    dispersion stands for a pair.
    """
    if name in models():
        yield models()[name]
    wanted = [f"{kind}{name}" for kind in ("", *(f"{kind}_" for kind in kinds()))]
    wanted += [
        f"{stem}{end}"
        for stem in (name, f"dispersion_{name}")
        for end in ("_axial", "_transverse")
    ]
    yield from (
        closures.data_sheet(match) for match in closures.names() if match in wanted
    )


def _kind_sheets(name: str) -> Iterator[str]:
    if name in kinds():
        unit = registry.sheet(closures.names(name)[0]).unit
        lines = [
            f"closures of kind {name}: {arguments.RESULTS.get(name, name)} [{unit}]"
        ]
        lines += [
            f"    {closure:44} {registry.sheet(closure).summary}"
            for closure in closures.names(name)
        ]
        named = [
            place for place in closure_keys() if name in kinds_by_model(place).values()
        ]
        lines += [f"    named by {', '.join(named)}"] if named else []
        yield "\n".join(lines)


def _key_sheets(name: str) -> Iterator[str]:
    """Yield the tables and keys of that name, each with the kinds of scenes that it
    belongs to.
    """
    for scenes, node in _nodes(name):
        lines = [*schema.sheet(name, node)]
        if len(scenes) < len(MODELS):
            lines.insert(0, f"in scenes of kind {', '.join(scenes)}:")
        if kind := kinds_by_model(name).get(scenes[0]):
            lines.append(
                f"    `contbed explain {kind}` shows the closures, `contbed closures "
                f"--for {kind}` ranks them"
            )
        yield "\n".join(lines)


def _law_sheets(name: str) -> Iterator[str]:
    """Yield the rate laws of a reaction, those that are called so, and those with
    constants of the scene.
    """
    reaction = name.removeprefix("reactions.").removesuffix(".law")
    if of := laws().get(reaction):
        head = (
            f"rate laws of {reaction}, the first is the default"
            if len(of) > 1
            else f"rate law of {reaction}"
        )
        yield "\n".join([head, *(line for law in of for line in _law(of[law]))])
    for reaction, of in laws().items():
        if name in of:
            yield "\n".join([f"{name} - rate law of {reaction}", *_law(of[name])])
    if equations := laws_by_name().get(name):
        head = "\n    ".join([f"{name} - rate law", *equations])
        yield f"{head}\n\n{text_of_law(name)}"
    if needed := own_laws().get(name):
        head = f"{name} - rate law, constants of the scene: [reactions.NAME] needs {', '.join(needed)}"
        yield f"{head}\n\n{text_of_law(name)}"


def _law(law: PowerLaw) -> list[str]:
    low, high = law.T_range
    return [
        f"    {law.name}: {law.reaction} [{law.unit}], {low:g} to {high:g} K",
        f"        {law.source}",
    ]


def _group_sheets(name: str) -> Iterator[str]:
    """Yield what a group of names holds: "materials", "rate laws"."""
    if group := catalogue.group(name):
        yield "\n".join(catalogue.overview(group))


def _part_sheets(name: str) -> Iterator[str]:
    """Yield the keys whose last part has the name, and those that take it as a
    choice.
    """
    whole = [
        key
        for key in catalogue.last_parts(catalogue.keys()).get(name, [])
        if key != name
    ]
    if whole:
        rows = [f"    {key:40} {_meaning(key)}".rstrip() for key in whole]
        yield "\n".join(
            [
                f"{name} - key of tables of a scene; `contbed explain TABLE.{name}` "
                "shows one whole",
                *rows,
            ]
        )
    if takers := catalogue.choices().get(name):
        rows = [f"    {key:40} {_meaning(key)}".rstrip() for key in takers]
        yield "\n".join([f'"{name}" - a choice of', *rows])


def _meaning(key: str) -> str:
    """Return the first line of what a key means, or its table."""
    for node in catalogue.keys()[key]:
        for option in (node, *schema.options(node)):
            if "description" in option:
                return first_paragraph(option["description"])
    return ""


def _result_sheets(name: str) -> Iterator[str]:
    """Yield results and columns; "k_eff" is that of "k_eff [W/m/K]"."""
    for what, table in (
        ("column or field", fields.FIELDS),
        ("named result", fields.RESULTS),
    ):
        for whole in table:
            if name in (whole, whole.partition(" [")[0]):
                yield _quantity(what, whole, table[whole])


def _data_sheets(name: str) -> Iterator[str]:
    """Yield materials, arguments of closures and terms."""
    if name in MATERIALS:
        yield material_sheet(name)
    if (known := arguments.ARGUMENTS.get(name)) is not None:
        takers = [
            closure
            for closure in closures.names()
            if name in registry.sheet(closure).arguments
        ]
        yield f"{name} - argument of {len(takers)} closures, [{known.unit}]: {known.meaning}"
    for term, text in TERMS.items():
        if term.lower() == name.lower():
            yield f"{term} - {text}"


def _by_pattern(name: str) -> Iterator[str]:
    """Yield results whose name has a part that the scene chooses: "heat_left_W" is a
    "heat_NAME_W".
    """
    # without a part of the entry's own it would fit anything
    if "_" not in name and " " not in name:
        return
    candidates = (
        ("column or field", fields.field(name)),
        ("named result", fields.result(name)),
    )
    entries = [(what, entry) for what, entry in candidates if entry is not None]
    if entries:
        what, closest = max(entries, key=lambda found: len(found[1].name))
        yield _quantity(what, name, closest)


def _quantity(what: str, name: str, entry: fields.Field) -> str:
    pattern = "" if entry.name == name else f", an entry {entry.name}"
    unit = "without unit" if entry.unit == "1" else f"[{entry.unit}]"
    return f"{name} - {what}{pattern}, {unit}: {entry.description}"


_SOURCES = (
    _function_sheets,
    _kind_sheets,
    _key_sheets,
    _law_sheets,
    _result_sheets,
    _data_sheets,
    _group_sheets,
    _part_sheets,
)


def _nodes(name: str) -> list[tuple[list[str], schema.Node]]:
    """Return the different schemas of a table or key, each with the kinds of scenes
    that have it.

    Names are such as "heat", "closures.nusselt", "boundary.NAME.gas" or "mesh.line".
    """
    path: KeyPath = tuple(name.split("."))
    found: dict[str, tuple[list[str], schema.Node]] = {}
    for kind, model in ordered():
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
        if any(
            value == path[-1]
            for key in option.get("properties", {}).values()
            for value in schema.choices(key)
        )
    ]


def _section(title: str, entries: Iterable[str]) -> list[str]:
    entries = list(entries)
    return [title, *(f"  {entry}" for entry in entries), ""] if entries else []
