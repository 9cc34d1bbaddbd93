"""TOML -> settings.Scene. All mistakes are collected and reported at once, each with file, line, key and remedy."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterator, Mapping
from copy import deepcopy
from difflib import get_close_matches
from pathlib import Path
from typing import Any

from pydantic import TypeAdapter, ValidationError

from contbed.errors import SceneError
from contbed.models import KINDS, find
from contbed.packed_bed.checks import mistakes
from contbed.packed_bed.scene import Scene, SceneBase, Table
from contbed.scene import schema as reference
from contbed.scene.toml_lines import KeyPath, Origin, dotted, one_line, parse, parse_key, read

_LIMITS = {"greater_than", "greater_than_equal", "less_than", "less_than_equal"}


def load(path: str | Path, overrides: Mapping[str, Any] | None = None) -> Scene:
    """The scene of a file. `overrides` such as {"mesh.refine": 2} replace values before anything is checked.

    A table names the kind of scene: [two_fluid] a `two_fluid.settings.TwoFluidScene`, [fully_developed] a
    `two_fluid.developed_settings.DevelopedScene`, [bubbling_bed] a
    `bubbling.settings.BubblingScene`, [particles] and [gas] a `dem.gas_settings.GasScene`, [particles] or [lattice] a
    `dem.settings.ParticleScene`.
    """
    return _build(*read(path), overrides or {})


def loads(
    text: str, name: str = "scene.toml", overrides: Mapping[str, Any] | None = None, base: str | Path = "."
) -> Scene:
    """The scene of a TOML text; `name` stands in messages and a mesh file is looked for in `base`."""
    return _build(*parse(text, name, Path(base).absolute()), overrides or {})


def from_dict(values: Mapping[str, Any], name: str = "scene", base: str | Path = ".") -> Scene:
    """The scene of plain nested dicts, as `resolved` returns them."""
    return _build(deepcopy(dict(values)), Origin(name, Path(base).absolute()), {})


def resolved(scene: SceneBase) -> dict[str, Any]:
    """All values in SI, defaults included, as plain JSON data. What is absent is left out."""
    return scene.model_dump(mode="json", exclude_none=True)


def scene_hash(scene: SceneBase) -> str:
    """A hash of what a run depends on: the values and the content of the files they name, not the title."""
    values = {key: value for key, value in resolved(scene).items() if key != "title"}
    digest = hashlib.sha256(json.dumps(values, sort_keys=True).encode())
    for file in _files(scene):
        digest.update((scene.origin.base / file).read_bytes())
    return digest.hexdigest()[:16]


def _files(part: Any) -> Iterator[str]:
    """The files that the tables of a scene name: a mesh, closures, particles."""
    if isinstance(part, Mapping):
        for item in part.values():
            yield from _files(item)
    elif isinstance(part, Table):
        if isinstance(file := getattr(part, "file", None), str):
            yield file
        for name in type(part).model_fields:
            yield from _files(getattr(part, name))


def _build(values: dict[str, Any], origin: Origin, overrides: Mapping[str, Any]) -> Any:
    problems: list[tuple[KeyPath, str]] = []
    origin = _override(values, origin, overrides, problems)
    if isinstance(fluid := values.get("fluid"), dict):
        fluid.setdefault("model", "constant")
    if not values:
        raise SceneError(f"{origin.name}:1: the scene is empty; it needs [mesh], [fluid], [bed] and [flow]")
    model, checks = _kind(values)
    parts, broken = _validate(model, values, problems)
    problems += mistakes(parts, broken, origin, checks)
    if problems:
        problems.sort(key=lambda problem: origin.line(problem[0]))
        raise SceneError(list(dict.fromkeys(_line(origin, values, path, text) for path, text in problems)))
    scene = model(**{name: part for name, part in parts.items() if part is not None})
    scene._origin = origin
    return scene


def _override(
    values: dict[str, Any], origin: Origin, overrides: Mapping[str, Any], problems: list[tuple[KeyPath, str]]
) -> Origin:
    """Put the overrides into `values`, creating tables on the way."""
    paths: list[KeyPath] = []
    for key, value in overrides.items():
        try:
            path = parse_key(key)
        except ValueError:
            path = (key,)
        paths.append(path)
        table: Any = values
        for step in path[:-1]:
            table = table.setdefault(step, {}) if isinstance(table, dict) else None
        if isinstance(table, dict):
            # numpy's numbers become Python's
            table[str(path[-1])] = value.item() if hasattr(value, "item") else value
        else:
            problems.append((path, "cannot be set: a key on the way to it is not a table"))
    return Origin(origin.name, origin.base, origin.lines, tuple(paths))


def _kind(values: Mapping[str, Any]) -> tuple[Any, Any]:
    """The model of this kind of scene and its checks, None for the usual ones."""
    if (name := _kind_name(values)) is None:
        return Scene, None
    kind = KINDS[name]
    return find(kind.settings), find(kind.checks)


def _kind_name(values: Mapping[str, Any]) -> str | None:
    """The kind that the tables of a scene show, None for a packed bed."""
    for name in ("two_fluid", "fully_developed"):
        if name in values:
            return name
    if any(_near(name, ["bubbling_bed"]) for name in values):
        return "bubbling_bed"
    if "particles" in values and "gas" in values:
        return "particles_gas"
    if {"particles", "lattice"} & set(values) or ("mesh" not in values and "conduction" in values):
        return "particles"
    return None


def _validate(
    model: Any, values: dict[str, Any], problems: list[tuple[KeyPath, str]]
) -> tuple[dict[str, Any], set[str]]:
    """Each table by itself, so that mistakes in one do not hide the contradictions between the others."""
    parts: dict[str, Any] = {}
    broken: set[str] = set()
    try:
        scene = model.model_validate(values)
        return {name: getattr(scene, name) for name in model.model_fields}, broken
    except ValidationError as invalid:
        errors = invalid.errors(include_url=False)
    for error in errors:
        path, text = _translate(error, values, reference.schema(model.kind))
        problems.append((path, text))
        # A misspelt table is not an absent one: what it breaks is not told twice.
        broken.update({str(path[0]), *_near(str(path[0]), list(model.model_fields))})
    for name, field in model.model_fields.items():
        if name in broken:
            continue
        if name in values:
            # the annotation without its field description is all that a table needs
            parts[name] = TypeAdapter(field.rebuild_annotation()).validate_python(values[name])
        else:
            parts[name] = field.get_default(call_default_factory=True)
    return parts, broken


def _translate(error: Mapping[str, Any], values: dict[str, Any], root: dict[str, Any]) -> tuple[KeyPath, str]:
    """The key path without pydantic's union tags, and what is wrong in our words."""
    path, node = _locate(error["loc"], root)
    kind, context = error["type"], error.get("ctx", {})
    found = _value(values, path)
    if kind == "extra_forbidden":
        known = reference.keys(_locate(error["loc"][:-1], root)[1])
        return path, f"unknown key; {nearest(str(path[-1]), known)}"
    if kind == "missing":
        table = node.get("type") == "object" or "$ref" in node or "discriminator" in node
        needs = reference.allowed(node)
        return path, f"this table is missing; it is {needs}" if table else f"missing; allowed: {needs}"
    if kind in ("union_tag_not_found", "union_tag_invalid") and "discriminator" in node:
        selector = node["discriminator"]["propertyName"]
        known = list(node["discriminator"]["mapping"])
        if kind == "union_tag_not_found":
            return (*path, selector), f"missing; allowed: {', '.join(map(repr, known))}"
        tag = found.get(selector) if isinstance(found, dict) else None
        return (*path, selector), f"unknown choice; {nearest(str(tag), known)}"
    if kind in ("literal_error", "enum"):
        return path, f"unknown choice; {nearest(str(found), reference.choices(node))}"
    if kind in _LIMITS:
        return path, f"out of range; allowed: {reference.allowed(node)}"
    if kind == "value_error":
        return path, str(context["error"])
    if kind == "finite_number":
        return path, f"not a finite number; allowed: {reference.allowed(node)}"
    return path, f"wrong kind of value; allowed: {reference.allowed(node)}"


