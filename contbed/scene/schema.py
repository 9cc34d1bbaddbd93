"""Facts of the schema about a table or key of a scene: type, unit, bounds, default,
meaning.

Errors, `contbed explain` and table headers all read the JSON schemas of the scenes
through this module, so that each fact stands in one place. A name that the user
chooses, like that of a boundary, is written NAME.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from functools import cache
from typing import Any

from contbed.scene.toml_lines import KeyPath, dotted

Node = dict[str, Any]
_BOUNDS = {
    "gt": ">",
    "exclusiveMinimum": ">",
    "ge": ">=",
    "minimum": ">=",
    "lt": "<",
    "exclusiveMaximum": "<",
    "le": "<=",
    "maximum": "<=",
}
# of a list of coefficients: the unit of the variable of the polynomial
POWERS_OF = "powers_of"
_TYPES = {"number": "number", "integer": "integer", "boolean": "true or false"}


# of the schemas that have been asked for; one name means one table in all of them
_definitions: dict[str, Node] = {}


@cache
def of(model: Any) -> Node:
    """Return the JSON schema of a kind of scene from its pydantic model."""
    found: Node = model.model_json_schema(ref_template=f"{model.kind}/{{model}}")
    _definitions.update(
        {f"{model.kind}/{name}": node for name, node in found.get("$defs", {}).items()}
    )
    return found


def options(node: Node) -> list[Node]:
    """Return the ways in which a value may be written, with references resolved and
    null left out.
    """
    if "$ref" in node:
        return options(_definitions[node["$ref"]])
    members = node.get("oneOf") or node.get("anyOf")
    if members is None:
        return [] if node.get("type") == "null" else [node]
    return [
        {**_unit_of(node), **option} for member in members for option in options(member)
    ]


def _unit_of(node: Node) -> Node:
    """Return the unit, which stands at the list or union and holds for its items or
    members.
    """
    return {"unit": node["unit"]} if "unit" in node else {}


def _unit_of_coefficient(node: Node, option: Node, power: int) -> Node:
    """Return the unit of a coefficient of a polynomial, which the number beside the
    list has; nothing of others.
    """
    whole = next((way["unit"] for way in options(node) if "unit" in way), None)
    if whole is None or POWERS_OF not in option:
        return {}
    if not power:
        return {"unit": whole}
    variable = option[POWERS_OF]
    start, power = (
        (whole, power + 1)
        if whole.endswith(f"/{variable}")
        else (f"{whole}/{variable}", power)
    )
    return {"unit": f"{start}**{power}" if power > 1 else start}


def children(node: Node, key: str | int) -> list[Node]:
    """Return what `key` may hold in the tables or lists that `node` allows."""
    found = []
    for option in options(node):
        if isinstance(key, int):
            parts = option.get("prefixItems", [])
            item = parts[key] if key < len(parts) else option.get("items")
            if item is not None:
                found.append(
                    {
                        **_unit_of(option),
                        **_unit_of_coefficient(node, option, key),
                        **item,
                    }
                )
        elif key in option.get("properties", {}):
            found.append(option["properties"][key])
        elif isinstance(option.get("additionalProperties"), dict):
            found.append(option["additionalProperties"])
    return found


def at(root: Node, path: KeyPath) -> list[Node]:
    """Return the nodes of a key path; several if a table on the way has several
    types, none if it is unknown.
    """
    nodes = [root]
    for key in path:
        nodes = [child for node in nodes for child in children(node, key)]
    return nodes


def unit(root: Node, path: KeyPath) -> str | None:
    """Return the SI unit of a key; None if it has none or is not a number."""
    for node in at(root, path):
        for option in [node, *options(node)]:
            item = next(
                iter(option.get("prefixItems", [])), option.get("items", option)
            )
            if found := option.get("unit") or item.get("unit"):
                return str(found)
    return None


def keys(node: Node) -> list[str]:
    """Return the keys of the tables that `node` allows; NAME where they are free."""
    found: list[str] = []
    for option in options(node):
        names = list(option.get("properties", {}))
        if isinstance(option.get("additionalProperties"), dict):
            names.append("NAME")
        found += [name for name in names if name not in found]
    return found


def below(
    table: Node, path: tuple[str, ...] = (), seen: tuple[str, ...] = ()
) -> Iterator[tuple[tuple[str, ...], Node]]:
    """Yield the keys in a table and in those below it; tables that hold themselves
    once.
    """
    for key, node in table.get("properties", {}).items():
        yield (*path, key), node
        for option in options(node):
            tables = [((*path, key), option)]
            inner = option.get("additionalProperties")
            if isinstance(inner, dict):
                tables += [((*path, key, "NAME"), each) for each in options(inner)]
            for name, inside in tables:
                title = str(inside.get("title", ""))
                if (
                    "properties" in inside
                    and title not in seen
                    and not is_closure(inside)
                ):
                    yield from below(inside, name, (*seen, title))


def is_closure(option: Node) -> bool:
    """Return whether an option is a closure's table, the only one that may have
    further keys.
    """
    return option.get("additionalProperties") is True and "properties" in option


def is_closure_file(option: Node) -> bool:
    """Return whether an option is the file of a closure."""
    return option.get("title") == "ClosureFile"


def choices(node: Node) -> list[Any]:
    """Return the permitted values of a key that is a choice, or that selects the
    type of its table.
    """
    found = []
    for option in options(node):
        found += option.get("enum", []) + (
            [option["const"]] if "const" in option else []
        )
    return found


def allowed(node: Node) -> str:
    """Return the permitted values in words: "> 0 m", "'line' or 'box'", "a
    number >= 0, a closure's name".
    """
    ways = options(node)
    named = any(is_closure(way) or is_closure_file(way) for way in ways)
    text = "a closure's name" if named else "a text"
    found = [
        text if way.get("type") == "string" else _one(way)
        for way in ways
        if "enum" not in way and "const" not in way
    ]
    values = " or ".join(json.dumps(value) for value in choices(node))
    return ", or ".join(dict.fromkeys([*found, *filter(None, [values])]))


def _one(option: Node) -> str:
    kind = option.get("type")
    if kind == "object":
        if is_closure(option):
            return "a table with a closure's name and parameters"
        if is_closure_file(option):
            return "a table with the file of a closure"
        names = ", ".join(keys(option))
        return f"a table with {names}" if names else "a table"
    if kind == "array":
        if parts := option.get("prefixItems"):
            return f"a list of {len(parts)}: {_one(parts[0])}"
        least, most = option.get("minItems", 0), option.get("maxItems")
        count = "" if least < 2 else f" of {least} or more"
        if most is not None:
            count = f" of {most}" if least == most else f" of {least} to {most}"
        return f"a list{count}, each {allowed(option.get('items', {}))}"
    bounds = [
        f"{sign} {option[key]:g}" for key, sign in _BOUNDS.items() if key in option
    ]
    words = [
        "an" if kind == "integer" else "a",
        _TYPES.get(str(kind), "value"),
        " and ".join(bounds),
        "" if option.get("unit") == "1" else option.get("unit", ""),
    ]
    if kind == "boolean":
        del words[0]
    return " ".join(filter(None, words))


def sheet(name: str, node: Node) -> Iterator[str]:
    """Yield the lines of the data sheet of a table or key."""
    tables = [
        option
        for option in options(node)
        if "properties" in option
        and not is_closure(option)
        and not is_closure_file(option)
    ]
    written_otherwise = any("properties" not in option for option in options(node))
    if written_otherwise or not tables:
        yield f"{name} - {node['description']}" if "description" in node else name
        yield f"    allowed: {allowed(node)}"
        if any(is_closure(option) for option in options(node)):
            yield "    `contbed list` shows all closures"
        if "default" in node:
            value = node["default"]
            yield f"    default: {'absent' if value is None else json.dumps(value)}"
        yield from [""] * bool(tables)
    for table in tables:
        yield f"[{name}] {table.get('description', '')}"
        required = table.get("required", [])
        for key, child in table["properties"].items():
            if all(
                "properties" in option and not is_closure(option)
                for option in options(child)
            ):
                text = f"table, see {dotted((*name.split('.'), key))}"
            else:
                text = allowed(child)
            if key in required:
                text += "; required"
            elif child.get("default") not in (None, [], ""):
                text += f"; default {json.dumps(child['default'])}"
            meaning = f"  # {child['description']}" if "description" in child else ""
            yield f"    {key}: {text}{meaning}"
        yield ""
