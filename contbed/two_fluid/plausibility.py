"""What a two-fluid run cannot have found: speeds, pressures and temperatures beyond
all that its scene gives.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from contbed.errors import ConvergenceError
from contbed.two_fluid import scene as t
from contbed.two_fluid import wall_shear
from contbed.two_fluid.boundary import GIVEN, OUTLET
from contbed.two_fluid.conditions import Inlet, Outlet, SolidAtInlet, Wall, of_kind
from contbed.two_fluid.end_pressure import end_faces
from contbed.two_fluid.heat.checks import MAX_TEMPERATURE
from contbed.two_fluid.solids_pressure import FrictionTable, frictional_pressure
from contbed.two_fluid.vessel import depth

if TYPE_CHECKING:
    from contbed.two_fluid.simulation import Simulation

DOUBTED, REFUSED = 1.5, 10.0  # factors on a bound beyond which a run warns, and fails
# speed of particles that expand into an empty space, over the root of their granular
# temperature
EXPANSION = 3.0
# frictional pressure at the start over the weight, and change of the solids fraction,
# above which a bed that expands warns
LAID, SETTLED = 2.0, 0.002
REMEDY = (
    "the run is not stable: leave out time.step or lower it, lower time.courant, "
    "or refine the mesh"
)


def largest_speed(scene: t.TwoFluidScene, bed: Simulation) -> float:
    """Return a bound of the speed of particles [m/s].

    It is the sum of free fall from the height of the vessel, or during the whole run
    where bottom and top are periodic, the speed of what enters
    between particles, that of the start and of moving walls, that of particles which
    expand by their granular temperature, and that of gas which a difference of the
    pressures outside drives.
    """
    grid, edge, start = bed.model.grid, bed.model.edge, scene.initial
    inlets = of_kind(scene.boundary, Inlet).values()
    height = float(np.ptp(grid.centres[:, -1]))
    blown = max((part.gas.velocity for part in inlets), default=0.0) / (
        1.0 - scene.solid.packing_limit
    )
    area = grid.geometry.area[grid.interior :]
    entered, left = (
        float(area[edge.gas.kind == kind].sum()) for kind in (GIVEN, OUTLET)
    )
    narrowing = max(1.0, entered / left) if left > 0.0 else 1.0
    entering = [part.solid for part in inlets]
    fed = max(
        (solid.velocity or _fed(solid, scene.solid.density) for solid in entering),
        default=0.0,
    )
    begun = max(
        abs(value)
        for part in start.parts
        for value in (part.gas.velocity or 0.0, part.solid.velocity or 0.0)
    )
    moving = of_kind(scene.boundary, Wall).values()
    walls = max((abs(v) for part in moving for v in part.velocity), default=0.0)
    at_start = (part.solid.granular_temperature or 0.0 for part in start.parts)
    theta = max(*at_start, *(solid.granular_temperature for solid in entering), 0.0)
    driven = (2.0 * _pressure_outside(scene) / scene.fluid.density) ** 0.5
    fall = (2.0 * scene.two_fluid.gravity * height) ** 0.5
    if not len(end_faces(grid, -1)):
        fall = scene.two_fluid.gravity * scene.time.end
    given = (
        narrowing * blown * _expansion(scene)
        + fed
        + begun
        + walls
        + abs(start.shear) * height
    )
    return float(fall + given + EXPANSION * theta**0.5 + driven)


def _fed(solid: SolidAtInlet, density: float) -> float:
    """Speed of the particles that an inlet feeds [m/s]."""
    return (
        (solid.mass_flux or 0.0) / (density * solid.volume_fraction)
        if solid.volume_fraction > 0.0
        else 0.0
    )


def given_temperatures(scene: t.TwoFluidScene) -> list[float]:
    """Return the temperatures [K] that the scene gives to initial fields and
    boundaries.
    """
    streams = of_kind(scene.boundary, Inlet).values()
    values = [part.outside for part in of_kind(scene.boundary, Wall).values()]
    for part in (*scene.initial.parts, *streams):
        values += [part.gas.temperature, part.solid.temperature]
    return [value for value in values if value is not None]


def _expansion(scene: t.TwoFluidScene) -> float:
    """Ratio of the highest to the lowest temperature, by which an ideal gas expands."""
    given = given_temperatures(scene)
    expands = scene.heat is not None and scene.gas.density_law == "ideal_gas"
    return max(given) / min(given) if given and expands else 1.0


def largest_pressure_drop(
    scene: t.TwoFluidScene, bed: Simulation, speed: float
) -> float:
    """Return a bound of the pressure drop [Pa] that a flow keeps up.

    It is the weight of both phases, the dynamic pressure, friction of the gas on the
    walls and what outlets give.
    """
    grid, materials = bed.model.grid, bed.model.materials
    height = float(np.ptp(grid.spans))
    solids = depth(grid, bed.state.eps_s) / height * materials.rho_solid
    weight = (solids + materials.rho_gas) * scene.two_fluid.gravity * height
    width = min(
        (float(np.ptp(grid.middles[:, k])) for k in range(grid.dimension - 1)),
        default=np.inf,
    )
    friction = 12.0 * materials.mu_gas * speed * height / width**2
    dynamic = 0.5 * (solids + materials.rho_gas) * speed**2
    return weight + dynamic + friction + _pressure_outside(scene)


def _pressure_outside(scene: t.TwoFluidScene) -> float:
    """Return the largest difference of the pressures at outlets [Pa]."""
    outlets = of_kind(scene.boundary, Outlet).values()
    outside = [part.gas.pressure for part in outlets]
    return max(outside) - min(outside) if outside else 0.0


def require_possible(scene: t.TwoFluidScene, bed: Simulation, speed: float) -> None:
    """Check the state of a run.

    Raises
    ------
    ConvergenceError : particles far faster than `speed` [m/s], or temperatures that
        nothing in the scene can give
    """
    from contbed.two_fluid.results import fastest

    now = f"t = {bed.state.time:.6g} s, step {bed.state.steps}"
    if (found := fastest(bed)) > REFUSED * speed:
        text = (
            f"particles of {found:.3g} m/s, while free fall and what enters give at "
            f"most about {speed:.3g} m/s"
        )
        raise ConvergenceError(f"{now}: {text}; {REMEDY}")
    if bed.state.energy is None or scene.heat is None:
        return
    low, high = _temperature_bounds(scene)
    there = bed.state.eps_s > 1e-6
    for name, values in (
        ("T_gas", bed.state.energy.T_gas),
        ("T_solid", bed.state.energy.T_solid[there]),
    ):
        if len(values) and not (values.min() >= low and values.max() <= high):
            text = (
                f"{name} from {values.min():.5g} to {values.max():.5g} K, possible "
                f"are {low:.5g} to {high:.5g} K"
            )
            raise ConvergenceError(
                f"{now}: {text}; check heat_flux of the walls; {REMEDY}"
            )


def _temperature_bounds(scene: t.TwoFluidScene) -> tuple[float, float]:
    """Temperatures [K] that nothing in the scene can pass: those given and their
    span; with sources any above 0 K.
    """
    given = given_temperatures(scene)
    sources = any(part.heat_flux for part in of_kind(scene.boundary, Wall).values())
    if sources or not given:
        return 0.0, MAX_TEMPERATURE
    span = max(max(given) - min(given), 0.1 * max(given))
    return max(0.0, min(given) - span), max(given) + span


def _slow_discharge(scene: t.TwoFluidScene, bed: Simulation) -> Iterator[str]:
    """Yield warnings of outlets through which particles that rub flow out like honey."""
    grid, friction = bed.model.grid, bed.state.properties.rheology.p_friction
    if scene.closures.friction_viscosity != "friction_viscosity_newtonian":
        return
    for name in of_kind(scene.boundary, Outlet):
        faces = grid.boundaries[name]
        edges = faces - grid.interior
        rubbing = friction[bed.model.boundary_cells[edges]] > 0.0
        if (bed.model.open_faces[edges] * rubbing).any():
            yield (
                f"{scene.origin.place(('boundary', name))}: particles rub in the cells "
                "at this outlet, and with friction_viscosity_newtonian they flow out "
                "like honey, several times too slowly; for a discharge choose "
                "closures.friction_viscosity = 'friction_viscosity_schaeffer'"
            )


def _laid_too_densely(scene: t.TwoFluidScene, bed: Simulation) -> Iterator[str]:
    """Yield a warning of a stationary bed whose friction was more than its weight at
    the start, so that it has expanded.
    """
    given = [
        (part.solids[name].volume_fraction or 0.0, name)
        for part in scene.initial.parts
        for name in part.solids
    ]
    gravity, rho = scene.two_fluid.gravity, scene.solid.density
    volume, rubs = (
        bed.model.grid.geometry.volume,
        bed.state.properties.rheology.p_friction > 0.0,
    )
    solids = bed.state.eps_s * volume
    if not given or gravity == 0.0 or solids[rubs].sum() <= 0.5 * solids.sum():
        return
    (laid, name), now = max(given), solids[rubs].sum() / volume[rubs].sum()
    weight = depth(bed.model.grid, bed.state.eps_s) * rho * gravity
    table = FrictionTable(*bed.model.closures.packing)
    pressure = rho * frictional_pressure(table, laid)[0]
    if pressure > LAID * weight and laid - now > SETTLED:
        yield (
            f"initial.solids.{name}.volume_fraction = {laid:g}: particles laid so densely "
            f"push each other apart by {pressure:.3g} Pa, while the bed weighs "
            f"{weight:.3g} Pa: it has expanded to {now:.4f}; begin with that, or for a "
            f"bed that stays give a larger solids.{name}.packing_limit"
        )


def judge(
    scene: t.TwoFluidScene, bed: Simulation, rows: Mapping[str, Any], speed: float
) -> list[str]:
    """Return warnings on what a run found.

    Raises
    ------
    ConvergenceError : a pressure drop far beyond what weight and flow can give
    """
    found = []
    fastest = float(np.max(rows["u_solid_max [m/s]"]))
    if fastest > DOUBTED * speed:
        text = (
            f"particles of {fastest:.3g} m/s, while free fall and what enters give "
            f"at most about {speed:.3g} m/s"
        )
        found.append(f"{text}; {REMEDY}")
    found += _slow_discharge(scene, bed)
    found += _laid_too_densely(scene, bed)
    height = float(np.ptp(bed.model.grid.spans))
    # to start gas and bed needs more pressure than to keep them up
    if scene.two_fluid.gravity > 0.0 and bed.state.time * speed > height:
        late = rows["t [s]"] >= 0.5 * rows["t [s]"][-1]
        drop = float(np.median(np.abs(rows["pressure_drop [Pa]"][late])))
        bound = largest_pressure_drop(scene, bed, speed)
        if drop > DOUBTED * bound:
            text = (
                f"a pressure drop of {drop:.4g} Pa, while weight and flow give at "
                f"most about {bound:.4g} Pa"
            )
            if drop > REFUSED * bound:
                raise ConvergenceError(f"{text}; {REMEDY}")
            found.append(f"{text}; {REMEDY}")
    if bed.model.heat is not None:
        from contbed.two_fluid.heat import wall_results

        found += wall_results.judge(bed, scene)
    return found + wall_shear.judge(scene, bed)
