"""Plan of a packed bed from its scene: what is built, what is left out and why; no
other module decides this.

Two recognitions make a scene cheap. *Plug flow*: without a no-slip wall and with a
uniform inlet along the walls the velocity is the inlet velocity everywhere, so no
momentum is solved. *One dimension*: plug flow along the bed axis with adiabatic sides
does not vary across the bed, so a line is solved, and its cross-section kept for the
balances. A mesh without prescribed cells is graded to the layers that the closed-form
rates predict.
"""

from __future__ import annotations

from bisect import bisect_left, bisect_right
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise
from typing import Any

import numpy as np

from contbed.course.schedule import Schedule
from contbed.errors import SceneError
from contbed.materials.constants import fluid_of
from contbed.mesh.build import build, mesh_of, moved, require_names
from contbed.mesh.grading import finest
from contbed.mesh.mesh import Mesh
from contbed.packed_bed import scene as s
from contbed.packed_bed.cell_errors import refinable
from contbed.packed_bed.grading import nodes
from contbed.packed_bed.heat_parts import parts_of_heat
from contbed.packed_bed.inlets import bed_axis, inlet_temperature, velocity_vector
from contbed.packed_bed.inside import Inside, inside_of, modes, resolved
from contbed.packed_bed.medium import Medium
from contbed.packed_bed.pressure import lifted
from contbed.packed_bed.recognition import (
    curved_inlet,
    is_plug_flow,
    reduced,
    require_walls_along_solids,
    roles_in_flow,
    tracks_fronts,
    velocities,
    with_vectors,
)
from contbed.packed_bed.schedule import (
    PHASES,
    ScheduleInterval,
    changing,
    flow_changes,
    kinks_passed,
)
from contbed.packed_bed.schedule_checks import require_flow, require_plug_flow
from contbed.packed_bed.temperature_checks import require_properties
from contbed.plan_text import Rows, built_and_skipped, plan_text
from contbed.scene.mesh import SIDE, MeshAxisymmetric, MeshFile, MeshLine
from contbed.solvers.cost import advice
from contbed.solvers.linear import Policy

AUTOMATIC = 8  # adaptive refinements of an automatic line
# new meshes of a plane or volume at most; two or three bring the error to the tolerance
AUTOMATIC_TENSOR = 6
# by dimension: 5 to 10 s of processor for two temperatures
AUTOMATIC_CELLS = {2: 30_000, 3: 4_000}