def _locate(loc: tuple[Any, ...], root: dict[str, Any]) -> tuple[KeyPath, dict[str, Any]]:
    """Follow pydantic's location through the schema; a step at a union is the tag of a member, not a key."""
    path: KeyPath = ()
    node = root
    steps = list(loc)
    while steps:
        step = steps.pop(0)
        members = reference.options(node)
        if len(members) > 1:
            # Each further step looks into the members, so only the tag itself is left out.
            mapping = node.get("discriminator", {}).get("mapping")
            if mapping:
                node = {"$ref": mapping[step]}
            else:
                wanted = {"number": "number", "name": "string", "list": "array"}.get(step, "object")
                fits = [m for m in members if m.get("type") == wanted]
                named = [m for m in fits if reference.is_closure(m) == (step == "parameters")]
                node = (named or fits or members)[0]
            continue
        path += (step,)
        node = next(iter(reference.children(node, step)), {})
    return path, node


def nearest(name: str, known: list[Any]) -> str:
    """What is allowed in place of a name that is not known, and which of it was probably meant."""
    allowed = f"allowed: {', '.join(str(item) if isinstance(item, str) else json.dumps(item) for item in known)}"
    near = _near(name, known)
    return f"{allowed}; did you mean '{near[0]}'?" if near else allowed


def _near(name: str, known: list[Any]) -> list[str]:
    return get_close_matches(name.lower(), [item for item in known if isinstance(item, str)], n=1, cutoff=0.6)


def _value(values: Any, path: KeyPath) -> Any:
    for key in path:
        try:
            values = values[key]
        except (KeyError, IndexError, TypeError):
            return None
    return values


def _line(origin: Origin, values: dict[str, Any], path: KeyPath, text: str) -> str:
    value = _value(values, path)
    shown = "" if value is None or isinstance(value, dict) else f" = {_shown(value)}"
    return one_line(f"{origin.at(path)}: {dotted(path)}{shown}: {text}")


def _shown(value: Any) -> str:
    try:
        text = json.dumps(value, default=str, ensure_ascii=False)
    except ValueError:  # Python's limit on the digits of an integer
        return "..."
    return text if len(text) <= 60 else text[:57] + "..."
