"""Meshes graded to the layers of a scene: exchange and conduction at the ends, drag
and radiation on walls.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from contbed.mesh.grading import (
    CELLS_ALONG,
    GRADING_ERROR,
    Layers,
    equidistributed,
    finest,
    graded,
    of_size,
    scale_for,
    widened,
)
from contbed.packed_bed import scene as s
from contbed.packed_bed.medium import Medium
from contbed.packed_bed.schedule import PHASES
from contbed.scene.mesh import MeshFile, MeshLine
from contbed.scene.series import ProfileFile

# cells of a bed with a closed form, which only show it
SHOWN_CELLS = 100
# cells of the first automatic mesh of a box; it takes some 2 s, and errors give the
# next one
FIRST_CELLS_3D = 2000
FEWEST = 4  # cells in each direction of it
# cells of scale 1 over the standard deviation of a front: quadratic elements then miss
# it by some GRADING_ERROR
FRONT_SHARE = 0.5
# cells of scale 1 over a rise of an initial profile by the whole span of temperatures
PROFILE_CELLS = 20
# share of the run before which a front need not be resolved where no output is asked
# for
EARLIEST = 1e-3


def nodes(
    scene: s.Scene, medium: Medium, velocity: Any, solid: Any, fronts: bool
) -> list[Any] | None:
    """Return graded coordinates for each direction of a built-in mesh without
    prescribed cells.
    """
    mesh = scene.mesh
    if isinstance(mesh, MeshFile):
        return None
    if isinstance(mesh, MeshLine) and (mesh.cells is None or mesh.graded):
        if fronts:
            return [np.linspace(0.0, mesh.length, SHOWN_CELLS + 1)]
        layers = []
        if scene.heat is not None:
            layers += axial_layers(
                scene, medium, float(velocity[0]), float(solid[0]), mesh.length
            )
        layers += _radiation_layers(scene, medium, 0, mesh.length)
        if mesh.cells is None:
            tolerance, degree = scene.solver.tolerance, scene.solver.degree
            if scene.time is None:
                return [graded(mesh.length, layers, scale=scale_for(tolerance, degree))]
            scale = scale_for(max(tolerance, scene.time.tolerance), degree)
            moving = front_nodes(
                scene, medium, float(velocity[0]), float(solid[0]), scale
            )
            return [finest([graded(mesh.length, layers, scale=scale), moving])]
        return [equidistributed(mesh.length, layers, mesh.cells, scene.solver.degree)]
    if mesh.cells is not None and not mesh.graded:
        return None
    found = [_graded(scene, medium, velocity, solid, k) for k in range(mesh.dimension)]
    excess = np.prod([len(x) - 1 for x in found]) / FIRST_CELLS_3D
    if mesh.dimension < 3 or mesh.cells is not None or excess <= 1.0:
        return found
    counts = [max(FEWEST, int((len(x) - 1) / excess ** (1.0 / 3.0))) for x in found]
    return [
        _graded(scene, medium, velocity, solid, k, count)
        for k, count in enumerate(counts)
    ]


def _graded(
    scene: s.Scene,
    medium: Medium,
    velocity: Any,
    solid: Any,
    direction: int,
    cells: int | None = None,
) -> Any:
    """Return the graded coordinates of one direction of a 2-D or 3-D bed, of a given
    number of cells or of any.
    """
    mesh = scene.mesh
    assert not isinstance(mesh, MeshFile | MeshLine)
    axis, extent = mesh.axis, mesh.extents[direction]
    layers = widened(_radiation_layers(scene, medium, direction, extent), extent)
    if direction == axis and scene.heat is not None:
        layers += axial_layers(
            scene, medium, float(velocity[axis]), float(solid[axis]), extent
        )
    for position, name in zip((0.0, extent), mesh.sides[direction], strict=True):
        table = scene.boundary.get(name)
        thermal = table is not None and (table.type == "no_slip" or table.heated)
        if direction != axis and thermal:
            layers += [
                (position, max(width, 1e-3 * extent))
                for width in wall_layers(scene, medium, velocity, solid)
            ]
    if mesh.cells is not None:
        cells = mesh.cells[direction]
    if cells is not None:
        return equidistributed(extent, layers, cells)
    return graded(extent, layers, coarse=extent / (40 if direction == axis else 12))


def wall_layers(
    scene: s.Scene, medium: Medium, velocity: Any, solid: Any
) -> tuple[float, float]:
    """Return the widths of the flow layer on a wall [m].

    One is for Darcy's drag alone, the other includes Forchheimer's drag at its largest.
    """
    permeability = medium.packing("permeability")
    forchheimer = medium.packing("forchheimer")
    comoving = medium.comoving(solid)
    fastest = float(max(map(np.linalg.norm, (comoving, velocity - comoving))))
    inertia = (
        medium.mass_flux_scale()
        * forchheimer
        * fastest
        / float(medium.fluid.viscosity(medium.T_fluid_in))
    )
    both = 1.0 / permeability + 2.0 * inertia / permeability**0.5
    return (permeability / scene.packed_bed.porosity) ** 0.5, (
        scene.packed_bed.porosity * both
    ) ** -0.5


def _radiation_layers(
    scene: s.Scene, medium: Medium, direction: int, extent: float
) -> Layers:
    """Return the layers next to the walls of a bed in which radiation varies.

    The radiative conductivity competes with that of the solid.
    """
    if scene.radiation is None:
        return []
    from contbed.radiation.grading import radiation_layers

    return radiation_layers(
        scene, float(medium.conductivity("solid", medium.T_fluid_in)), direction, extent
    )


def front_nodes(
    scene: s.Scene, medium: Medium, u: float, u_solid: float, scale: float
) -> Any:
    """Return coordinates that resolve what moves and spreads from both ends in a
    transient, from the first output on.

    What both phases carry moves at v = (F_f + F_s)/C with the heat fluxes F = G c_p and
    the heat content C of both per volume. It spreads by D = K/C + (F_f C_s - F_s
    C_f)^2/(C^3 h a), conduction and exchange (two phases that follow each other, to
    first order), and has the standard deviation sqrt(2 D t). Where it has not come to
    by flow, it has by spreading: the place x belongs to the time t = min(x/v, x^2/(2
    D)).
    """
    mesh, time = scene.mesh, scene.time
    assert isinstance(mesh, MeshLine) and time is not None
    porosity, of_fluid, of_solid, dispersion, exchange = (
        scene.packed_bed.porosity,
        *_at_inlet(medium, u, u_solid),
    )
    flux_fluid, flux_solid = of_fluid * u, of_solid * u_solid
    content_fluid, content_solid = porosity * of_fluid, (1.0 - porosity) * of_solid
    total = content_fluid + content_solid
    conduction = float(medium.stagnant(medium.T_fluid_in)) + dispersion
    lag = flux_fluid * content_solid - flux_solid * content_fluid
    spread = conduction / total + (lag**2 / (total**3 * exchange) if exchange else 0.0)
    v = (flux_fluid + flux_solid) / total
    outputs = [moment for moment in time.times if moment > 0.0]
    first = max(min([*outputs, time.end]), EARLIEST * time.end)
    coarse = mesh.length / CELLS_ALONG
    start = _slope_of_the_start(scene)

    def size(x: Any) -> Any:
        found = np.full_like(x, coarse)
        for distance, velocity in ((x, v), (mesh.length - x, -v)):
            reached = (
                distance**2 / (2.0 * spread) if spread else np.full_like(x, np.inf)
            )
            if velocity > 0.0:
                reached = np.minimum(reached, distance / velocity)
            wide = (
                np.sqrt(2.0 * spread * np.maximum(first, reached))
                if spread
                else np.full_like(x, coarse)
            )
            found = np.minimum(found, FRONT_SHARE * wide)
        return np.minimum(
            found, 1.0 / (PROFILE_CELLS * np.maximum(start(x), 1e-9 / mesh.length))
        )

    return of_size(mesh.length, size, scale)


def _at_inlet(
    medium: Medium, u: float, u_solid: float
) -> tuple[float, float, float, float]:
    """Return heat capacities of fluid and solid per volume [J/m3/K], thermal
    dispersion [W/m/K] and exchange [W/m3/K] at the temperature of the inlet.
    """
    T, speed = medium.T_fluid_in, medium.relative_speed(u, u_solid)
    dispersion = medium.dispersion(T, speed)
    return (
        *medium.capacities,
        0.0 if dispersion is None else float(dispersion[0]),
        float(medium.exchange(T, speed)),
    )


def _slope_of_the_start(scene: s.Scene) -> Any:
    """Return the slope of the initial profiles over the span of their temperatures
    as a function of place [1/m].
    """
    files = [
        given.samples(scene.origin.base, f"T_{phase}")
        for phase in PHASES
        if isinstance(given := scene.initial.given(phase), ProfileFile)
    ]

    def slope(x: Any) -> Any:
        found = np.zeros_like(x)
        for positions, T in files:
            if len(positions) > 1 and np.ptp(T) > 0.0:
                steep = np.abs(np.diff(T)) / np.diff(positions) / np.ptp(T)
                piece = np.clip(np.searchsorted(positions, x) - 1, 0, len(steep) - 1)
                inside = (x >= positions[0]) & (x <= positions[-1])
                found = np.maximum(found, np.where(inside, steep[piece], 0.0))
        return found

    return slope


def axial_layers(
    scene: s.Scene, medium: Medium, u: float, u_solid: float, length: float
) -> Layers:
    """Return positions and widths of the exchange and conduction layers at both
    ends, from closed-form rates.
    """
    T = medium.T_fluid_in
    of_fluid, of_solid, dispersion, exchange = _at_inlet(medium, u, u_solid)
    flux_fluid, flux_solid = of_fluid * u, of_solid * u_solid
    d_fluid = float(medium.conductivity_fluid(T)) + dispersion
    d_solid = float(medium.conductivity_solid(T))
    add_fluid, add_solid, cross = (
        float(share) for share in medium.tortuosity(T) or (0.0, 0.0, 0.0)
    )
    found = _rates(
        (flux_fluid, d_fluid + add_fluid),
        (flux_solid, d_solid + add_solid),
        exchange,
        cross,
    )
    finite = [rate for rate in found if rate and np.isfinite(rate)]
    layers = [
        (0.0 if rate < 0 else length, min(1.0 / abs(rate), length)) for rate in finite
    ]
    if flux_fluid * flux_solid >= 0 and finite:
        layers = [
            layer
            for layer in layers
            if _matters(scene, layer, finite, flux_fluid + flux_solid, length)
        ]
    return [(position, width) for position, width in layers if width > 1e-10 * length]


def _rates(
    fluid: tuple[float, float],
    solid: tuple[float, float],
    exchange: float,
    cross: float,
) -> list[float]:
    """Return signed rates l [1/m] of the modes exp(l x) of two phases, given as (flux,
    conductivity).
    """
    if exchange == 0.0:
        return [flux / d for flux, d in (fluid, solid) if d]
    (F, d), (G, e) = fluid, solid
    cubic = [
        d * e - cross**2,
        -(d * G + F * e),
        F * G - exchange * (d + e + 2.0 * cross),
        exchange * (F + G),
    ]
    return sorted(np.roots(cubic).real.tolist())


def _matters(
    scene: s.Scene,
    layer: tuple[float, float],
    rates: list[float],
    flux: float,
    length: float,
) -> bool:
    """Return whether a layer at the end where all streams leave is strong enough to be
    resolved.

    The difference of temperatures there has decayed along the bed.
    """
    position, width = layer
    if (position > 0) != (flux > 0) or any(
        table.heated
        for name, table in scene.boundary.items()
        if name == _end(scene, position)
    ):
        return True
    slow = min((abs(rate) for rate in rates if (rate < 0) == (flux > 0)), default=0.0)
    strength = np.exp(-slow * length) * min(1.0, slow * width)
    return bool(strength * GRADING_ERROR > scene.solver.tolerance)


def _end(scene: s.Scene, position: float) -> str:
    mesh = scene.mesh
    low, high = mesh.sides[mesh.axis]  # type: ignore[union-attr]
    return high if position > 0 else low
