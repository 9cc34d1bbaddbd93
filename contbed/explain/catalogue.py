"""All that has a name: models, kinds of closures, rate laws, materials, tables, keys
of scenes and their choices.
"""

from __future__ import annotations

import ast
import inspect
import sys
from collections.abc import Iterable, Mapping
from functools import cache

from contbed import closures, fields
from contbed.chemistry.char_and_lime import (
    CALCINATION,
    CHAR_LAWS,
    SULPHATE_REDUCTION,
    SULPHATION,
)
from contbed.chemistry.laws import every
from contbed.chemistry.laws.gases import BY_REACTION
from contbed.chemistry.power_law import PowerLaw
from contbed.closures import arguments, registry
from contbed.explain.terms import TERMS
from contbed.models import MODELS, Model
from contbed.scene import schema
from contbed.scene.library import MATERIALS
from contbed.scene.names import first_paragraph

# words for the groups of names, without the plural's s
WORDS = {
    "model": "models", "equation": "models", "physic": "models",
    "closure": "closures", "kind": "closures", "correlation": "closures",
    "reaction": "reactions", "rate law": "reactions", "law": "reactions", "kinetic": "reactions",
    "material": "materials", "library": "materials",
    "table": "tables", "scene": "tables",
    "result": "results", "qoi": "results",
    "term": "terms", "glossary": "terms",
}  # fmt: skip


@cache
def models() -> dict[str, str]:
    """Return the docstrings of all equations by name, read without importing them."""
    files = {
        name: file for model in MODELS.values() for name, file in model.sheets().items()
    }
    return {
        name: ast.get_docstring(ast.parse(files[name].read_text(encoding="utf-8")))
        or ""
        for name in sorted(files)
    }


def ordered() -> list[tuple[str, Model]]:
    """Return all kinds of scenes, the packed bed first."""
    return [
        (kind, MODELS[kind])
        for kind in sorted(MODELS, key=lambda kind: kind != "packed_bed")
    ]


def schemas() -> list[schema.Node]:
    """Return the schemas of all kinds of scenes."""
    return [schema.of(model.scene) for _, model in ordered()]


def tables() -> list[str]:
    """Return the tables of all scenes, with their types: "mesh", "heat",
    "boundary.NAME".
    """
    return list(dict.fromkeys(name for root in schemas() for name in tables_of(root)))


def tables_of(root: schema.Node) -> list[str]:
    """Return the tables of one kind of scene."""
    found: list[str] = []
    for name, node in root["properties"].items():
        if any(
            isinstance(option.get("additionalProperties"), dict)
            for option in schema.options(node)
        ):
            found.append(f"{name}.NAME")
        elif any("properties" in option for option in schema.options(node)):
            found.append(name)
    return found


@cache
def keys() -> dict[str, tuple[schema.Node, ...]]:
    """Return the tables and keys of all scenes by their whole names, each as it is
    in the kinds of scenes.
    """
    found: dict[str, list[schema.Node]] = {}
    for root in schemas():
        for path, node in schema.below(root):
            nodes = found.setdefault(".".join(path), [])
            if node not in nodes:
                nodes.append(node)
    return {name: tuple(nodes) for name, nodes in found.items()}


@cache
def choices() -> dict[str, list[str]]:
    """Return the keys that take a text as one of their choices, by this text:
    "no_slip" boundary.NAME.type.
    """
    found: dict[str, list[str]] = {}
    for name, nodes in keys().items():
        for value in dict.fromkeys(
            value for node in nodes for value in schema.choices(node)
        ):
            if isinstance(value, str):
                found.setdefault(value, []).append(name)
    return found


def kinds() -> list[str]:
    """Return the kinds of closures."""
    return sorted({registry.sheet(name).kind for name in closures.names()})