@dataclass(frozen=True)
class Plan:
    """What a run builds: `scene` as written, `solved` the scene after reduction to a
    line.

    `section` is the cross-section [m2] of a reduced bed. Where a `schedule` changes
    values, all this holds at the start.
    """

    scene: s.Scene
    solved: s.Scene
    medium: Medium
    mesh: Mesh
    section: float
    coordinate: str
    plug: bool
    fronts: bool
    built: Rows
    skipped: Rows
    schedule: Schedule = field(default_factory=lambda: Schedule({}))
    inside: Inside | None = None  # how the level of intraparticle conduction was chosen

    def as_written(self, boundary: str) -> str:
        """Name in the scene of a boundary of the mesh that is solved on."""
        if self.solved.mesh is self.scene.mesh:
            return boundary
        mesh = self.scene.mesh
        low, high = mesh.sides[mesh.axis]  # type: ignore[union-attr]
        return {"left": low, "right": high}[boundary]

    @cached_property
    def velocity(self) -> Any:
        """Superficial velocity of the fluid, a vector on the mesh [m/s]."""
        return velocities(self.solved)[0]

    @cached_property
    def velocity_solid(self) -> Any:
        """Superficial velocity of the particles, a vector on the mesh [m/s]."""
        return velocities(self.solved)[1]

    @cached_property
    def roles(self) -> dict[str, str]:
        """What each boundary is to the flow, see `roles_in_flow`."""
        return roles_in_flow(self.solved, self.mesh)

    @property
    def speed(self) -> float:
        """Sum of the superficial speeds of both phases [m/s]."""
        return float(
            np.linalg.norm(self.velocity) + np.linalg.norm(self.velocity_solid)
        )

    @property
    def radiates(self) -> bool:
        """Whether the incident radiation is an unknown."""
        return (
            self.solved.radiation is not None
            and self.solved.radiation.level != "rosseland"
        )

    @property
    def steps(self) -> bool:
        """Whether the run takes time steps, so that it can be restarted from a
        checkpoint.
        """
        return self.scene.time is not None and not self.fronts

    @property
    def curved_inlet(self) -> str:
        """Boundary of a mesh file that the gas enters along its normals; empty
        otherwise.
        """
        return curved_inlet(self.solved)

    @property
    def without_ranks(self) -> str:
        """What the scene has that does not run on several ranks, as text; empty if
        there is nothing.
        """
        if self.schedule:
            return "values that change with time"
        if self.curved_inlet:
            return "a gas that enters through a curved boundary"
        return (
            "fronts in closed form (a bed at rest without conduction)"
            if self.fronts
            else ""
        )

    @property
    def tensor(self) -> bool:
        """Whether a built-in plane or volume is solved on, whose errors are
        estimated direction by direction.
        """
        return not isinstance(self.solved.mesh, MeshFile | MeshLine)

    @property
    def balanced(self) -> bool:
        """Whether the coordinates of an automatic plane or volume are chosen anew
        until its errors are small.
        """
        grid = self.solved.mesh
        if isinstance(grid, MeshFile | MeshLine):
            return False
        local = self.solved.solver.adapt is not None and refinable(self.mesh)
        return (
            grid.cells is None
            and not grid.refine
            and self.scene.time is None
            and not local
        )

    @property
    def adaptations(self) -> int:
        """How often the mesh of a steady scene may be refined where the estimated
        error exceeds the tolerance.
        """
        rounds, grid = self.solved.solver.adapt, self.solved.mesh
        if self.balanced:
            return AUTOMATIC_TENSOR if rounds is None else rounds
        if self.scene.heat is None or self.scene.time is not None:
            return 0
        if rounds is None:
            return (
                AUTOMATIC
                if isinstance(grid, MeshLine) and grid.cells is None and not grid.refine
                else 0
            )
        return rounds

    @property
    def most_cells(self) -> int:
        """Number of cells that an automatic plane or volume may have."""
        return AUTOMATIC_CELLS[self.mesh.skfem.dim()]

    def refined(self, error: Any) -> Plan:
        """Return the plan on a mesh refined where `error` (ncells,) is large."""
        from contbed.packed_bed.cell_errors import refined

        return replace(
            self, mesh=refined(self.mesh, error, self.scene.solver.tolerance)
        )

    def intervals(self) -> Sequence[ScheduleInterval | None]:
        """Return the parts of a transient between jumps and kinks that matter; one
        None where nothing changes.
        """
        time, schedule = self.scene.time, self.schedule
        if not schedule or time is None:
            return [None]
        temperatures, found = tuple(schedule.temperatures()), []
        small, every = kinks_passed(schedule, self.scene), schedule.cuts(time.end)
        cuts = every if small is None else schedule.cuts(time.end, small)
        names = {self.as_written(name): name for name in self.mesh.boundaries}
        solved = {
            path: (path[0], names.get(str(path[1]), path[1]), *path[2:])
            for path in schedule.samples
        }
        for start, end in pairwise(cuts):
            inner = every[bisect_right(every, start) : bisect_left(every, end)]
            changed = changing(schedule, start, end, inner).samples
            series = {solved[path]: samples for path, samples in changed.items()}
            found.append(
                ScheduleInterval(
                    start,
                    end,
                    self._as_solved(schedule.frozen(self.scene, start)),
                    Schedule(series),
                    {solved[path]: size for path, size in (small or {}).items()}
                    if inner
                    else {},
                    temperatures,
                    schedule.jumps(start),
                )
            )
        return found

    def within(self, interval: ScheduleInterval) -> Plan:
        """Return the plan with the velocities of a part of the run, on the same mesh.

        The mass flux is that of the inlet temperature at its start.
        """
        return self._with_flow_of(interval.scene)

    def _with_flow_of(self, target: s.Scene) -> Plan:
        """Return the plan with the velocities and the inlet temperature of a scene that
        is solved.
        """
        medium = replace(
            Medium.of(target, self.medium.fluid),
            bed_diameter=self.medium.bed_diameter,
        )
        return replace(self, solved=target, medium=medium)

    def at(self, times: Sequence[float]) -> list[Plan]:
        """Return the plan with the velocities and the mass flux at each of these
        times [s], at a jump with those before it.
        """
        intervals = [each for each in self.intervals() if each is not None]
        constant = self.medium.fluid.constant
        if not intervals or (constant and not flow_changes(self.schedule)):
            return [self] * len(times)
        from contbed.course.history import SAME

        ends = [each.end * (1 + SAME) for each in intervals]
        plans: dict[Any, Plan] = {}
        found = []
        for time in times:
            interval = intervals[min(bisect_left(ends, time), len(intervals) - 1)]
            frozen = self.schedule.frozen(self.scene, time, True, interval.start)
            target = self._as_solved(frozen)
            key = (*map(tuple, velocities(target)), inlet_temperature(target))
            if key not in plans:
                plans[key] = self._with_flow_of(target)
            found.append(plans[key])
        return found

    def _as_solved(self, frozen: s.Scene) -> s.Scene:
        """Return the scene that is solved for one that is frozen at a time."""
        frozen = frozen.with_inside(self.solved.solid.inside)
        frozen = with_vectors(frozen, self.mesh)
        line = None if self.solved.mesh is self.scene.mesh else reduced(frozen)
        return frozen if line is None else line[0]

    @property
    def line_vertices(self) -> Any:
        """Coordinates of a line before it is refined [m]: checkpoints keep them, as
        cells follow the output times.
        """
        grid = self.mesh.skfem
        return grid.p[0, : grid.nelements // 2**self.solved.mesh.refine + 1]

    def with_values(self, scene: s.Scene) -> Plan:
        """Return the plan of a scene that has other numbers, with the discretisation of
        this one.

        The nodes of the mesh move with the lengths of the bed; the level of
        intraparticle conduction stays.
        """
        written, schedule = scene, self.schedule
        if scene.time is not None and schedule:
            schedule = Schedule.of(scene.boundary, scene.origin.base)
            scene = schedule.frozen(scene, 0.0)
        inside, chosen = scene.solid.inside, self.solved.solid.inside
        if inside is not None and chosen is not None:
            scene = scene.with_inside(
                inside.model_copy(update={"heat": chosen.heat, "points": chosen.points})
            )
        # a mixture takes long to make
        fluid = self.medium.fluid if scene.gas == self.scene.gas else None
        medium = Medium.of(scene, fluid)
        line = None if self.solved.mesh is self.scene.mesh else reduced(scene)
        target, section = line or (with_vectors(scene, self.mesh), 1.0)
        return replace(
            self,
            scene=written,
            schedule=schedule,
            solved=target,
            medium=medium,
            mesh=moved(self.mesh, self.solved.mesh, target.mesh),
            section=section,
        )

    def on(self, vertices: Any) -> Plan:
        """Return the plan on a mesh with other coordinates in each direction [m]."""
        return replace(
            self, mesh=replace(self.mesh, skfem=build(self.solved.mesh, vertices).skfem)
        )

    @property
    def policy(self) -> Policy:
        """Choice of the linear solver."""
        from contbed.fem import policy

        return replace(
            policy(self.mesh, self.scene.solver.memory_GB), multigrid=self.plug
        )

    def unknowns(self) -> dict[str, int]:
        """Return the number of unknowns of each part that is solved."""
        from contbed.fem.elements import Space

        grid, out = self.mesh.skfem, {}
        if not self.plug:
            out["flow"] = grid.dim() * Space(grid, 2).size + grid.nvertices
        if self.scene.heat is not None and not self.fronts:
            out["heat"] = (2 + len(modes(self.solved))) * Space(
                grid, self.scene.solver.degree
            ).size
        if self.radiates:
            out["radiation"] = Space(grid, self.scene.solver.degree).size
        return out

    def __str__(self) -> str:
        unknowns, more = self.unknowns(), []
        if unknowns:
            more.append(advice(unknowns, self.policy))
        if text := lifted(self, np.array([self.medium.T_fluid_in])):
            more.append(f"WARNING {text}")
        return plan_text(self, *more)


def plan(scene: s.Scene) -> Plan:
    """Decide what a packed bed needs and build its mesh.

    Raises
    ------
    SceneError : the mesh or the flow cannot be used
    """
    require_flow(scene)
    schedule = Schedule({})
    written = scene
    if scene.time is not None:
        schedule = Schedule.of(scene.boundary, scene.origin.base)
        scene = schedule.frozen(scene, 0.0)
    fluid = fluid_of(scene.gas, scene.origin)
    require_properties(fluid, scene)
    inside = _inside(schedule, scene, fluid)
    scene = resolved(scene, inside)
    medium = Medium.of(scene, fluid)
    flows = [schedule.frozen(scene, time) for time in _changes_of_flow(schedule, scene)]
    lines = [reduced(each) if scene.solver.reduce else None for each in flows]
    line = lines[0] if all(lines) else None
    target, section = line or (scene, 1.0)
    grid = target.mesh
    fronts = not schedule and tracks_fronts(target, medium)
    targets = [
        each[0] if line and each else frozen
        for each, frozen in zip(lines, flows, strict=True)
    ]
    grids = [nodes(each, medium, *velocities(each), fronts) for each in targets]
    mesh = mesh_of(target, grids[0] if len(grids) == 1 else _finest_each(grids))
    ends = [
        name
        for name in target.boundary
        if name != SIDE or not isinstance(grid, MeshLine)
    ]
    require_names(target.origin, mesh, {"boundary": ends, "region": target.region})
    target = with_vectors(target, mesh)
    if not isinstance(grid, MeshLine):
        of_file = isinstance(grid, MeshFile)
        boundary = target.boundary if of_file else written.boundary
        mesh = replace(mesh, axis=bed_axis(grid, boundary))
    automatic = (
        not isinstance(grid, MeshFile) and grid.cells is None and not grid.refine
    )
    if scene.solver.adapt and not refinable(mesh) and not automatic:
        raise SceneError(
            scene.origin.at(("solver", "adapt"))
            + ": solver.adapt: only lines, triangles and meshes without given "
            "cells are refined by errors; use triangles, leave out mesh.cells, or use "
            "mesh.refine for all cells"
        )
    require_walls_along_solids(target, mesh)
    plug = is_plug_flow(target, mesh)
    if not plug:
        require_plug_flow(written)
    of_line = "z" if isinstance(scene.mesh, MeshAxisymmetric) else "xyz"
    coordinate = ("rz" if mesh.axisymmetric else of_line)[mesh.axis]
    cells = f"{mesh.skfem.nelements} cells, boundaries {', '.join(mesh.boundaries)}"
    dim = mesh.skfem.dim()
    text = "plug flow between adiabatic walls varies along the bed only"
    parts = [("2-D and 3-D mesh", text, False)] if line is not None else []
    parts.append((f"mesh, {dim}-D", cells, True))
    if automatic and dim > 1 and scene.time is None:
        text = (
            "estimated in each direction; new meshes until solver.tolerance is met, "
            f"{AUTOMATIC_CELLS[dim]} cells at most"
        )
        parts.append(("errors", text, True))
    if isinstance(grid, MeshFile) and not scene.solver.adapt:
        text = "not estimated on a mesh of a file; `contbed converge` measures them"
        parts.append(("errors", text, False))
    text = _described_plug(scene, medium) if plug else "Taylor-Hood, Newton"
    parts.append(("porous flow", text, not plug))
    parts += parts_of_heat(scene, medium, schedule, inside, fronts)
    return Plan(
        written,
        target,
        medium,
        mesh,
        section,
        coordinate,
        plug,
        fronts,
        *built_and_skipped(parts),
        schedule,
        inside,
    )


def _described_plug(scene: s.Scene, medium: Medium) -> str:
    """Return why no flow is solved, and what is found of it without temperatures."""
    text = "plug flow: all walls along the flow, uniform inlet"
    if scene.heat is not None:
        return text
    return f"{text}; pressure drop by its resistance at {medium.T_fluid_in:g} K"


def _changes_of_flow(schedule: Schedule, scene: s.Scene) -> list[float]:
    """Return the times at which a velocity takes values that it has not had before,
    the first 0 [s].
    """
    if not flow_changes(schedule) or scene.time is None:
        return [0.0]
    found: dict[Any, float] = {}
    for time in schedule.cuts(scene.time.end)[:-1]:
        frozen = schedule.frozen(scene, time)
        found.setdefault(
            tuple(
                velocity_vector(scene.mesh, frozen.boundary, phase) for phase in PHASES
            ),
            time,
        )
    return list(found.values())


def _inside(schedule: Schedule, scene: s.Scene, fluid: Any) -> Inside | None:
    """Return the level of intraparticle conduction, by the flow for which its error is
    largest.

    Nothing leaves while the fluid is at rest: such times count where there are no
    others.
    """
    if scene.heat is None:
        return None
    medium = Medium.of(scene.with_inside(None), fluid)
    flows = [schedule.frozen(scene, time) for time in _changes_of_flow(schedule, scene)]
    moving = [each for each in flows if np.any(velocities(each)[0])]
    found = [
        inside
        for each in moving or flows
        if (inside := inside_of(each, medium, *velocities(each))) is not None
    ]
    return max(
        found,
        key=lambda inside: (inside.chosen.unknowns, inside.chosen.error),
        default=None,
    )


def _finest_each(grids: list[list[Any] | None]) -> list[Any] | None:
    """Return coordinates for each direction that are nowhere coarser than those of
    any of the grids.
    """
    if grids[0] is None:
        return None
    return [
        finest([grid[k] for grid in grids if grid is not None])
        for k in range(len(grids[0]))
    ]
