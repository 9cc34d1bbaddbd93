"""Places of a scene that name closures, and the kind of closure that each takes: `heat.nusselt` a Nusselt number."""

from __future__ import annotations

from collections.abc import Iterator
from functools import cache

from contbed.closures import registry
from contbed.models import MODELS
from contbed.scene import schema

# tables by the name of their class, where neither the name of the key nor its default tells the kind
KINDS = {
    ("Heat", "conductivity_bed"): "conductivity",
    ("Heat", "conductivity_fluid"): "conductivity",
    ("Heat", "conductivity_solid"): "conductivity",
    ("Section", "conductivity_fluid"): "conductivity",
    ("Section", "conductivity_solid"): "conductivity",
    ("Mass", "dispersion"): "mass_dispersion",
    ("BubblingBed", "conductivity"): "conductivity",
    ("PhaseCondition", "coefficient"): "wall",
    ("Wall", "coefficient"): "wall",
    ("Surface", "coefficient"): "bed_tube",
    ("GasTube", "nusselt"): "nusselt_cylinder",
    ("Species", "gas_coefficient"): "nusselt",
    ("Species", "conductivity"): "solids_mixing",
    ("Species", "exchange"): "solid_exchange",
    ("FullyDeveloped", "production"): "granular_production",
    ("FullyDeveloped", "turbulence"): "eddy_viscosity",
}


def kind_of_key(table: str, key: str, node: schema.Node) -> str | None:
    """Return the kind of closure that a key of a table takes, by the name of its class; None if it takes none."""
    if (table, key) in KINDS:
        return KINDS[table, key]
    default = node.get("default")
    if isinstance(default, str) and default in registry.names():
        return registry.sheet(default).kind
    kinds = {registry.sheet(name).kind for name in registry.names()}
    if isinstance(default, str) and f"{key}_{default}" in registry.names():
        return key
    takes_text = any(way.get("type") == "string" and "enum" not in way and "const" not in way for way in _ways(node))
    return key if key in kinds and takes_text else None


@cache
def places() -> dict[str, str]:
    """Return the kind of closure of each place of all kinds of scenes: "two_fluid.drag" takes "drag"."""
    found: dict[str, str] = {}
    for model in MODELS.values():
        for path, kind in _below(schema.of(model.scene), (), ()):
            found.setdefault(".".join(path), kind)
    return found


def _below(table: schema.Node, path: tuple[str, ...], seen: tuple[str, ...]) -> Iterator[tuple[tuple[str, ...], str]]:
    """Yield the places in a table and in those below it."""
    title = str(table.get("title", ""))
    for key, node in table.get("properties", {}).items():
        if kind := kind_of_key(title, key, node):
            yield (*path, key), kind
            continue
        for option in schema.options(node):
            inner = option.get("additionalProperties")
            tables = schema.options(inner) if isinstance(inner, dict) else [option]
            name = (key, "NAME") if isinstance(inner, dict) else (key,)
            for below in tables:
                below_title = str(below.get("title", ""))
                if "properties" in below and below_title not in seen and not schema.is_closure(below):
                    yield from _below(below, (*path, *name), (*seen, below_title))


def _ways(node: schema.Node) -> list[schema.Node]:
    """Return the ways in which a value may be written, references left out."""
    if "$ref" in node:
        return []
    members = node.get("anyOf") or node.get("oneOf")
    return [node] if members is None else [way for member in members for way in _ways(member)]
