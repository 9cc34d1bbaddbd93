"""Whether a bed whose sides exchange a little heat may be solved in one dimension,
without its sides.

The heat through the sides is what the streams gain, so that what leaves on average
changes by at most

    error = sum over sides and phases of h (L/e) / min(G c, S c_s)            side with a coefficient h [W/m2/K]
    error = sum over sides and phases of |q| (L/e) / (min(G c, S c_s) dT)     side with a flux q [W/m2]

over the span dT of all given temperatures, ambient ones included: with G c and S c_s
the heat capacity flows of the fluid and of moving solids [W/m2/K], L/e the area of a
side over the cross-section, 2 L/R for a round bed. The first holds as no temperature
lies outside of those given (maximum principle), the second by the balance alone.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from contbed.packed_bed import scene as s
from contbed.packed_bed.medium import Medium
from contbed.packed_bed.recognition import reduced, velocities
from contbed.packed_bed.schedule import temperatures_given, thermal_conditions
from contbed.plan_text import percent
from contbed.scene.mesh import MeshAxisymmetric, MeshFile, MeshLine


def on_a_line(scene: s.Scene) -> tuple[s.Scene, float] | None:
    """Return the scene on a line without its sides, and its cross-section [m2]; None
    where it has no line.
    """
    return reduced(without_sides(scene))


def lines_of(
    flows: Sequence[s.Scene], medium: Medium, changes: bool
) -> tuple[list[tuple[s.Scene, float] | None], str]:
    """Return the scene of each flow on a line, None where it has none, and the reason
    or what a line would miss.

    `changes` says that values change with time, for which no error is predicted. Sides
    that exchange heat are left out only where solver.accuracy is stated.
    """
    scene, lines = flows[0], [reduced(each) for each in flows]
    if not scene.solver.reduce:
        return [None for _ in flows], ""
    if all(lines):
        return lines, "plug flow between adiabatic walls varies along the bed only"
    error = None if changes else error_without_sides(scene, medium)
    if error is None:
        return lines, ""
    accuracy = scene.solver.accuracy
    text = (
        f"heat through the sides changes the outlet by at most {percent(error)} of "
        "the temperature span"
    )
    if accuracy is None:
        return lines, f"{text}; the sides are resolved, as solver.accuracy is not given"
    limit = f"solver.accuracy = {100.0 * accuracy:g} %"
    if error > accuracy:
        return lines, f"{text}, above {limit}: the sides are resolved"
    return [on_a_line(scene)], f"{text}, within {limit}: solved in 1-D"


def without_sides(scene: s.Scene) -> s.Scene:
    """Return the scene of a built-in mesh with sides that neither exchange heat nor
    resist the flow.
    """
    mesh = scene.mesh
    if isinstance(mesh, MeshFile | MeshLine):
        return scene
    ends = mesh.sides[mesh.axis]
    kept = {
        name: table
        for name, table in scene.boundary.items()
        if name in ends or not _leaves_off(table)
    }
    return scene.model_copy(update={"boundary": kept})


def error_without_sides(scene: s.Scene, medium: Medium) -> float | None:
    """Return the largest error of the mean temperatures that leave, over the span; None
    where it has no bound.

    It has none without flow, with sources, radiation, cross conduction, or a side of
    given temperature.
    """
    mesh = scene.mesh
    if (
        isinstance(mesh, MeshFile | MeshLine)
        or scene.heat is None
        or scene.radiation is not None
        or scene.region
    ):
        return None
    if scene.closures.tortuosity is not None or on_a_line(scene) is None:
        return None
    fluid, solid = velocities(scene)
    carried = _carried(
        medium, float(np.linalg.norm(fluid)), float(np.linalg.norm(solid))
    )
    span = _span(scene)
    if carried is None or span == 0.0:
        return None
    axis, relative = mesh.axis, float(np.linalg.norm(fluid - solid))
    extents = mesh.extents
    exchanged = given = 0.0
    for k, names in enumerate(mesh.sides):
        share = (
            (2.0 if isinstance(mesh, MeshAxisymmetric) else 1.0)
            * extents[axis]
            / extents[k]
        )
        tables = [
            scene.boundary[name]
            for name in names
            if name in scene.boundary and k != axis
        ]
        for condition in thermal_conditions(tables):
            if condition.heat_flux is not None:
                given += abs(float(condition.heat_flux)) * share / (carried * span)  # type: ignore[arg-type]  # frozen
            else:
                wall = medium.wall(
                    condition.coefficient, medium.T_fluid_in, lambda density: relative
                )
                exchanged += float(wall) * share / carried
    everywhere = thermal_conditions(scene.boundary.values())
    fluxes = given > 0.0 or any(condition.heat_flux for condition in everywhere)
    return None if exchanged and fluxes else exchanged + given


def _leaves_off(table: s.Boundary) -> bool:
    """Return whether a side exchanges heat by coefficients or fluxes alone."""
    if table.radiation is not None or table.type not in (None, "slip"):
        return False
    return all(
        each.coefficient is not None or each.heat_flux is not None
        for each in thermal_conditions([table])
    )


def _carried(medium: Medium, fluid: float, solid: float) -> float | None:
    """Return the smaller heat capacity flow of the streams [W/m2/K]; None where
    nothing flows.
    """
    pairs = zip(medium.capacities, (fluid, solid), strict=True)
    return min((capacity * speed for capacity, speed in pairs if speed), default=None)


def _span(scene: s.Scene) -> float:
    """Return the span of all temperatures that a scene gives [K]."""
    found = temperatures_given(scene)
    return float(max(found) - min(found)) if found else 0.0
