"""Closures of a two-fluid model: their keys in a scene, and the arguments that the
model gives them.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from contbed import closures
from contbed.closures.binding import BoundClosure, bind, named
from contbed.errors import SceneError
from contbed.scene.mesh import MeshFile
from contbed.scene.tables import Closure
from contbed.two_fluid import scene as t

if TYPE_CHECKING:
    from contbed.materials.constants import Constants
    from contbed.two_fluid.simulation import Simulation

ABSENT = "none"
KINDS = {
    "drag": "drag",
    "radial_distribution": "radial_distribution",
    "granular_pressure": "granular_pressure",
    "granular_viscosity": "granular_viscosity",
    "granular_bulk_viscosity": "granular_bulk_viscosity",
    "granular_conductivity": "granular_conductivity",
    "granular_dissipation": "granular_dissipation",
    "effective_restitution": "effective_restitution",
    "friction_pressure": "granular_friction",
    "friction_viscosity": "granular_friction_viscosity",
    "wall_drag": "wall_drag",
    "wall_pressure": "wall_pressure",
    "wall_viscosity": "wall_viscosity",
}
"""Kinds of the closures of the flow by the keys of [closures]."""

HEAT_KINDS = {"nusselt": "nusselt", "conductivity_bed": "conductivity"}
"""Kinds of the closures of heat by the keys of [closures]."""

# solids fraction below which the range use of closures is not recorded
MIN_REPORTED_FRACTION = 1e-6
# cells across a filter, of which the resolved scales are free of the scheme's own
# diffusion
FILTER_CELLS = 2.0
_THEORY = ("eps_s", "g0", "e")
GIVES: dict[str, tuple[str, ...]] = {
    "drag": ("Re", "eps", "d_p", "mu"),
    "radial_distribution": ("eps_s", "eps_max"),
    "granular_pressure": _THEORY,
    "granular_viscosity": (*_THEORY, "kinetic"),
    "granular_bulk_viscosity": _THEORY,
    "granular_conductivity": (*_THEORY, "kinetic"),
    "granular_dissipation": _THEORY,
    "effective_restitution": ("e", "sliding_friction"),
    "granular_friction": ("eps_s", "eps_max", "eps_min", "strength"),
    "granular_friction_viscosity": ("p_friction", "angle", "shear_rate"),
    "wall_drag": ("wall_froude",),
    "wall_pressure": ("wall_froude",),
    "wall_viscosity": ("wall_froude",),
    "nusselt": ("Re", "Pr", "eps", "T", "d_p", "k_fluid"),
    "conductivity": ("k_fluid", "k_solid", "eps", "T", "d_p"),
}
"""The arguments that closures of each kind can have; kernels call the closures with them in this order."""

FROM_CELLS = {
    "drag": ("filter_froude", "Re_t"),
    "granular_pressure": ("filter_froude",),
    "granular_viscosity": ("filter_froude", "terminal_froude"),
}
"""Parameters by kind that follow from cells and particles where a scene does not give them."""

Bound = Mapping[str, BoundClosure | None]


def bound(scene: t.TwoFluidScene) -> Bound:
    """Bind the closures of a scene by kind, None for what is absent."""
    base = scene.origin.base
    chosen = {kind: getattr(scene.closures, key) for key, kind in KINDS.items()}
    chosen |= {kind: filtered(chosen[kind], kind, scene) for kind in FROM_CELLS}
    found = {
        kind: None if spec == ABSENT else bind(spec, kind, GIVES[kind], base)
        for kind, spec in chosen.items()
    }
    if scene.heat is not None:
        for key, kind in HEAT_KINDS.items():
            if named(spec := getattr(scene.closures, key)):
                found[kind] = bind(spec, kind, GIVES[kind], base)
        from contbed.two_fluid.heat import wall_laws as walls

        for place, spec in walls.coefficients(scene).items():
            if named(spec):
                found[walls.kind_at(place)] = bind(spec, walls.KIND, walls.GIVES, base)
    return found


def filtered(spec: Any, kind: str, scene: t.TwoFluidScene) -> Any:
    """Return the closure with what it takes of FROM_CELLS, if it is one for cells that
    do not resolve clusters.

    Filter size FILTER_CELLS times the square root of a cell's area, in a box the cube
    root of its volume.

    Raises
    ------
    SceneError : the cells of a mesh file have no common size, so that the scene has to
        give the number
    """
    missing = lacks(spec, kind)
    if not missing:
        return spec
    given = spec.model_extra or {} if isinstance(spec, Closure) else {}
    found = {parameter: _OF_SCENE[parameter](scene, kind) for parameter in missing}
    return Closure(name=full_name(spec, kind), **given, **found)


def lacks(spec: Any, kind: str) -> tuple[str, ...]:
    """Return the parameters of FROM_CELLS that a closure takes and its scene does
    not give.
    """
    given = spec.model_extra or {} if isinstance(spec, Closure) else {}
    return tuple(key for key in takes(spec, kind) if key not in given)


def takes(spec: Any, kind: str) -> tuple[str, ...]:
    """Return the parameters of FROM_CELLS that a closure takes."""
    name = full_name(spec, kind)
    taken = closures.sheet(name).arguments if name in closures.names(kind) else ()
    return tuple(key for key in FROM_CELLS[kind] if key in taken)


def full_name(spec: Any, kind: str) -> str:
    """Name of a closure with its kind."""
    name = spec.name if isinstance(spec, Closure) else str(spec)
    return name if name.startswith(f"{kind}_") else f"{kind}_{name}"


def is_filtered_stress(closures: t.Closures) -> bool:
    """Whether pressure or viscosity of the particles are those of cells that do not
    resolve clusters.
    """
    kinds = ("granular_pressure", "granular_viscosity")
    return any(
        full_name(getattr(closures, kind), kind) == f"{kind}_igci" for kind in kinds
    )


def conducts(closures: t.Closures, two_fluid: t.TwoFluid) -> bool:
    """Whether any heat is conducted."""
    return (
        closures.conductivity_bed is not None
        or two_fluid.conductivity_gas + two_fluid.conductivity_solids > 0
    )


def terminal_velocity(gravity: float, fluid: Constants, solid: t.Solid) -> float:
    """Stokes' terminal velocity of a particle [m/s]."""
    return (
        gravity
        * solid.diameter**2
        * (solid.density - fluid.density)
        / (18.0 * fluid.viscosity)
    )


