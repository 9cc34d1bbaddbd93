"""What is possible in a two-fluid scene but seldom meant: by the tables, and by the
mesh.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

import numpy as np

from contbed.scene import moments
from contbed.scene.checking import Mistakes
from contbed.scene.toml_lines import KeyPath, Origin
from contbed.two_fluid import scene as t
from contbed.two_fluid.closures import ABSENT, KINDS
from contbed.two_fluid.conditions import (
    Boundary,
    Initial,
    Inlet,
    Layer,
    Outlet,
    Periodic,
    Wall,
    of_kind,
    places,
)
from contbed.two_fluid.filters import unlike_the_cells

if TYPE_CHECKING:
    from contbed.mesh.mesh import Mesh
    from contbed.two_fluid.fv.grid import Grid

BED_NUSSELT = 10.0  # of particles that some m/s of gas pass [-]
# shares by which a piece of a boundary and a layer may differ from the scene, as faces
# and cells are taken as a whole
MOST_OF_A_PIECE = 0.01
MOST_OF_A_LAYER = 0.04
# gauge pressure at an outlet over that of the gas, by which its density is wrong
MOST_OF_A_PRESSURE = 0.01
# mean free paths across a vessel below which radiation is no conduction: heat from wall
# to wall is up to 5 % off at 26, 12 % at 7, 44 % at 2
# (test_thin_suspensions_are_warned_of)
THICK = 10.0
AXIS = 1e-9  # share of the extent from which a mesh counts as off the axis


def times_are_within_the_run(
    time: t.Time, boundary: Mapping[str, Boundary]
) -> Mistakes:
    """Look for what is written or switched after the end of the run."""
    yield from moments.of_output(time, time.interval)
    for name, part in of_kind(boundary, Inlet).items():
        yield from moments.of_inlet(("boundary", name), part.until, time.end)


def densities_are_those_outside(
    gas: t.Gas, boundary: Mapping[str, Boundary]
) -> Mistakes:
    """Look for an outlet whose pressure is not the one at which the density of the
    gas is taken.
    """
    if gas.model == "constant" and gas.density_law == "constant":
        return
    gauges = {
        name: part.gas.pressure for name, part in of_kind(boundary, Outlet).items()
    }
    shared = min(gauges.values(), key=abs, default=0.0)
    if abs(shared) <= MOST_OF_A_PRESSURE * gas.pressure:
        return
    for name, gauge in gauges.items():
        rest = f"the rest, {gauge - shared:g}, here" if gauge != shared else "none here"
        yield (
            ("boundary", name, "gas", "pressure"),
            f"a gauge pressure, {abs(gauge) / gas.pressure:.0%} of gas.pressure, at "
            f"which the density is taken; give gas.pressure = {gas.pressure + shared:g} "
            f"(absolute) and {rest}",
        )


def there_are_particles(
    initial: Initial,
    boundary: Mapping[str, Boundary],
    gas: t.Gas,
    solids: Mapping[str, t.Solid],
    origin: Origin,
) -> Mistakes:
    """Look for particles, and for a gas that is heavier than they are."""
    ((name, solid),) = solids.items()
    if not _has_particles(initial, boundary):
        text = "no particles at the start, and none enter: a flow of gas alone"
        yield ("initial", "solids", name, "volume_fraction"), text
    fluid = t.fluid_of(gas, initial, boundary, origin.base)
    if fluid.density >= solid.density:
        yield (
            ("gas", "density"),
            f"the gas is not lighter than the particles, {solid.density:g} kg/m3",
        )


def gas_enters_and_carries(
    initial: Initial,
    boundary: Mapping[str, Boundary],
    two_fluid: t.TwoFluid,
    closures: t.Closures,
) -> Mistakes:
    """Look for inlets without flow, and gas that does not move the particles."""
    inlets = of_kind(boundary, Inlet)
    for name, part in inlets.items():
        if part.gas.velocity == 0.0 and part.solid.volume_fraction == 0.0:
            yield (
                ("boundary", name, "gas", "velocity"),
                "nothing enters; a closed boundary is a wall",
            )
    blows = any(part.gas.velocity > 0 for part in inlets.values())
    if (
        closures.drag == ABSENT
        and blows
        and two_fluid.gravity > 0
        and _has_particles(initial, boundary)
    ):
        yield (
            ("closures", "drag"),
            "without drag the gas that enters does not carry the particles",
        )


def walls_slip(closures: t.Closures, boundary: Mapping[str, Boundary]) -> Mistakes:
    """Look for walls that hold gas or particles back where closures have factors
    near walls that do not.
    """
    chosen = [
        key
        for key in KINDS
        if key.startswith("wall_") and getattr(closures, key) != ABSENT
    ]
    rough = [
        name
        for name, wall in of_kind(boundary, Wall).items()
        if wall.gas.wall != "slip" or wall.solid.wall != "slip"
    ]
    if rough:
        for key in chosen:
            yield (
                ("closures", key),
                "holds where gas and particles slip along walls, not along "
                f"{', '.join(rough)}",
            )


def something_holds_the_particles(
    boundary: Mapping[str, Boundary], two_fluid: t.TwoFluid
) -> Mistakes:
    """Look for a vessel that is endless upwards, in which gas and particles fall
    together for ever.
    """
    joined = {
        side
        for name, part in of_kind(boundary, Periodic).items()
        for side in (name, part.partner)
    }
    others = [part for part in boundary.values() if not isinstance(part, Periodic)]
    held = any(isinstance(part, Wall | Inlet | Outlet) for part in others)
    if two_fluid.gravity > 0 and {"bottom", "top"} <= joined and not held:
        name = "bottom" if "bottom" in boundary else "top"
        yield (
            ("boundary", name),
            "joins bottom and top, and no wall, inlet or outlet carries the weight: gas "
            "and particles fall together with g t; close the bottom by a wall, let gas "
            "enter there, or give two_fluid.gravity = 0",
        )


def properties_are_known(
    gas: t.Gas, initial: Initial, boundary: Mapping[str, Boundary], origin: Origin
) -> Mistakes:
    """Look for properties at a temperature outside of their data."""
    fluid = t.known_fluid(gas, initial, boundary, origin.base)
    if fluid is not None and fluid.extrapolated:
        yield ("gas",), fluid.extrapolated


def of_the_mesh(scene: t.TwoFluidScene, mesh: Mesh, grid: Grid) -> tuple[str, ...]:
    """Return what is seldom meant of particles, layers and axis in this mesh, each
    with file, line and key.
    """
    return tuple(
        f"{scene.origin.place(key)}: {text}"
        for key, text in _of_the_mesh(scene, mesh, grid)
    )


def _of_the_mesh(
    scene: t.TwoFluidScene, mesh: Mesh, grid: Grid
) -> Iterator[tuple[KeyPath, str]]:
    smallest = min(float(np.ptp(x[mesh.skfem.t], axis=0).min()) for x in mesh.skfem.p)
    if smallest < scene.solid.diameter:
        (name,) = scene.solids
        text = (
            f"larger than the smallest cell, {smallest:.3g} m; averages over a cell "
            "need many particles in it"
        )
        yield ("solids", name, "diameter"), text
    low, high = float(mesh.skfem.p[-1].min()), float(mesh.skfem.p[-1].max())
    for k, layer in enumerate(scene.initial.layer):
        for key in sorted(layer.model_fields_set & {"start", "end"}):
            if (
                not low - AXIS * (high - low)
                <= (place := getattr(layer, key))
                <= high + AXIS * (high - low)
            ):
                text = (
                    f"{place:g} m is outside of the vessel, which reaches from "
                    f"{low:.6g} to {high:.6g} m"
                )
                yield ("initial", "layer", k, key), text
    if grid.axisymmetric and (inner := float(mesh.skfem.p[0].min())) > AXIS * float(
        np.ptp(mesh.skfem.p[0])
    ):
        yield (
            ("mesh",),
            "axisymmetric, but no cell touches the axis: an annulus from r = "
            f"{inner:.4g} m",
        )
    if scene.radiation is not None:
        yield from _radiates_too_far(scene, mesh, grid)
    yield from _pieces_end_between_faces(scene, mesh)
    if grid.rectangular:
        yield from _layers_end_within_cells(scene, np.unique(mesh.skfem.p[-1]))
    yield from unlike_the_cells(scene, grid)
    if scene.heat is not None and scene.gas.density_law == "ideal_gas":
        yield from _gas_expands_at_once(scene, low, high)


def _pieces_end_between_faces(
    scene: t.TwoFluidScene, mesh: Mesh
) -> Iterator[tuple[KeyPath, str]]:
    """Look for pieces of boundaries whose faces, each of which is taken as a whole,
    have another area.
    """
    grid = mesh.skfem
    for name, part in scene.boundary.items():
        if (
            isinstance(part, Periodic)
            or part.on is None
            or part.start is None
            or part.end is None
        ):
            continue
        # (dim, corners, faces)
        corners = grid.p[:, grid.facets[:, grid.boundaries[name]]]
        axis = 0 if np.ptp(corners[-1]) <= AXIS * np.ptp(grid.p[-1]) else -1
        covered = float(corners[axis].min()), float(corners[axis].max())
        wanted = (
            max(part.start, float(grid.p[axis].min())),
            min(part.end, float(grid.p[axis].max())),
        )
        power = 2 if mesh.axisymmetric and axis == 0 else 1  # rings by their radii
        more = (covered[1] ** power - covered[0] ** power) / (
            wanted[1] ** power - wanted[0] ** power
        ) - 1.0
        if abs(more) > MOST_OF_A_PIECE:
            yield (
                ("boundary", name),
                _reach(covered, more, "area, and of what crosses it"),
            )


def _layers_end_within_cells(
    scene: t.TwoFluidScene, faces: np.ndarray
) -> Iterator[tuple[KeyPath, str]]:
    """Look for layers of particles whose cells, each of which is filled as a whole, are
    thicker or thinner.

    `faces` are the positions between the cells [m], increasing.
    """
    height = 0.5 * (faces[1:] + faces[:-1])
    for k, layer in enumerate(scene.initial.layer):
        if not layer.solid.volume_fraction:
            continue
        inside = (height >= layer.start) & (height < layer.end)
        covered = float(faces[:-1][inside].min()), float(faces[1:][inside].max())
        wanted = max(layer.start, float(faces[0])), min(layer.end, float(faces[-1]))
        more = (covered[1] - covered[0]) / (wanted[1] - wanted[0]) - 1.0
        if abs(more) > MOST_OF_A_LAYER:
            yield ("initial", "layer", k), _reach(covered, more, "of the particles")


def _radiates_too_far(
    scene: t.TwoFluidScene, mesh: Mesh, grid: Grid
) -> Iterator[tuple[KeyPath, str]]:
    """Look for vessels across which radiation is no conduction."""
    from contbed.two_fluid.heat.plan import transport

    given = (part for _, part in places(scene.initial, scene.boundary))
    densest = max(
        part.solid.volume_fraction or 0.0
        for part in given
        if isinstance(part, Initial | Layer | Inlet)
    )
    extents = np.ptp(mesh.skfem.p, axis=1)
    if grid.axisymmetric:
        extents[0] = 2.0 * mesh.skfem.p[0].max()
    depth = float(transport(scene, densest) * extents.min())
    if 0.0 < depth < THICK:
        text = (
            f"the vessel is {depth:.2g} mean free paths of radiation wide where "
            "particles are densest; radiation between them is a conductivity, which is "
            f"some 10 % off at {THICK:g} and a factor of 2 at 1"
        )
        yield ("radiation",), text


def _reach(covered: tuple[float, float], more: float, what: str) -> str:
    share = 100.0 * abs(more)
    shown = f"{share:.0f}" if share >= 10.0 else f"{share:.2g}"
    much = f"{shown} % {'more' if more > 0 else 'less'} {what}"
    return (
        f"reaches from {covered[0]:.6g} to {covered[1]:.6g} m on this mesh: {much}; "
        "begin and end between cells"
    )


def _gas_expands_at_once(
    scene: t.TwoFluidScene, low: float, high: float
) -> Iterator[tuple[KeyPath, str]]:
    """Look for gas between hotter or colder particles at the start, whose change of
    volume drives the first flow.
    """
    from contbed.two_fluid.heat.plan import initial

    fluid, start, d_p = scene.fluid, scene.initial, scene.solid.diameter
    assert fluid.heat_capacity is not None and fluid.conductivity is not None
    inlets = [part.gas.velocity for part in of_kind(scene.boundary, Inlet).values()]
    usual = (
        max(inlets, default=0.0) + (2.0 * scene.two_fluid.gravity * (high - low)) ** 0.5
    )
    parts: list[tuple[KeyPath, Initial | Layer, float, float]] = [
        (("initial",), start, -np.inf, np.inf)
    ]
    parts += [
        (("initial", "layer", k), part, part.start, part.end)
        for k, part in enumerate(start.layer)
    ]
    for key, part, bottom, top in parts:
        eps_s = (
            start.solid.volume_fraction
            if part.solid.volume_fraction is None
            else part.solid.volume_fraction
        )
        T_gas, T_solid = (
            float(T[0]) for T in initial(scene, np.array([bottom])).values()
        )
        if eps_s == 0.0 or T_gas == T_solid:
            continue
        content = fluid.density * fluid.heat_capacity * (1.0 - eps_s)
        time = content * d_p**2 / (6.0 * eps_s * BED_NUSSELT * fluid.conductivity)
        speed = abs(T_solid / T_gas - 1.0) * (min(top, high) - max(bottom, low)) / time
        if speed > usual:
            text = (
                f"gas of {T_gas:g} K between particles of {T_solid:g} K takes their "
                f"temperature in {time:.2g} s and "
            )
            text += (
                f"its new volume flows at {speed:.2g} m/s; give both one "
                "temperature where particles are"
            )
            yield (*key, "gas", "temperature"), text


def _has_particles(initial: Initial, boundary: Mapping[str, Boundary]) -> bool:
    """Whether there are particles at the start, or some enter."""
    start = (
        initial.solid.volume_fraction,
        *(layer.solid.volume_fraction or 0.0 for layer in initial.layer),
    )
    inlets = of_kind(boundary, Inlet).values()
    entering = (part.solid.volume_fraction for part in inlets)
    return any(start) or any(entering)


WARNINGS = (
    times_are_within_the_run,
    densities_are_those_outside,
    there_are_particles,
    gas_enters_and_carries,
    walls_slip,
    something_holds_the_particles,
    properties_are_known,
)
