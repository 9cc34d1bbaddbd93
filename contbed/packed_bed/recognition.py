"""What makes a packed bed cheap: plug flow on a line, fronts that stay sharp; and
the roles of its boundaries.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import numpy as np

from contbed.errors import SceneError
from contbed.mesh.mesh import Mesh
from contbed.packed_bed import scene as s
from contbed.packed_bed.inlets import (
    given_velocity,
    role,
    velocities_given,
    velocity_vector,
)
from contbed.packed_bed.inside import modes
from contbed.packed_bed.medium import Medium
from contbed.packed_bed.schedule import PHASES, thermal_conditions
from contbed.scene.mesh import (
    MeshAxisymmetric,
    MeshFile,
    MeshLine,
)
from contbed.scene.series import ProfileFile
from contbed.scene.toml_lines import dotted
from contbed.scene.values import with_value


def velocities(scene: s.Scene) -> tuple[Any, Any]:
    """Return the superficial velocities of both phases as vectors on the mesh of the
    scene [m/s].
    """
    fluid, solid = (
        np.array(velocity_vector(scene.mesh, scene.boundary, phase), dtype=float)
        for phase in PHASES
    )
    return fluid, solid


def reduced(scene: s.Scene) -> tuple[s.Scene, float] | None:
    """Return the same scene on a line and its cross-section [m2], where nothing
    varies across the bed.
    """
    mesh = scene.mesh
    if isinstance(mesh, MeshFile | MeshLine) or (
        mesh.cells is not None and mesh.refine
    ):
        return None
    axis = mesh.axis
    if np.any([np.delete(vector, axis) for vector in velocities(scene)]):
        return None
    low, high = mesh.sides[axis]
    for name, table in scene.boundary.items():
        given = table.heated or table.radiation or table.type not in (None, "slip")
        if name not in (low, high) and given:
            return None
    section = float(np.prod(mesh.extents[1:]))
    if isinstance(mesh, MeshAxisymmetric):
        section = np.pi * mesh.radius**2
    ends = {low: "left", high: "right"}
    line = scene.model_copy(
        update={
            "mesh": MeshLine(
                type="line",
                length=mesh.length,
                cells=mesh.cells and mesh.cells[axis],
                graded=mesh.graded,
                refine=mesh.refine,
            ),
            "boundary": {
                ends[name]: _on_a_line(table, axis)
                for name, table in scene.boundary.items()
                if name in ends
            },
        }
    )
    return line, section


def _on_a_line(table: s.Boundary, axis: int) -> s.Boundary:
    """Return the conditions of an end of a bed with its velocities as vectors on a
    line along an axis of the bed.
    """

    def along(condition: s.PhaseCondition) -> s.PhaseCondition:
        velocity = condition.velocity
        if not isinstance(velocity, tuple):
            return condition
        return condition.model_copy(update={"velocity": (velocity[axis],)})

    gas = None if table.gas is None else along(table.gas)
    return table.model_copy(
        update={
            "gas": gas,
            "solids": {name: along(each) for name, each in table.solids.items()},
        }
    )


def tracks_fronts(scene: s.Scene, medium: Medium) -> bool:
    """Return whether fronts stay sharp.

    They do where nothing conducts in a one-dimensional bed at rest that a stream
    enters.
    """
    if (
        scene.time is None
        or scene.heat is None
        or not isinstance(scene.mesh, MeshLine)
        or not medium.constant
    ):
        return False
    fluid, solid = velocities(scene)
    spreads = (
        scene.closures.dispersion is not None or scene.closures.tortuosity is not None
    )
    if modes(scene) or np.any(solid) or spreads:
        return False
    if any(isinstance(scene.initial.given(phase), ProfileFile) for phase in PHASES):
        return False
    tables = scene.boundary.values()
    only_inlet = all(
        condition.fixed_temperature is not None or condition.temperature is not None
        for condition in thermal_conditions(tables, ["fluid"])
    )
    solid_free = not thermal_conditions(tables, ["solid"])
    T = medium.T_fluid_in
    still = (
        not medium.conductivity_fluid(T)
        and not medium.conductivity_solid(T)
        and not scene.region
    )
    return bool(still and only_inlet and solid_free and np.any(fluid))


def with_vectors(scene: s.Scene, mesh: Mesh) -> s.Scene:
    """Return a scene with vectors in place of speeds into planes of a mesh file; a
    speed of the gas into a curved boundary stays.

    Raises
    ------
    SceneError : a curved boundary gives the speed of solids, or of a gas that leaves
    """
    if not isinstance(scene.mesh, MeshFile):
        return scene
    from contbed.packed_bed.flow import constant_normal

    for phase, name, speed, key in velocities_given(scene.boundary):
        if isinstance(speed, tuple):
            continue
        normal = constant_normal(mesh, name)
        if normal is not None:
            vector = tuple((-speed * normal + 0.0).tolist())
            boundary = with_value(scene.boundary, key[1:], vector)
            scene = scene.model_copy(update={"boundary": boundary})
        elif phase == "solid" or speed < 0.0:
            what = "solids move as one body" if phase == "solid" else "the gas leaves"
            raise SceneError(
                f"{scene.origin.at(key)}: {dotted(key)}: '{name}' is curved, and "
                f"{what}: give a list, the vector of the velocity in the mesh"
            )
    return scene


def curved_inlet(scene: s.Scene) -> str:
    """Return the boundary with the speed of the gas into a curved boundary, of a scene
    `with_vectors`; empty if none has.
    """
    name, speed = given_velocity(scene.boundary, "fluid") or ("", 0.0)
    if not isinstance(scene.mesh, MeshFile) or isinstance(speed, tuple):
        return ""
    return name if speed else ""


def role_in_flow(scene: s.Scene, mesh: Mesh, name: str, velocity: Any) -> str:
    """Return "inlet", "outlet", "slip" or "no_slip" of one boundary."""
    given = role(scene.mesh, tuple(velocity.tolist()), name, scene.boundary)
    if given is not None:
        return given
    if not np.any(velocity):  # at rest
        return "slip"
    if (
        mesh.axisymmetric
        and np.abs(
            mesh.skfem.p[0, mesh.skfem.facets[:, mesh.skfem.boundaries[name]]]
        ).max()
        < 1e-12
    ):
        return "slip"
    entered = curved_inlet(scene)
    if name == entered:
        return "inlet"
    if entered:
        raise SceneError(
            f"{scene.origin.name}: boundary.{name}: the gas enters through "
            f"'{entered}', which is curved, so that its way is not known: say "
            f'[boundary.{name}] type = "outlet", "wall" or "no_slip"'
        )
    from contbed.packed_bed.flow import (
        constant_normal,
        has_axial_planes,
        passes_along,
    )

    # both sides of a duct may have one name
    if passes_along(mesh, name, velocity):
        return "slip"
    normal = constant_normal(mesh, name)
    said = any(table.type == "outlet" for table in scene.boundary.values())
    if normal is None and said and has_axial_planes(mesh, name):
        return "slip"
    across = (
        0.0
        if normal is None
        else float(normal @ velocity) / max(float(np.linalg.norm(velocity)), 1e-300)
    )
    if abs(across) < 0.5:
        raise SceneError(
            f"{scene.origin.name}: boundary.{name} is neither along nor across the "
            f'flow; say [boundary.{name}] type = "inlet", "outlet" or "no_slip"; flow '
            "along a wall without friction is solved where the wall consists of planes "
            "along the coordinate axes"
        )
    return "inlet" if across < 0 else "outlet"


def roles_in_flow(scene: s.Scene, mesh: Mesh) -> dict[str, str]:
    """Return "inlet", "outlet", "slip" or "no_slip" of each boundary."""
    velocity = velocities(scene)[0]
    return {name: role_in_flow(scene, mesh, name, velocity) for name in mesh.boundaries}


def is_plug_flow(scene: s.Scene, mesh: Mesh) -> bool:
    """Return whether the velocity is that of the inlet everywhere: where nothing
    sticks to a wall, no wall is in the way, and the outlet is across the flow.

    Raises
    ------
    SceneError : a slip wall is oblique to the flow, or it is not clear where the gas
        leaves
    """
    roles, velocity = roles_in_flow(scene, mesh), velocities(scene)[0]
    if "no_slip" in roles.values():
        return False
    typed = {name for name, table in scene.boundary.items() if table.type is not None}
    if not np.any(velocity) or not (typed or isinstance(scene.mesh, MeshFile)):
        return True
    from contbed.packed_bed.flow import is_across, is_along, slip_axes

    file = scene.origin.name
    walls = [name for name, kind in roles.items() if kind == "slip"]
    # a radial flow slows down with the radius
    if (mesh.axisymmetric and velocity[0]) or curved_inlet(scene):
        with _of_file(file):
            for name in walls:
                slip_axes(mesh, name)
        return False
    beside = [
        name
        for name, kind in roles.items()
        if kind == "outlet" and name in typed and not is_across(mesh, name, velocity)
    ]
    unsaid = [
        name for name, kind in roles.items() if kind == "outlet" and name not in typed
    ]
    if beside and unsaid:
        raise SceneError(
            f"{file}: boundary.{unsaid[0]}: the flow meets it, and the outlet is "
            f'boundary.{beside[0]}: say [boundary.{unsaid[0]}] type = "outlet", '
            '"no_slip" or "symmetry"'
        )
    with _of_file(file):
        along = [is_along(mesh, name, velocity) for name in walls]
    return all(along) and not beside


def require_walls_along_solids(scene: s.Scene, mesh: Mesh) -> None:
    """Require that particles, which move alike everywhere, pass through no wall.

    Raises
    ------
    SceneError : a wall is neither along nor across their way
    """
    velocity = velocities(scene)[1]
    if not np.any(velocity):
        return
    if mesh.axisymmetric and velocity[0]:
        raise SceneError(
            f"{scene.origin.name}: the particles move along the axis of a round bed only, "
            "as they take the same room everywhere; at a radius they would not"
        )
    # sides of other meshes are along or across their axes
    if not isinstance(scene.mesh, MeshFile):
        return
    from contbed.packed_bed.flow import is_across, passes_along

    for name, table in scene.boundary.items():
        wall = table.type in ("no_slip", "slip") or table.whole or table.radiation
        if not wall or name not in mesh.boundaries:
            continue
        if not passes_along(mesh, name, velocity) and not is_across(
            mesh, name, velocity
        ):
            raise SceneError(
                f"{scene.origin.at(('boundary', name))}: boundary.{name}: the particles "
                "move alike everywhere and would pass through this wall, which is "
                "neither along nor across their way: cut the mesh to a bed of one "
                'section, or take model = "two_fluid", whose particles flow around '
                "walls"
            )


@contextmanager
def _of_file(file: str) -> Iterator[None]:
    """Name the file of a scene in its mistakes."""
    try:
        yield
    except SceneError as error:
        raise SceneError(f"{file}: {error}") from error
