"""What helps to write a scene: a commented scene of each physics, and the JSON
schema by which editors check scenes.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from contbed import closures
from contbed.errors import SceneError
from contbed.explain.closure_keys import kind_of_key
from contbed.models import MODELS
from contbed.scene import schema
from contbed.scene.library import MATERIALS
from contbed.scene.names import first_paragraph, nearest
from contbed.scene.quantities import CLOSURE

Node = dict[str, Any]
# what a material may give
OF_MATERIALS = {key for entry in MATERIALS.values() for key in entry.properties()}
DIALECT = "https://json-schema.org/draft/2020-12/schema"
# a number, then the name of a unit that `scene.units` converts
QUANTITY = r"^\s*[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?\s*[^0-9\s].*$"
# pydantic's names of bounds where a validator stands before them
BOUNDS = {
    "gt": "exclusiveMinimum",
    "ge": "minimum",
    "lt": "exclusiveMaximum",
    "le": "maximum",
}
PLAIN = r"^\s*[+-]?([0-9]+\.?[0-9]*|\.[0-9]+)([eE][+-]?[0-9]+)?\s*$"


def template(kind: str) -> str:
    """Return a commented scene of a physics that runs as it is.

    Raises
    ------
    SceneError : there is no such physics
    """
    return str(_model(kind).template.read_text(encoding="utf-8"))


def summary(kind: str) -> str:
    """Return in one line what the scenes of a physics describe."""
    return first_paragraph(schema.of(_model(kind).scene)["description"])


def json_schema(kind: str | None = None) -> Node:
    """Return the JSON schema of the scenes of one physics; of all together if None.

    It takes what `contbed check` takes of the single values: quantities are numbers in
    SI or texts with a unit. What values contradict each other is left to `contbed
    check`.

    Raises
    ------
    SceneError : there is no such physics
    """
    kinds = [kind] if kind is not None else list(MODELS)
    definitions: Node = {}
    roots = []
    for name in kinds:
        root = _model(name).scene.model_json_schema(
            ref_template=f"#/$defs/{name}.{{model}}"
        )
        for title, node in root.pop("$defs", {}).items():
            definitions[f"{name}.{title}"] = node
        definitions[name] = root
        roots.append({"$ref": f"#/$defs/{name}"})
    for node in definitions.values():
        _complete(node)
    head = {"$schema": DIALECT, "title": "scene of contbed"}
    return {
        **head,
        **(roots[0] if len(roots) == 1 else {"anyOf": roots}),
        "$defs": definitions,
    }


def _model(kind: str) -> Any:
    if kind not in MODELS:
        raise SceneError(
            f"there is no kind of scene {kind!r}; {nearest(kind, list(MODELS))}"
        )
    return MODELS[kind]


def _complete(table: Node) -> None:
    """Change the schema of a table in place: units in words and as texts, names of
    closures, keys left to defaults.
    """
    table.pop("discriminator", None)
    title = str(table.get("title", ""))
    properties = table.get("properties", {})
    for key, node in properties.items():
        for part in _parts(node):
            part.pop("discriminator", None)
            # a text with a unit may look like the name of a closure as well
            if "oneOf" in part:
                part["anyOf"] = part.pop("oneOf")
            for name in [name for name in BOUNDS if name in part]:
                part[BOUNDS[name]] = part.pop(name)
        _add_names(title, key, node)
        node.pop(CLOSURE, None)
        _allow_units(node, None)
    required = [
        key
        for key in table.get("required", [])
        if not ("material" in properties and key in OF_MATERIALS)
    ]
    if "required" in table:
        table["required"] = required
    # the default model of a fluid is constant
    if "model" in required and properties["model"].get("const") == "constant":
        required.remove("model")


def _parts(node: Node) -> Iterator[Node]:
    """Yield a node and all nodes in it; what it refers to is left out."""
    yield node
    for name in ("anyOf", "oneOf", "prefixItems"):
        for part in node.get(name, []):
            yield from _parts(part)
    for name in ("items", "additionalProperties"):
        if isinstance(node.get(name), dict):
            yield from _parts(node[name])


def _add_names(table: str, key: str, node: Node) -> None:
    """Name the closures that an editor may offer where a text stands for one."""
    if key == "material":
        phase = "fluid" if table.startswith("Gas") else "solid"
        names = [entry.name for entry in MATERIALS.values() if entry.phase == phase]
        node["anyOf"] = [{"enum": names}]
        return
    kind = kind_of_key(key, node)
    if kind is None:
        return
    names = [
        name.removesuffix("_axial")
        for name in closures.names(kind)
        if not name.endswith("_transverse")
    ]
    for part in list(_parts(node)):
        if part.get("type") == "string" and "const" not in part and "enum" not in part:
            part["anyOf"] = [{"enum": names}, {"type": "string"}]


def _allow_units(node: Node, unit: str | None) -> None:
    """Let a quantity be a text with a unit, and name its SI unit in the description."""
    unit = node.pop("unit", unit)
    if unit is not None and node.get("type") in ("number", "integer"):
        number = {
            name: node.pop(name)
            for name in list(node)
            if name not in ("description", "default", "title")
        }
        node["anyOf"] = [
            number,
            {"type": "string", "pattern": PLAIN if unit == "1" else QUANTITY},
        ]
        if unit != "1":
            node["description"] = (
                f"{node['description']} [{unit}]"
                if "description" in node
                else f"[{unit}]"
            )
        return
    for name in ("anyOf", "prefixItems"):
        for part in node.get(name, []):
            _allow_units(part, unit)
    for name in ("items", "additionalProperties"):
        if isinstance(node.get(name), dict):
            _allow_units(node[name], unit)