def laws() -> dict[str, dict[str, PowerLaw]]:
    """Return the rate laws with published constants of each reaction, the default
    first.
    """
    lime = {
        "calcination": CALCINATION,
        "sulphation": SULPHATION,
        "sulphate_reduction": SULPHATE_REDUCTION,
    }
    return {
        **BY_REACTION,
        **CHAR_LAWS,
        **{name: {law.name: law} for name, law in lime.items()},
    }


def laws_by_name() -> dict[str, tuple[str, ...]]:
    """Return the equations of the rate laws that any reaction may name."""
    return {
        name: law.equations
        for name, law in every().items()
        if law.equations and "." not in name
    }


def text_of_law(name: str) -> str:
    """Return what the module of a rate law says of it: equations and source."""
    rate = every()[name].rate
    home = getattr(rate, "func", rate).__module__
    return inspect.cleandoc(sys.modules[home].__doc__ or "")


def own_laws() -> dict[str, tuple[str, ...]]:
    """Return the rate laws whose constants the scene gives, with the keys that each
    needs.
    """
    return {name: law.needs for name, law in every().items() if law.needs}


def group(word: str) -> str | None:
    """Return the group of names that a word asks for: "rate laws" reactions; None if
    it is no such word.
    """
    plain = word.lower().replace("_", " ").strip()
    return WORDS.get(plain.removesuffix("s"))


def sections(name: str) -> dict[str, list[str]]:
    """Return the lines of a group of `WORDS` under their headings."""
    if name == "closures":
        return {
            f"closures: {kind}": [
                f"{one:44} {registry.sheet(one).summary}"
                for one in closures.names(kind)
            ]
            for kind in kinds()
        }
    if name == "tables":
        return {
            f"tables of a {kind} scene: "
            f"{first_paragraph(schema.of(model.scene).get('description'))}": tables_of(
                schema.of(model.scene)
            )
            for kind, model in ordered()
        }
    if name == "reactions":
        return {
            "reactions and their rate laws": _lines(
                {key: ", ".join(found) for key, found in laws().items()}
            ),
            "rate laws of any reaction": _lines(
                {key: equations[0] for key, equations in laws_by_name().items()}
            ),
            "rate laws with constants of the scene": _lines(
                {
                    key: f"needs {', '.join(needed)}"
                    for key, needed in own_laws().items()
                }
            ),
        }
    found: Mapping[str, str] = {
        "models": {key: first_paragraph(text) for key, text in models().items()},
        "materials": {key: entry.meaning for key, entry in MATERIALS.items()},
        "results": {key: entry.description for key, entry in fields.RESULTS.items()},
        "terms": {key: text.partition(". ")[0] for key, text in TERMS.items()},
    }[name]
    return {name: _lines(found)}


def overview(name: str) -> list[str]:
    """Return a group in short: of closures the kinds alone, which have lists of
    their own.
    """
    if name != "closures":
        return [
            line
            for title, lines in sections(name).items()
            for line in (title, *(f"    {one}" for one in lines))
        ]
    about = {
        kind: f"{arguments.RESULTS.get(kind, kind)}: "
        + ", ".join(name.removeprefix(f"{kind}_") for name in closures.names(kind))
        for kind in kinds()
    }
    head = (
        "kinds of closures; `contbed explain KIND` lists them, `contbed closures "
        "--for KIND` ranks them"
    )
    return [head, *(f"    {line}" for line in _lines(about))]


def _lines(entries: Mapping[str, str]) -> list[str]:
    return [f"{name:28} {text}" for name, text in entries.items()]


def last_parts(names: Iterable[str]) -> dict[str, list[str]]:
    """Return whole names by their last part.

    >>> last_parts(["mesh.cells", "gas.cells", "boundary.NAME"])
    {'cells': ['mesh.cells', 'gas.cells']}
    """
    found: dict[str, list[str]] = {}
    for name in names:
        last = name.rpartition(".")[2]
        if last != "NAME":
            found.setdefault(last, []).append(name)
    return found
