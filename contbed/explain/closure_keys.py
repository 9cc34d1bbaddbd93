"""Keys of a scene that name closures, and the kind of closure that each takes:
`closures.nusselt` a Nusselt number.
"""

from __future__ import annotations

from functools import cache
from typing import Any

from contbed.closures import registry
from contbed.models import MODELS
from contbed.scene import schema
from contbed.scene.quantities import CLOSURE
from contbed.scene.toml_lines import KeyPath, dotted

DIRECTIONS = ("axial", "transverse")


def kind_of_key(key: str, node: schema.Node) -> str | None:
    """Return the kind of closure that a key takes; None if it takes none.

    The field of the key names it where neither the name of the key nor its default
    does.
    """
    if CLOSURE in node:
        return str(node[CLOSURE])
    default = node.get("default")
    if isinstance(default, str) and default in registry.names():
        return registry.sheet(default).kind
    kinds = {registry.sheet(name).kind for name in registry.names()}
    if isinstance(default, str) and f"{key}_{default}" in registry.names():
        return key
    takes_text = any(
        way.get("type") == "string" and "enum" not in way and "const" not in way
        for way in _ways(node)
    )
    return key if key in kinds and takes_text else None


@cache
def closure_keys() -> dict[str, str]:
    """Return the kind of closure of each key of all kinds of scenes: "closures.drag"
    takes "drag". The coefficient of a wall is that of a packed bed.
    """
    found: dict[str, str] = {}
    for model in reversed(MODELS.values()):
        for path, kind in _kinds_below(model.scene):
            found.setdefault(".".join(path), kind)
    return found


def kinds_by_model(key: str) -> dict[str, str]:
    """Return the kind of closure that a key takes in each model that has it."""
    return {
        name: kind
        for name, model in MODELS.items()
        for path, kind in _kinds_below(model.scene)
        if ".".join(path) == key
    }


@cache
def _kinds_below(scene: Any) -> list[tuple[tuple[str, ...], str]]:
    """Return the keys of a kind of scenes that take closures, and the kind of each."""
    nodes = schema.below(schema.of(scene))
    kinds = [(path, kind_of_key(path[-1], node)) for path, node in nodes]
    return [(path, kind) for path, kind in kinds if kind]


def right_keys(scene: Any, path: KeyPath, value: Any) -> str:
    """Say which keys of a kind of scenes take the closure that stands at another key;
    empty where none stands there.
    """
    name = value.get("name") if isinstance(value, dict) else value
    kinds = _kinds_of(name) if isinstance(name, str) else set()
    if not kinds:
        return ""
    if path[-1] in DIRECTIONS and str(name).endswith(DIRECTIONS):
        whole = str(name).removesuffix(f"_{path[-1]}")
        return f'; write {dotted(path[:-1])} = "{whole}", which gives both directions'
    found = [(keys, kind) for keys, kind in _kinds_below(scene) if kind in kinds]
    if any(_fits(keys, path) for keys, _ in found):
        return ""
    # those in the same table first
    found.sort(key=lambda each: not _fits(each[0][:-1], path[:-1]))
    shown = [dotted(_named_as(keys, path)) for keys, _ in found[:3]]
    taken = sorted({kind for _, kind in found} or kinds)
    what = f"'{name}' is a closure of the kind {' or '.join(taken)}"
    return f"; {what}: for {' or '.join(shown) or 'no key of this model'}"


def _kinds_of(name: str) -> set[str]:
    """Return the kinds of closures that have a name, with or without its kind."""
    kinds = ((each, registry.sheet(each).kind) for each in registry.names())
    return {kind for each, kind in kinds if name in (each, each[len(kind) + 1 :])}


def _fits(key: tuple[str, ...], path: KeyPath) -> bool:
    """Return whether a path is a key with NAME for what a user chooses."""
    return len(key) == len(path) and all(
        step in ("NAME", given) for step, given in zip(key, path, strict=True)
    )


def _named_as(key: tuple[str, ...], path: KeyPath) -> KeyPath:
    """Return a key with the names that a path in the same tables has."""
    named: list[str | int] = list(key)
    for k, (step, given) in enumerate(zip(key, path, strict=False)):
        if step not in ("NAME", given):
            break
        named[k] = given
    return tuple(named)


def _ways(node: schema.Node) -> list[schema.Node]:
    """Return the ways in which a value may be written, references left out."""
    if "$ref" in node:
        return []
    members = node.get("anyOf") or node.get("oneOf")
    return (
        [node]
        if members is None
        else [way for member in members for way in _ways(member)]
    )