def _filter_froude(scene: t.TwoFluidScene, kind: str) -> float:
    """Filter size times gravity over the square of the terminal velocity [-]."""
    if isinstance(scene.mesh, MeshFile) or scene.mesh.cells is None:
        key = next(key for key, of in KINDS.items() if of == kind)
        name = full_name(getattr(scene.closures, key), kind)
        where = scene.origin.at(("closures", key))
        text = (
            f'cells of unknown size; give the filter: {{ name = "{name}", '
            f"filter_froude = ... }}"
        )
        raise SceneError(f"{where}: closures.{key}: {text}")
    cells = np.atleast_1d(scene.mesh.cells) * 2**scene.mesh.refine
    size = float(np.prod(_extents(scene.mesh) / cells) ** (1.0 / len(cells)))
    return (
        FILTER_CELLS * size * scene.two_fluid.gravity / _terminal_velocity(scene) ** 2
    )


def _terminal_velocity(scene: t.TwoFluidScene) -> float:
    return terminal_velocity(scene.two_fluid.gravity, scene.fluid, scene.solid)


def _terminal_reynolds(scene: t.TwoFluidScene, _: str) -> float:
    return (
        _terminal_velocity(scene)
        * scene.fluid.density
        * scene.solid.diameter
        / scene.fluid.viscosity
    )


