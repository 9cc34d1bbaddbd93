"""Plan of a two-fluid scene: grid, conditions, closures, and what is left out."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import ceil
from typing import Any

import numpy as np

from contbed.errors import SceneError
from contbed.mesh.build import mesh_of
from contbed.mesh.mesh import Mesh
from contbed.plan_text import plan_text
from contbed.scene.mesh import MeshFile
from contbed.solvers.memory import MemoryPerUnknown
from contbed.two_fluid import (
    boundary,
    closure_kernels,
    filters,
    near_walls,
    probes,
    warnings,
)
from contbed.two_fluid import scene as t
from contbed.two_fluid.closures import ABSENT, bound, dissipative_restitution
from contbed.two_fluid.conditions import (
    Initial,
    Inlet,
    Layer,
    Outlet,
    Periodic,
    Wall,
    of_kind,
)
from contbed.two_fluid.fv import grid
from contbed.two_fluid.model import Materials, Options, build_model
from contbed.two_fluid.place import ONE_PROCESS, Place
from contbed.two_fluid.simulation import Simulation

# bytes for each unknown: 200 in 800 000 of a plane, up to 600 in 140 000 of a volume
MEMORY = MemoryPerUnknown(400.0)


@dataclass(frozen=True)
class TwoFluidPlan:
    """What a run builds."""

    scene: t.TwoFluidScene
    mesh: Mesh
    grid: grid.Grid
    built: tuple[tuple[str, str], ...]
    skipped: tuple[tuple[str, str], ...]
    probes: dict[str, int]
    warnings: tuple[str, ...] = ()
    steps: bool = True
    policy: MemoryPerUnknown = MEMORY
    # of several ranks, `grid` is the outline of a grid of which each has its part
    place: Place = ONE_PROCESS

    def unknowns(self) -> dict[str, int]:
        """Count unknowns: fraction, pressure, granular temperature and two
        velocities in each cell.
        """
        theta = self.scene.two_fluid.granular_temperature != "frozen"
        cells = len(self.grid.cells)
        flow = {"flow": cells * (2 + theta + 2 * self.grid.dimension)}
        return flow if self.scene.heat is None else flow | {"heat": 2 * cells}

    def bed(self) -> tuple[Simulation, closure_kernels.CompiledClosures]:
        """Build the bed with its initial fields, and its compiled closures."""
        scene = self.scene
        gravity = np.zeros(self.grid.dimension)
        gravity[-1] = -scene.two_fluid.gravity
        fluid, solid = scene.fluid, scene.solid
        materials = Materials(
            fluid.density,
            fluid.viscosity,
            solid.density,
            solid.diameter,
            solid.packing_limit,
            tuple(gravity),
        )
        particles = _particles(scene)
        compiled = closure_kernels.make(materials, particles, bound(scene))
        heat = None
        if scene.heat is not None:
            from contbed.two_fluid.heat import plan as heat_planning
            from contbed.two_fluid.heat.model import build_heat

            thermal = heat_planning.thermal(parts(scene), scene)
            heat = build_heat(
                self.grid, heat_planning.physics(scene, compiled.bound), thermal
            )
        boundaries = conditions(scene, self.grid)
        closures = near_walls.corrected(
            compiled.closures, compiled.bound, scene, self.grid
        )
        model = build_model(
            self.grid, materials, closures, boundaries, _options(scene), heat
        )
        bed = self.place.simulation(model, scene, particles, compiled.counts)
        bed.start(**initial(scene, self.grid))
        return bed, compiled

    def __str__(self) -> str:
        return plan_text(self, *(f"WARNING {text}" for text in self.warnings))


def plan(scene: t.TwoFluidScene, place: Place = ONE_PROCESS) -> TwoFluidPlan:
    """Build mesh and grid; `place` is where steps are computed.

    Raises
    ------
    SceneError : the mesh cannot be used, a boundary has no condition or does not exist
    """
    mesh = _cut(mesh_of(scene), scene)
    cells, place = place.grid(mesh, periodic_pairs(scene))
    _require_resolved(scene, mesh, cells)
    known = conditions(scene, cells)
    for name in cells.boundaries:
        if name not in known:
            where = scene.origin.at(("boundary",))
            raise SceneError(
                f"{where}: boundary.{name}: missing; every side needs a condition"
            )
    table, chosen = scene.two_fluid, scene.closures
    built = [("cells", str(len(cells.cells))), ("steps", _steps(scene))]
    built += place.described(cells)
    skipped: list[tuple[str, str]] = []
    for there, what, how, why in (
        (chosen.drag != ABSENT, "drag", str(chosen.drag), 'drag = "none"'),
        (
            table.granular_temperature != "frozen",
            "granular temperature",
            table.granular_temperature,
            "frozen",
        ),
        (
            chosen.granular_viscosity != ABSENT,
            "stress of the particles",
            str(chosen.granular_viscosity),
            'granular_viscosity = "none"',
        ),
        (
            chosen.friction_pressure != ABSENT,
            "friction",
            chosen.friction_pressure,
            'friction_pressure = "none"',
        ),
        (
            chosen.wall_drag != ABSENT,
            "drag near walls",
            chosen.wall_drag,
            'wall_drag = "none"',
        ),
        (table.guards, "guards of dilute flow", "drag and free path", "guards = false"),
        (
            scene.time.average_from is not None,
            "averages",
            "in time",
            "no time.average_from",
        ),
    ):
        (built if there else skipped).append((what, how if there else why))
    built += filters.described(scene, cells)
    if scene.heat is None:
        skipped.append(("heat", "no [heat]: isothermal"))
    else:
        from contbed.two_fluid.heat import plan as heat_planning

        built.append(("heat", heat_planning.described(scene)))
    if scene.output.window is not None and cells.dimension > 1:
        skipped.append(
            (
                "fully developed flow",
                "[developed_flow] gives profiles far from the inlet in a second",
            )
        )
    points = probes.cells(mesh, cells, scene.output.probes)
    seldom_meant = warnings.of_the_mesh(scene, mesh, cells)
    return TwoFluidPlan(
        scene,
        mesh,
        cells,
        tuple(built),
        tuple(skipped),
        points,
        seldom_meant,
        place=place,
    )


def _steps(scene: t.TwoFluidScene) -> str:
    """Return how many steps the run takes, or at least takes."""
    time = scene.time
    if time.step is not None:
        return f"{ceil(time.end / time.step)} of {time.step:.3g} s"
    return f"{ceil(time.end / time.longest)} or more, of at most {time.longest:.3g} s"


def periodic_pairs(scene: t.TwoFluidScene) -> list[tuple[str, str]]:
    """Return the pairs of periodic boundaries."""
    return [
        (name, part.partner) for name, part in of_kind(scene.boundary, Periodic).items()
    ]


def _require_resolved(scene: t.TwoFluidScene, mesh: Mesh, cells: grid.Grid) -> None:
    """Check that the mesh resolves the layers and the window, and has room for
    particles.

    Raises
    ------
    SceneError : one cell, a layer or a window without a cell, particles as large as the
        vessel
    """
    height, points = cells.centres[:, -1], mesh.skfem.p
    problems: list[tuple[tuple[str | int, ...], str]] = []
    if len(height) == 1:
        problems.append((("mesh",), "one cell has no neighbour: give at least 2 cells"))
    if (width := float(np.ptp(points, axis=1).min())) <= scene.solid.diameter:
        (name,) = scene.solids
        problems.append(
            (
                ("solids", name, "diameter"),
                f"is not smaller than the width of the vessel, {width:.4g} m; "
                "is a unit missing?",
            )
        )
    slices: list[tuple[tuple[str | int, ...], Any]] = [
        (("initial", "layer", k), layer) for k, layer in enumerate(scene.initial.layer)
    ]
    if scene.output.window is not None:
        slices.append((("output", "window"), scene.output.window))
    for where, part in slices:
        if not ((height >= part.start) & (height < part.end)).any():
            reach = f"{points[-1].min():.6g} to {points[-1].max():.6g} m"
            text = (
                f"holds no cell of the mesh, which reaches from {reach} with "
                f"centres from {height.min():.6g} m"
            )
            problems.append(
                (where, f"{text} to {height.max():.6g} m; widen it or refine the mesh")
            )
    if problems:
        raise SceneError(
            [
                f"{scene.origin.at(where)}: {'.'.join(map(str, where))}: {text}"
                for where, text in problems
            ]
        )


def parts(scene: t.TwoFluidScene, time: float = 0.0) -> dict[str, Any]:
    """Return the boundaries that are in force from `time` [s] on."""
    return {
        name: scene.boundary[part.on or name]
        if 0.0 < (getattr(part, "until", None) or 0.0) <= time
        else part
        for name, part in scene.boundary.items()
        if not isinstance(part, Periodic)
    }


def conditions(
    scene: t.TwoFluidScene, cells: grid.Grid, time: float = 0.0
) -> dict[str, boundary.Condition]:
    """Condition of each boundary from `time` [s] on."""
    found = {name: _condition(part) for name, part in parts(scene, time).items()}
    return (
        found
        if "axis" not in cells.boundaries
        else {"axis": boundary.symmetry(), **found}
    )


def initial(scene: t.TwoFluidScene, cells: grid.Grid) -> dict[str, np.ndarray]:
    """Fields at the start; the pressure carries the weight above."""
    start, height = scene.initial, cells.centres[:, -1]
    scalars = {
        name: np.full(len(height), value)
        for name, value in _flow_at_start(start).items()
    }
    for layer in start.layer:
        inside = (height >= layer.start) & (height < layer.end)
        for name, value in _flow_at_start(layer).items():
            if value is not None:
                scalars[name][inside] = value
    if start.noise:
        random = np.random.default_rng(start.seed).uniform(-1.0, 1.0, len(height))
        scalars["eps_s"] = scalars["eps_s"] * (1.0 + start.noise * random)
    fields = {name: scalars[name] for name in ("eps_s", "theta")}
    for name in ("u_gas", "u_solid"):
        fields[name] = np.zeros((len(height), cells.dimension))
        fields[name][:, -1] = scalars[name]
    if start.shear:
        fields["u_solid"][:, 0] += start.shear * (
            height - 0.5 * (height.min() + height.max())
        )
    if scene.heat is not None:
        from contbed.two_fluid.heat import plan as heat_planning

        fields |= heat_planning.initial(scene, height)
    return fields


def _flow_at_start(part: Initial | Layer) -> dict[str, float | None]:
    """Return the values of the fields of the flow that a table of the start gives."""
    solid = part.solid
    return {
        "eps_s": solid.volume_fraction,
        "theta": solid.granular_temperature,
        "u_gas": part.gas.velocity,
        "u_solid": solid.velocity,
    }


def _cut(mesh: Mesh, scene: t.TwoFluidScene) -> Mesh:
    """Return the mesh with pieces of boundaries under names of their own."""
    plain = mesh.skfem
    named = dict(plain.boundaries or {})
    for name, part in scene.boundary.items():
        whole = getattr(part, "on", None)
        if whole is None:
            for key, wanted in (
                ("type", name),
                ("partner", getattr(part, "partner", name)),
            ):
                if wanted not in named:
                    where, known = (
                        scene.origin.at(("boundary", name, key)),
                        ", ".join(named),
                    )
                    raise SceneError(
                        f"{where}: boundary.{name}: the mesh has no {wanted!r}, only "
                        f"{known}"
                    )
            continue
        if whole not in named:
            raise SceneError(
                f"{scene.origin.at(('boundary', name, 'on'))}: boundary.{name}.on: no "
                f"boundary {whole!r}"
            )
        middle = plain.p[:, plain.facets[:, named[whole]]].mean(axis=1)
        axis = 0 if np.ptp(middle[-1]) <= 1e-9 * np.ptp(plain.p[-1]) else -1
        inside = (middle[axis] > part.start) & (middle[axis] < part.end)  # type: ignore[union-attr]
        if not inside.any() or inside.all():
            low, high = (
                f(plain.p[axis, plain.facets[:, named[whole]]])
                for f in (np.min, np.max)
            )
            found = (
                f"holds {'all faces' if inside.any() else 'no face'} of {whole!r}, "
                f"which reaches from {low:.6g} m"
            )
            found = f"boundary.{name}: {found} to {high:.6g} m with {len(inside)} faces"
            raise SceneError(
                f"{scene.origin.at(('boundary', name))}: {found}; refine the mesh or "
                "change start and end"
            )
        named[name], named[whole] = named[whole][inside], named[whole][~inside]
    if isinstance(scene.mesh, MeshFile) and not named:
        raise SceneError(
            f"{scene.origin.at(('mesh', 'file'))}: mesh.file: the mesh names no "
            "boundaries"
        )
    return replace(mesh, skfem=replace(plain, _boundaries=named))


def _condition(part: Any) -> boundary.Condition:
    if isinstance(part, Wall):
        solid = part.solid
        return boundary.WallCondition(
            part.gas.wall,
            solid.wall,
            solid.specularity or 0.0,
            1.0 if solid.restitution is None else solid.restitution,
            part.velocity,
            solid.friction,
        )
    if isinstance(part, Inlet):
        entering = part.solid
        return boundary.InletCondition(
            part.gas.velocity,
            entering.volume_fraction,
            entering.mass_flux or 0.0,
            entering.velocity or 0.0,
            entering.granular_temperature,
        )
    return (
        boundary.OutletCondition(part.gas.pressure)
        if isinstance(part, Outlet)
        else boundary.symmetry()
    )


def _particles(scene: t.TwoFluidScene) -> closure_kernels.ParticleProperties:
    table, friction = scene.two_fluid, scene.solid.friction
    return closure_kernels.ParticleProperties(
        scene.solid.restitution,
        dissipative_restitution(scene),
        friction.start,
        friction.strength,
        friction.angle,
        table.free_path if table.guards else None,
    )


def _options(scene: t.TwoFluidScene) -> Options:
    time = scene.time
    return Options(
        courant=time.courant,
        dt_max=time.longest,
        dt_first=time.first,
        dt=time.step,
        theta=scene.two_fluid.granular_temperature,
    )
