"""What every rank does with its part of a two-fluid bed; `bed` has the side of rank 0.

Each function of `run_on_all` takes the ranks and what rank 0 gives (`root`, None on the
others). Where steps do not converge all ranks meet the same error at the same place, as
all that decides is reduced over them; it is returned to rank 0, which raises it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import astuple, dataclass, replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from contbed.compiled import threads
from contbed.errors import ConvergenceError
from contbed.ranks.group import RankGroup
from contbed.ranks.two_fluid.halo import RankHalo
from contbed.ranks.two_fluid.partition import Part
from contbed.ranks.two_fluid.pressure import PetscPressure
from contbed.two_fluid import closure_kernels
from contbed.two_fluid.averages import Averages
from contbed.two_fluid.boundary import Edge, Side
from contbed.two_fluid.closure_kernels import (
    CompiledClosures,
    GuardCounts,
    ParticleProperties,
)
from contbed.two_fluid.closures import bound
from contbed.two_fluid.compiled import Array
from contbed.two_fluid.model import Materials, Model, Options, Sources
from contbed.two_fluid.near_walls import with_factors
from contbed.two_fluid.rheology import Closures, Rheology
from contbed.two_fluid.scene import TwoFluidScene
from contbed.two_fluid.simulation import Clock, Simulation
from contbed.two_fluid.state import flatten, rebuild
from contbed.two_fluid.timing import Timer

if TYPE_CHECKING:
    from contbed.two_fluid.heat.model import AtFaces, HeatModel

# of the flattened state; all other arrays list cells
OF_FACES = (
    "state.fluxes.solid",
    "state.fluxes.total",
    "state.fluxes.moved",
    "state.memory.face_residual",
    "state.energy.walls.heat",
    "state.energy.walls.heat_if_mixed",
)


class About(NamedTuple):
    """What all ranks know of a bed."""

    scene: TwoFluidScene
    materials: Materials
    particles: ParticleProperties
    options: Options
    floating: bool
    closed: bool


@dataclass(eq=False)
class RankBed:
    """The bed of one rank: its part of the grid, the simulation there, how often
    limits of closures acted, averages.
    """

    part: Part
    simulation: Simulation
    counts: GuardCounts
    averages: Averages | None = None

    @property
    def halo(self) -> RankHalo:
        """The halo of the part."""
        halo = self.simulation.model.grid.halo
        assert isinstance(halo, RankHalo)
        return halo

    def destroy(self) -> None:
        """Free what PETSc holds."""
        solver = self.simulation.model.pressure_solver
        assert isinstance(solver, PetscPressure)
        solver.ksp.destroy()
        solver.matrix.destroy()


def taken(edge: Edge, faces: Any) -> Edge:
    """Return the conditions of some boundary faces."""
    gas, solid = (
        Side(*(values[faces] for values in side)) for side in (edge.gas, edge.solid)
    )
    shared = {
        name: values[faces]
        for name, values in edge._asdict().items()
        if isinstance(values, np.ndarray)
    }
    return Edge(gas, solid, **shared)


def taken_heat(heat: HeatModel, faces: Any) -> AtFaces:
    """Return the conditions of heat of some boundary faces."""
    return type(heat.at_faces)(*(values[faces] for values in heat.at_faces))


def make(
    all_ranks: RankGroup, root: Any, key: int, shared_grid: int, about: About
) -> None:
    """Build the bed of each rank from its part of the grid, object `shared_grid`, as
    object `key`.

    Rank 0 has conditions and those of heat for each rank, distances from walls of all
    cells, and a timer.
    """
    given, walls, timer = root or (None, None, Timer())
    part: Part = all_ranks.objects[shared_grid]
    edge, outside_heat = all_ranks.comm.scatter(given)
    near_walls = all_ranks.comm.bcast(walls is not None)
    wall_froude = all_ranks.take(walls, part.cells) if near_walls else None
    grid = part.shared_grid(all_ranks.comm)
    compiled = closure_kernels.make(
        about.materials, about.particles, bound(about.scene)
    )
    nc, dim = len(part.cells), grid.dimension
    pressure = PetscPressure(
        grid, about.floating, int(part.cells[0]) == 0, all_ranks.comm
    )
    sources = Sources(
        np.zeros(nc),
        np.zeros(nc),
        np.zeros((nc, dim)),
        np.zeros((nc, dim)),
        np.zeros(nc),
    )
    closures = count_own(compiled, part.owned)
    if wall_froude is not None:
        closures = with_factors(closures, compiled.bound, wall_froude)
    heat = None
    if outside_heat is not None:
        from contbed.two_fluid.heat import plan as heat_planning
        from contbed.two_fluid.heat.model import heat_model

        heat = heat_model(
            grid, heat_planning.physics(about.scene, compiled.bound), outside_heat
        )
    model = Model(
        grid,
        about.materials,
        closures,
        edge,
        about.options,
        sources,
        pressure,
        about.closed,
        heat,
        timer,
    )
    all_ranks.objects[key] = RankBed(part, Simulation(model), compiled.counts)


def count_own(compiled: CompiledClosures, owned: int) -> Closures:
    """Return the closures so that what they count in ghost cells is forgotten: their
    owners count it.
    """
    inside, counts = compiled.closures, compiled.counts

    def granular(eps_s: Array, theta: Array, drag: Array) -> Rheology:
        mine = inside.granular(eps_s[:owned], theta[:owned], drag[:owned])
        before = [number.copy() for number in counts]
        ghosts = inside.granular(eps_s[owned:], theta[owned:], drag[owned:])
        for number, kept in zip(counts, before, strict=True):
            number[:] = kept
        return Rheology(
            *(np.concatenate(both) for both in zip(mine, ghosts, strict=True))
        )

    return replace(inside, granular=granular)


def _converging(work: Callable[[], None]) -> ConvergenceError | None:
    # outer ghost cells hold meaningless numbers between exchanges
    with threads.using(1), np.errstate(all="ignore"):
        try:
            work()
        except ConvergenceError as error:
            return error
    return None


def find_fluxes(
    all_ranks: RankGroup, root: Any, key: int, dt: float
) -> ConvergenceError | None:
    """Find the fluxes that belong to the fields of all parts."""
    bed = all_ranks.objects[key].simulation
    return _converging(lambda: bed.find_fluxes(dt))


def step_towards(
    all_ranks: RankGroup, root: Any, key: int, end: float
) -> tuple[ConvergenceError | None, Clock]:
    """Advance all parts by a step; return the time."""
    bed = all_ranks.objects[key].simulation
    error = _converging(lambda: bed.step_towards(end))
    return error, bed.clock


def impose(all_ranks: RankGroup, root: Any, key: int) -> None:
    """Other boundary conditions from now on."""
    bed = all_ranks.objects[key].simulation
    bed.model = replace(bed.model, edge=all_ranks.comm.scatter(root))


def impose_heat(all_ranks: RankGroup, root: Any, key: int) -> None:
    """Other conditions of heat from now on."""
    bed = all_ranks.objects[key].simulation
    heat = bed.model.heat
    assert heat is not None
    at_faces = all_ranks.comm.scatter(root)
    bed.model = replace(bed.model, heat=replace(heat, at_faces=at_faces))


def own_cells(all_ranks: RankGroup, root: Any, key: int) -> Any:
    """Return on rank 0 the own cells of each rank."""
    part = all_ranks.objects[key].part
    return all_ranks.comm.gather(part.cells[: part.owned])


def set_state(all_ranks: RankGroup, root: Any, key: int) -> None:
    """Set the state of all parts, array by array; root has the flattened one of the
    bed.
    """
    here = all_ranks.objects[key]
    flat = flatten(here.simulation.state)
    arrays = [name for name, value in flat.items() if isinstance(value, np.ndarray)]
    plain = {name: value for name, value in (root or {}).items() if name not in arrays}
    flat |= all_ranks.comm.bcast(plain)
    for name in arrays:
        places = here.part.faces if name in OF_FACES else here.part.cells
        flat[name] = all_ranks.take(root and root[name], places)
    here.simulation.state = rebuild(here.simulation.state, flat)


def own_shear_rate(all_ranks: RankGroup, root: Any, key: int) -> Any:
    """Return on rank 0 the shear rates of the own cells of each rank."""
    here = all_ranks.objects[key]
    with np.errstate(all="ignore"):
        return all_ranks.comm.gather(here.simulation.shear_rate()[: here.part.owned])


def own_state(all_ranks: RankGroup, root: Any, key: int) -> Any:
    """Return on rank 0 the flattened state of the bed, put together array by array,
    and the counts of ranks.
    """
    here = all_ranks.objects[key]
    flat, part = flatten(here.simulation.state), here.part
    for name, value in flat.items():
        if isinstance(value, np.ndarray):
            of_faces = name in OF_FACES
            places = (
                part.faces[part.own_faces] if of_faces else part.cells[: part.owned]
            )
            flat[name] = all_ranks.put(
                value[part.own_faces] if of_faces else value[: part.owned], places
            )
    counts = [int(number[0]) for number in here.counts]
    for number in here.counts:
        number[:] = 0
    return flat, all_ranks.comm.gather(counts)


def traffic(all_ranks: RankGroup, root: Any, key: int) -> Any:
    """Return on rank 0 the messages, bytes and reductions of each rank since the
    start.
    """
    return all_ranks.comm.gather(astuple(all_ranks.objects[key].halo.traffic))