def _terminal_froude(scene: t.TwoFluidScene, _: str) -> float:
    return _terminal_velocity(scene) ** 2 / (
        scene.two_fluid.gravity * scene.solid.diameter
    )


_OF_SCENE = {
    "filter_froude": _filter_froude,
    "Re_t": _terminal_reynolds,
    "terminal_froude": _terminal_froude,
}


def _extents(mesh: Any) -> Any:
    """Length, height or radius, width of a built-in mesh, as many as it has
    axes [m].
    """
    names = ("length", "radius", "width", "height")
    return np.array(
        [value for name in names if (value := getattr(mesh, name, None)) is not None]
    )


def constants(scene: t.TwoFluidScene) -> dict[str, Any]:
    """Arguments of closures that do not change in a run."""
    fluid, solid = scene.fluid, scene.solid
    found: dict[str, Any] = {
        "d_p": solid.diameter,
        "mu": fluid.viscosity,
        "e": solid.restitution,
        "eps_max": solid.packing_limit,
        "eps_min": solid.friction.start,
        "strength": solid.friction.strength,
        "angle": solid.friction.angle,
        "kinetic": 1.0,
    }
    if solid.sliding_friction is not None:
        found["sliding_friction"] = solid.sliding_friction
    if scene.heat is not None:
        k, heat_capacity = fluid.conductivity, fluid.heat_capacity
        assert k is not None and heat_capacity is not None
        found |= {
            "k_fluid": k,
            "k_solid": solid.conductivity,
            "Pr": heat_capacity * fluid.viscosity / k,
        }
        from contbed.two_fluid.heat import wall_laws as walls

        found |= walls.constants(scene)
    return found


def dissipative_restitution(scene: t.TwoFluidScene) -> float:
    """Restitution that the dissipation has: that of the particles, or the effective
    one, which stands for friction.
    """
    chosen = scene.closures.effective_restitution
    if chosen == ABSENT:
        return scene.solid.restitution
    kind = "effective_restitution"
    return float(bind(chosen, kind, GIVES[kind], scene.origin.base)(**constants(scene)))


def known(bed: Simulation, scene: t.TwoFluidScene) -> dict[str, Any]:
    """Arguments of closures at the present state, where there are particles."""
    from contbed.two_fluid.properties import density_ratio

    there = bed.state.eps_s > MIN_REPORTED_FRACTION
    if not there.any():
        there[:] = True
    s, m = bed.state.eps_s[there], bed.model.materials
    slip = np.linalg.norm(bed.state.u_gas - bed.state.u_solid, axis=1)[there]
    slip *= np.broadcast_to(density_ratio(bed.state.energy), there.shape)[there]
    found = {
        "eps_s": s,
        "eps": 1.0 - s,
        "Re": (1.0 - s) * m.rho_gas * slip * m.d_p / m.mu_gas,
        "g0": bed.state.properties.rheology.g0[there],
        "p_friction": bed.state.properties.rheology.p_friction[there],
        "shear_rate": bed.shear_rate()[there] if bed.model.closures.sheared else 0.0,
        **constants(scene),
    }
    if bed.state.energy is not None:
        found["T"] = bed.state.energy.T_solid[there]
        found |= _at_walls(bed, scene, there)
    if bed.model.closures.wall_froude is not None:
        found["wall_froude"] = bed.model.closures.wall_froude[there]
    return found


def _at_walls(bed: Simulation, scene: t.TwoFluidScene, there: Any) -> dict[str, Any]:
    """Arguments of closures of walls at the present state."""
    from contbed.two_fluid.heat import wall_laws as walls

    energy, heat = bed.state.energy, bed.model.heat
    assert energy is not None and heat is not None
    if not heat.physics.wall_laws or heat.physics.conductivity is None:
        return {}
    s, T = bed.state.eps_s[there], energy.T_solid[there]
    k = heat.physics.conductivities(s, energy.T_gas[there], T).sum(axis=0)
    return walls.local(s, T, k, scene)
