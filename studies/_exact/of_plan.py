"""The closed form of a plan, where there is one."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from contbed.packed_bed.plan import Plan
from contbed.scene.mesh import MeshLine
from studies._exact.finite_length import finite_length

Profile = Callable[[Any], dict[str, Any]]


def exact_profile(plan: Plan) -> Profile | None:
    """Return the closed form of a plan, from positions [m] to the theta columns of the
    profile.

    None where no closed form applies.
    """
    if plan.scene.kind != "packed_bed":
        return None
    arguments = closed_form_arguments(plan)
    if arguments is None:
        return None
    inlets = [
        _only_fixed(plan.solved, phase, name) for phase, name in _inlets(plan).items()
    ]
    backwards, cooled = plan.velocity[0] < 0, inlets[0] > inlets[1]  # type: ignore[operator]

    def profile(x: Any) -> dict[str, Any]:
        pair = finite_length(arguments["length"] - x if backwards else x, **arguments)
        names = ("theta_fluid [1]", "theta_solid [1]")
        return {
            name: 1.0 - value if cooled else value
            for name, value in zip(names, pair, strict=True)
        }

    return profile


def closed_form_arguments(plan: Plan) -> dict[str, Any] | None:
    """Return the arguments of `finite_length` for a plan, along the
    fluid's stream.

    None where it does not apply. It applies to steady, linear heat on a line where both
    phases enter at fixed, different temperatures and leave freely.
    """
    scene, medium, mesh = plan.solved, plan.medium, plan.solved.mesh
    if (
        scene.heat is None
        or scene.radiation is not None
        or scene.time is not None
        or not medium.constant
    ):
        return None
    sources = [
        region.heat_source(phase)
        for region in scene.region.values()
        for phase in ("fluid", "solid")
    ]
    if not isinstance(mesh, MeshLine) or any(sources):
        return None
    T_fluid, T_solid = (
        _only_fixed(scene, phase, name) for phase, name in _inlets(plan).items()
    )
    if T_fluid is None or T_solid is None or T_fluid == T_solid:
        return None
    T, scale = medium.T_fluid_in, medium.mass_flux_scale()
    u, u_solid = float(plan.velocity[0]), float(plan.velocity_solid[0])
    speed = medium.relative_speed(u, u_solid)
    along, _ = medium.dispersion(T, speed) or (0.0, 0.0)
    add_fluid, add_solid, cross = medium.tortuosity(T) or (0.0, 0.0, 0.0)
    exchange = float(medium.exchange(T, speed))
    d_fluid = float(medium.conductivity_fluid(T)) + add_fluid + float(along)
    d_solid = float(medium.conductivity_solid(T)) + add_solid
    if not (u and exchange and (u_solid or d_solid)) or (
        cross and cross**2 >= d_fluid * d_solid
    ):
        return None
    return {
        "length": mesh.length,
        "flux_fluid": scale * float(medium.fluid.heat_capacity(T)) * abs(u),
        "flux_solid": float(medium.solid.density(T) * medium.solid.heat_capacity(T))
        * u_solid
        * np.sign(u),
        "d_fluid": d_fluid,
        "d_solid": d_solid,
        "ha": exchange,
        "d_cross": cross,
    }


def _inlets(plan: Plan) -> dict[str, str]:
    """Return the end of a line where each phase enters.

    A solid at rest has its temperature fixed where the fluid enters.
    """
    u, u_solid = plan.velocity[0], plan.velocity_solid[0]
    return {
        "fluid": "left" if u > 0 else "right",
        "solid": "left" if (u_solid or u) > 0 else "right",
    }


def _only_fixed(scene: Any, phase: str, inlet: str) -> float | None:
    """Return the temperature of a phase that is fixed at its inlet and free
    everywhere else.
    """
    conditions = {name: table.thermal(phase) for name, table in scene.boundary.items()}
    given = {
        name: condition
        for name, condition in conditions.items()
        if condition is not None
    }
    return given[inlet].fixed_temperature if list(given) == [inlet] else None
