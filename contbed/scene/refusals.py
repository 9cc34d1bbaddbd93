"""What pydantic refuses in a table, in the words of contbed: the key, its value, what
is wrong and what is allowed.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any, TypeVar

from pydantic import BaseModel, ValidationError

from contbed.errors import SceneError
from contbed.scene import schema
from contbed.scene.names import near_names, nearest
from contbed.scene.toml_lines import KeyPath, Origin, dotted, one_line
from contbed.scene.values import at

_Table = TypeVar("_Table", bound=BaseModel)
_LIMITS = {"greater_than", "greater_than_equal", "less_than", "less_than_equal"}


def table_of(model: type[_Table], values: dict[str, Any], origin: Origin) -> _Table:
    """Return a file other than a scene as its table `model`.

    Raises
    ------
    SceneError : all mistakes, each with file and line
    """
    if found := mistakes_of(model, values):
        raise SceneError(one_line(f"{origin.at(path)}: {text}") for path, text in found)
    return model.model_validate(values)


def mistakes_of(
    model: type[BaseModel], values: dict[str, Any]
) -> list[tuple[KeyPath, str]]:
    """Return the mistakes in a table that should be a `model`: path, and key, value
    and what is wrong.
    """
    try:
        model.model_validate(values)
    except ValidationError as invalid:
        errors = own(invalid.errors(include_url=False))
        found = (translate(error, values, schema.of(model)) for error in errors)
        return [(path, _about(values, path, text)) for path, text in found]
    return []


def own(errors: Sequence[Mapping[str, Any]]) -> list[Mapping[str, Any]]:
    """Return the errors without those of lists that are too short only because an
    item of theirs is refused.
    """
    places = [error["loc"] for error in errors]
    return [
        error
        for error, here in zip(errors, places, strict=True)
        if error["type"] != "too_short"
        or not any(place != here and place[: len(here)] == here for place in places)
    ]


def translate(
    error: Mapping[str, Any], values: dict[str, Any], root: dict[str, Any]
) -> tuple[KeyPath, str]:
    """Return the key path without pydantic's union tags, and what is wrong in our
    words.
    """
    path, node = _locate(error["loc"], root)
    kind, context = error["type"], error.get("ctx", {})
    found = at(values, path)
    if kind == "extra_forbidden":
        known = schema.keys(_locate(error["loc"][:-1], root)[1])
        hint = nearest(str(path[-1]), known) if known else "this table has no keys"
        choice = _locate(error["loc"][:-2], root)[1].get("discriminator", {})
        for tag, member in choice.get("mapping", {}).items():
            if path[-1] in schema.keys({"$ref": member}):
                selector = dotted((*path[:-1], choice["propertyName"]))
                hint = f'it needs {selector} = "{tag}"; {hint}'
                break
        return path, f"unknown key; {hint}"
    if kind == "missing":
        table = (
            node.get("type") == "object" or "$ref" in node or "discriminator" in node
        )
        needs = schema.allowed(node)
        return (
            path,
            f"this table is missing; it is {needs}"
            if table
            else f"missing; allowed: {needs}",
        )
    if kind in ("union_tag_not_found", "union_tag_invalid") and "discriminator" in node:
        selector = node["discriminator"]["propertyName"]
        known = list(node["discriminator"]["mapping"])
        if kind == "union_tag_not_found":
            meant = (
                [key for key in found if key in near_names(selector, list(found))]
                if isinstance(found, dict)
                else []
            )
            if meant:
                return (
                    (
                        *path,
                        meant[0],
                    ),
                    f"unknown key; did you mean '{selector}'? allowed: "
                    f"{', '.join(map(repr, known))}",
                )
            return (*path, selector), f"missing; allowed: {', '.join(map(repr, known))}"
        tag = found.get(selector) if isinstance(found, dict) else None
        return (*path, selector), f"unknown choice; {nearest(str(tag), known)}"
    if kind in ("literal_error", "enum"):
        return path, f"unknown choice; {nearest(str(found), schema.choices(node))}"
    if kind in _LIMITS:
        return path, f"out of range; allowed: {schema.allowed(node)}"
    if kind in ("too_short", "too_long"):
        text = f"a list of {len(found)}" if found else "empty"
        return path, f"{text}; allowed: {schema.allowed(node)}"
    if kind == "value_error":
        return path, str(context["error"])
    if kind == "finite_number":
        return path, f"not a finite number; allowed: {schema.allowed(node)}"
    return path, f"wrong kind of value; allowed: {schema.allowed(node)}"


def _locate(
    loc: tuple[Any, ...], root: dict[str, Any]
) -> tuple[KeyPath, dict[str, Any]]:
    """Follow pydantic's location through the schema; a step at a union is the tag of
    a member, not a key.
    """
    path: KeyPath = ()
    node = root
    steps = list(loc)
    while steps:
        step = steps.pop(0)
        members = schema.options(node)
        if len(members) > 1:
            # Each further step looks into the members, so only the tag itself is left
            # out.
            mapping = node.get("discriminator", {}).get("mapping")
            if mapping:
                node = {"$ref": mapping[step]}
            else:
                wanted = {"number": "number", "name": "string", "list": "array"}.get(
                    step, "object"
                )
                fits = [m for m in members if m.get("type") == wanted]
                named = [
                    m for m in fits if schema.is_closure(m) == (step == "parameters")
                ]
                node = (named or fits or members)[0]
            continue
        path += (step,)
        node = next(iter(schema.children(node, step)), {})
    return path, node


def line(origin: Origin, values: dict[str, Any], path: KeyPath, text: str) -> str:
    """Return what is wrong with a key as a line that begins with its place."""
    return one_line(f"{origin.at(path)}: {_about(values, path, text)}")


def _about(values: dict[str, Any], path: KeyPath, text: str) -> str:
    """Return what is wrong with a key behind its name and value."""
    value = at(values, path)
    shown = "" if value is None or isinstance(value, dict) else f" = {_shown(value)}"
    return f"{dotted(path)}{shown}: {text}"


def _shown(value: Any) -> str:
    try:
        text = json.dumps(value, default=str, ensure_ascii=False)
    except ValueError:  # Python's limit on the digits of an integer
        return "..."
    return text if len(text) <= 60 else text[:57] + "..."
