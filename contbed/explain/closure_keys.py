"""Keys of a scene that name closures, and the kind of closure that each takes:
`closures.nusselt` a Nusselt number.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache

from contbed.closures import registry
from contbed.models import MODELS
from contbed.scene import schema
from contbed.scene.quantities import CLOSURE


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
    takes "drag".
    """
    found: dict[str, str] = {}
    for model in MODELS.values():
        for path, kind in _below(schema.of(model.scene), (), ()):
            found.setdefault(".".join(path), kind)
    return found


def _below(
    table: schema.Node, path: tuple[str, ...], seen: tuple[str, ...]
) -> Iterator[tuple[tuple[str, ...], str]]:
    """Yield the keys in a table and in those below it."""
    for key, node in table.get("properties", {}).items():
        if kind := kind_of_key(key, node):
            yield (*path, key), kind
            continue
        for option in schema.options(node):
            inner = option.get("additionalProperties")
            tables = schema.options(inner) if isinstance(inner, dict) else [option]
            name = (key, "NAME") if isinstance(inner, dict) else (key,)
            for below in tables:
                below_title = str(below.get("title", ""))
                if (
                    "properties" in below
                    and below_title not in seen
                    and not schema.is_closure(below)
                ):
                    yield from _below(below, (*path, *name), (*seen, below_title))


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
