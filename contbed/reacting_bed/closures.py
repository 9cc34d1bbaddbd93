"""Closures that a scene names: where they may stand, which arguments they get, and
those of a bed and of its phases.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from contbed.closures.binding import BoundClosure, bind, is_phase, named
from contbed.closures.packed_beds import GIVES
from contbed.reacting_bed import scene as s
from contbed.scene.tables import Closure

KIND_OF = {  # of closures whose key is not the name of their kind
    "conductivity_gas": "conductivity",
    "conductivity_solids": "conductivity",
    "dispersion_mass": "mass_dispersion",
    "coefficient": "wall",
}
OF_BED = (
    "permeability",
    "forchheimer",
    "conductivity_gas",
    "dispersion",
    "dispersion_mass",
)
OF_PHASE = ("nusselt", "sherwood", "conductivity_solids")
OF_HEAT = {
    "nusselt",
    "conductivity_gas",
    "conductivity_solids",
    "dispersion",
    "coefficient",
}
ACROSS = ("conductivity_gas", "conductivity_solids", "dispersion", "dispersion_mass")


def places_of(
    closures: s.Closures,
    packed_bed: s.PackedBed,
    solids: Mapping[str, s.Solid],
    boundary: Mapping[str, s.Boundary],
) -> list[tuple[tuple[str, ...], Any, str]]:
    """Return (key, value, kind) of each place where a scene may name a closure."""
    tables: list[tuple[tuple[str, ...], Any, tuple[str, ...]]] = [
        (("closures",), closures, (*OF_BED, *OF_PHASE))
    ]
    tables += [
        (("solids", name), table, OF_PHASE[:2]) for name, table in solids.items()
    ]
    if packed_bed.section is not None:
        tables.append((("packed_bed", "section"), packed_bed.section, ACROSS))
    if "wall" in boundary:
        tables.append((("boundary", "wall"), boundary["wall"], ("coefficient",)))
    return [
        ((*path, key), getattr(table, key), KIND_OF.get(key, key))
        for path, table, keys in tables
        for key in keys
    ]


def bound(spec: Any, kind: str, base: Any, direction: str = "axial") -> BoundClosure:
    """Return the closure that a scene names; of a pair for dispersion that of a
    direction, axial or transverse.
    """
    if kind == "dispersion" and isinstance(spec, str | Closure):
        name = spec if isinstance(spec, str) else spec.name
        full = name if name.startswith("dispersion_") else f"dispersion_{name}"
        full = full if full.endswith(f"_{direction}") else f"{full}_{direction}"
        spec = full if isinstance(spec, str) else spec.model_copy(update={"name": full})
    return bind(spec, kind, GIVES[kind], base)


def of_bed(scene: s.ReactingScene) -> dict[str, Any]:
    """Return the closures of a whole bed by key."""
    found = {key: getattr(scene.closures, key) for key in OF_BED}
    if scene.section is not None:
        found |= {
            f"section.{key}": getattr(scene.section, key)
            for key in ACROSS
            if key != "conductivity_solids"
        }
    if scene.wall is not None:
        found["coefficient"] = scene.wall.coefficient
    return found


def of_phase(scene: s.ReactingScene, table: s.Solid) -> dict[str, Any]:
    """Return the closures of a solid phase by key, its own where it has some."""
    closures = scene.closures
    found: dict[str, Any] = {"conductivity_solids": closures.conductivity_solids}
    found |= {key: s.film_of(closures, table, key) for key in ("nusselt", "sherwood")}
    if scene.section is not None:
        found["section.conductivity_solids"] = scene.section.conductivity_solids
    return found


def given(
    scene: s.ReactingScene, values: Mapping[str, Any]
) -> tuple[dict[str, Any], dict[str, BoundClosure]]:
    """Return the values that are given by key, and the closures of those that name
    one; of heat where it is solved.
    """
    specs, closures = {}, {}
    for full, spec in values.items():
        key = full.removeprefix("section.")
        if spec is None or (scene.heat is None and key in OF_HEAT):
            continue
        specs[full] = spec
        kind = KIND_OF.get(key, key)
        if named(spec) and not (kind == "conductivity" and is_phase(spec)):
            direction = "axial" if full == key else "transverse"
            closures[full] = bound(spec, kind, scene.origin.base, direction)
    return specs, closures
