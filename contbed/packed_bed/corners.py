"""Corners in which unlike prescribed temperatures meet.

Near such a corner the solution of Laplace's equation depends on the angle phi only,
T = T_1 + (T_2 - T_1) phi/(pi/2), so that the heat conducted through either side, k
(T_2 - T_1)/(pi/2) times the integral of dr/r, has no limit.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from itertools import combinations

from contbed.packed_bed import scene as s
from contbed.packed_bed.inlets import key_of
from contbed.scene.checking import Mistakes
from contbed.scene.mesh import Mesh, MeshFile, MeshLine
from contbed.scene.toml_lines import KeyPath

Side = tuple[int, float]  # direction and coordinate [m] of a side of a built-in mesh


def adjacent_sides(mesh: Mesh) -> Iterator[tuple[tuple[str, Side], tuple[str, Side]]]:
    """Yield pairs of sides, each a name and its place, that meet in a corner of a
    built-in mesh.
    """
    if isinstance(mesh, MeshFile):
        return
    sides = [
        (name, (k, position))
        for k, (names, extent) in enumerate(zip(mesh.sides, mesh.extents, strict=True))
        for name, position in zip(names, (0.0, extent), strict=True)
    ]
    for first, second in combinations(sides, 2):
        if first[1][0] != second[1][0]:
            yield first, second


def unlike_temperatures(
    boundary: Mapping[str, s.Boundary], phase: str, name: str, other: str
) -> tuple[float, float] | None:
    """Return the prescribed temperatures of a phase on two sides [K] where they are
    numbers that differ.
    """
    found = []
    for side in (name, other):
        condition = boundary[side].thermal(phase) if side in boundary else None
        if condition is None or not isinstance(condition.fixed_temperature, float):
            return None
        found.append(condition.fixed_temperature)
    return (found[0], found[1]) if found[0] != found[1] else None


def prescribed_temperatures_agree_in_corners(
    mesh: Mesh,
    boundary: dict[str, s.Boundary],
    heat: s.Heat | None,
    closures: s.Closures,
) -> Mistakes:
    """Look for sides with unlike prescribed temperatures that meet, where the
    conducted heat has no limit.
    """
    if isinstance(mesh, MeshFile | MeshLine) or heat is None:
        return
    conductivities = {
        "fluid": closures.conductivity_gas,
        "solid": closures.conductivity_solids,
    }
    found: dict[tuple[KeyPath, str, str, tuple[float, float]], list[str]] = {}
    for phase, conductivity in conductivities.items():
        if conductivity == 0.0:
            continue
        for (name, _), (other, _) in adjacent_sides(mesh):
            unlike = unlike_temperatures(boundary, phase, name, other)
            if unlike is not None:
                key = key_of(boundary, other, phase, "fixed_temperature")
                found.setdefault((key, name, other, unlike), []).append(f"T_{phase}")
    for (key, name, other, (there, here)), fields in found.items():
        yield (
            key,
            f"{here:g} K meets {there:g} K of boundary.{name} in a corner, where "
            f"heat_{name}_W and heat_{other}_W grow without limit as cells get smaller, "
            f"and there is no value of {' and '.join(fields)}; the estimated error "
            "counts there by the distance only. For a heat that means something give "
            "one of both sides a coefficient and ambient, or equal temperatures",
        )
