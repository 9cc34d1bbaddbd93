"""Checks of the gas and the solids that flow through a packed bed: where they enter and
leave, and with which temperature; see `scene.checking`.
"""

from __future__ import annotations

from contbed.packed_bed import scene as s
from contbed.packed_bed.inlets import (
    enters,
    given_velocity,
    key_of,
    role,
    velocity_key,
    velocity_vector,
)
from contbed.packed_bed.schedule_checks import (
    NAMES,
    Boundaries,
    at_each_time,
)
from contbed.scene.checking import Mistakes, See
from contbed.scene.gas import Gas
from contbed.scene.mesh import Mesh, MeshFile
from contbed.scene.toml_lines import KeyPath

ENTERING = "temperature, or fixed_temperature"


@at_each_time
def flow_has_a_way_through(
    mesh: Mesh, gas: Gas | None, boundary: Boundaries, see: See
) -> Mistakes:
    """Check that the flow conditions of the boundaries let the gas enter and leave."""
    velocity = velocity_vector(mesh, boundary, "fluid")
    speed = _about_velocity(boundary, "fluid", see)
    if gas is None or len(velocity) != mesh.dimension:
        return
    given = {
        name: conditions.type
        for name, conditions in boundary.items()
        if conditions.type is not None
    }
    moving = any(velocity)
    for name, kind in given.items():
        path = ("boundary", name, "type")
        if kind == "inlet" and not moving:
            yield path, f"nothing enters: the velocity is 0; {speed}"
            continue
        direction = enters(mesh, velocity, name)
        if kind == "inlet" and direction in (0, -1):
            yield path, f"the velocity does not enter through '{name}'; {speed}"
        if kind == "outlet" and direction == 1:
            yield path, f"the velocity enters through '{name}'; {speed}"
    if isinstance(mesh, MeshFile):
        roles: set[str | None] = set(given.values())
        source = given_velocity(boundary, "fluid")
        if "outlet" in roles and source is not None and source[0] not in given:
            roles.add("inlet")  # by the sign of the velocity, see `role_in_flow`
        sides = list(given)
    else:
        sides = [side for pair in mesh.sides for side in pair]
        roles = {role(mesh, velocity, side, boundary) for side in sides}
        # Roles that contradict the velocity are reported above.
        if any(
            enters(mesh, velocity, name) == {"outlet": 1, "inlet": -1}.get(kind, 2)
            for name, kind in given.items()
        ):
            return
    if not moving or not roles & {"inlet", "outlet", "no_slip", "slip"}:
        return
    for kind, other, verb in (
        ("inlet", "outlet", "enter"),
        ("outlet", "inlet", "leave"),
    ):
        if kind not in roles and (other in roles or not isinstance(mesh, MeshFile)):
            walls = [side for side in sides if given.get(side) in ("no_slip", "slip")]
            at: KeyPath = ("boundary", walls[0], "type") if walls else ("boundary",)
            remedy = f"no boundary is an {kind}; give one type = '{kind}'"
            yield at, f"the fluid cannot {verb}: {remedy}; {speed}"


@at_each_time
def streams_have_a_temperature(
    mesh: Mesh, heat: s.Heat | None, boundary: Boundaries, see: See
) -> Mistakes:
    """Check that every stream that enters has a temperature."""
    if heat is None:
        return
    for phase, what in NAMES.items():
        velocity = velocity_vector(mesh, boundary, phase)
        speed = _about_velocity(boundary, phase, see)
        if len(velocity) != mesh.dimension:
            continue
        conditions = {
            name: c
            for name, b in boundary.items()
            if (c := b.thermal(phase)) is not None
        }
        for name, condition in conditions.items():
            if condition.temperature is None:
                continue
            path = key_of(boundary, name, phase, "temperature")
            if not any(velocity):
                yield (
                    path,
                    f"the {what} does not move, so that nothing enters; use "
                    f"fixed_temperature; {speed}",
                )
            elif enters(mesh, velocity, name) in (0, -1):
                yield path, f"no {what} enters through '{name}'; {speed}"
        if isinstance(mesh, MeshFile):
            known = any(
                c.temperature is not None or c.fixed_temperature is not None
                for c in conditions.values()
            )
            if any(velocity) and not known:
                yield (
                    ("boundary",),
                    f"no boundary gives the temperature of the entering {what}: "
                    f"{ENTERING}",
                )
            continue
        for name in (
            side
            for pair in mesh.sides
            for side in pair
            if enters(mesh, velocity, side) == 1
        ):
            is_wall = (
                phase == "fluid"
                and name in boundary
                and boundary[name].type in ("slip", "no_slip")
            )
            if name not in conditions and not is_wall:
                yield (
                    key_of(boundary, name, phase),
                    f"the {what} enters here without a temperature; give {ENTERING}; "
                    f"{speed}",
                )


def _about_velocity(boundary: Boundaries, phase: str, see: See) -> str:
    """Say where the velocity of a phase stands."""
    if given_velocity(boundary, phase) is None:
        key = "gas.velocity" if phase == "fluid" else "solids.NAME.velocity"
        return f"no boundary gives {key}"
    return f"see {see(velocity_key(boundary, phase))}"
