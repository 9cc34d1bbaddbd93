"""Sides of a built-in mesh through which a stream enters and leaves; those of a mesh
file are not known here.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from contbed.packed_bed import scene as s
from contbed.packed_bed.schedule import PHASES, initial_temperatures
from contbed.scene.mesh import Mesh, MeshFile
from contbed.scene.mesh_checks import axis_of
from contbed.scene.series import VelocitySeries
from contbed.scene.toml_lines import KeyPath, dotted


def given_velocity(
    boundary: Mapping[str, s.Boundary], phase: str
) -> tuple[str, Any] | None:
    """Return the boundary that gives the velocity of a phase, "fluid" or "solid",
    and the value; None at rest.
    """
    for name, table in boundary.items():
        condition = table.condition(phase)
        if condition is not None and condition.velocity is not None:
            return name, condition.velocity
    return None


def key_of(
    boundary: Mapping[str, s.Boundary], name: str, phase: str, *key: str
) -> KeyPath:
    """Return the key of the table of a phase at a boundary, or of a `key` in it."""
    table = boundary.get(name)
    if table is not None and table.temperature is not None:
        return ("boundary", name, "temperature")
    return ("boundary", name, *(() if table is None else table.key(phase)), *key)


def velocities_given(
    boundary: Mapping[str, s.Boundary],
) -> Iterator[tuple[str, str, Any, KeyPath]]:
    """Yield phase, boundary, value and key of each velocity that is given first."""
    for phase in PHASES:
        given = given_velocity(boundary, phase)
        if given is not None:
            name, value = given
            yield phase, name, value, key_of(boundary, name, phase, "velocity")


def velocity_key(boundary: Mapping[str, s.Boundary], phase: str) -> str:
    """Return the key that gives the velocity of a phase; that of all boundaries at
    rest.
    """
    given = given_velocity(boundary, phase)
    if given is None:
        return "boundary"
    return dotted(key_of(boundary, given[0], phase, "velocity"))


def velocity_vector(
    mesh: Mesh, boundary: Mapping[str, s.Boundary], phase: str
) -> tuple[float, ...]:
    """Return the velocity of a phase, "fluid" or "solid", as a vector [m/s]; boundaries
    hold no series.

    A number is perpendicular to its side, into the bed.
    """
    still = (0.0,) * mesh.dimension
    given = given_velocity(boundary, phase)
    if given is None:
        return still
    name, value = given
    if isinstance(value, tuple):
        return value
    if isinstance(mesh, MeshFile):
        return (value, *still[1:])  # until the mesh is known, see `with_vectors`
    for axis, (low, high) in enumerate(mesh.sides):
        if name in (low, high) and value:
            inward = value if name == low else -value
            return (*still[:axis], inward, *still[axis + 1 :])
    return still


def bed_axis(mesh: Mesh, boundary: Mapping[str, s.Boundary]) -> int:
    """Return the direction along which all streams run; without one, that in which
    the mesh is long.
    """
    found: set[int] = set()
    for phase in PHASES:
        name, value = given_velocity(boundary, phase) or ("", 0.0)
        for each in value.values if isinstance(value, VelocitySeries) else (value,):
            if isinstance(each, tuple):
                found |= {k for k, component in enumerate(each) if component}
            elif each and not isinstance(mesh, MeshFile):
                found |= {k for k, ends in enumerate(mesh.sides) if name in ends}
    return found.pop() if len(found) == 1 else axis_of(mesh)


def enters(mesh: Mesh, velocity: tuple[float, ...], side: str) -> int | None:
    """Return 1 if the velocity enters through this side, -1 if it leaves, 0 if it runs
    along.

    None if that is not known.
    """
    if isinstance(mesh, MeshFile):
        return None
    if side == "axis":
        return 0
    for component, (low, high) in zip(velocity, mesh.sides, strict=True):
        if side in (low, high):
            inward = component if side == low else -component
            return (inward > 0) - (inward < 0)
    return None


def role(
    mesh: Mesh,
    velocity: tuple[float, ...],
    side: str,
    boundary: Mapping[str, s.Boundary],
) -> str | None:
    """Return "inlet", "outlet", "slip" or "no_slip": what the scene says, else by
    the sign of the velocity.
    """
    if side in boundary and boundary[side].type is not None:
        return boundary[side].type
    direction = enters(mesh, velocity, side)
    return (
        None if direction is None else {1: "inlet", -1: "outlet", 0: "slip"}[direction]
    )


def inlet_temperature(scene: s.Scene) -> float:
    """Return the temperature of the entering fluid: a prescribed one, on the inlet
    if that is known, else where its velocity is given.
    """
    found = [
        (name, table.gas)
        for name, table in scene.boundary.items()
        if table.gas is not None
    ]
    velocity = velocity_vector(scene.mesh, scene.boundary, "fluid")

    def rank(item: tuple[str, s.PhaseCondition]) -> tuple[bool, bool]:
        name, condition = item
        known = role(scene.mesh, velocity, name, scene.boundary)
        return known != "inlet", condition.velocity is None

    ranked = sorted(found, key=rank)
    for _, condition in ranked:
        for value in (
            condition.temperature,
            condition.fixed_temperature,
            condition.ambient,
        ):
            if value is not None:
                return float(value)  # type: ignore[arg-type]  # frozen: numbers stand in place of series
    if scene.time is None:
        return 300.0
    return 0.5 * sum(initial_temperatures(scene, ["fluid"]))
