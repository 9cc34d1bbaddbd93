"""A two-fluid bed that ranks share, as rank 0 sees it: a `Simulation` whose steps run
on all ranks.

Rank 0 has the outline of the grid and, whenever it asks for it, the state as a whole,
in the numbering of the mesh as built: so rows, averages, fields and checkpoints do not
depend on the number of ranks.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from contbed.ranks.two_fluid import parts
from contbed.ranks.two_fluid.grid import SharedGrid
from contbed.two_fluid.boundary import OUTLET, Condition
from contbed.two_fluid.closure_kernels import GuardCounts, ParticleProperties
from contbed.two_fluid.compiled import Array
from contbed.two_fluid.model import Model
from contbed.two_fluid.scene import TwoFluidScene
from contbed.two_fluid.simulation import Clock, Simulation
from contbed.two_fluid.state import State, flatten, rebuild

if TYPE_CHECKING:
    from contbed.two_fluid.heat.model import Thermal


class Shared:
    """The object of all ranks, released with the last bed that uses it."""

    def __init__(self, grid: SharedGrid):
        self.ranks, self.grid = grid.ranks, grid  # kept: beds of ranks are on its parts
        self.key, self.edges = self.ranks.new_key(), grid.edges

    def own_cells(self) -> Any:
        """Return the own cells of each rank."""
        return self.run(parts.own_cells)

    def run(
        self, function: Callable[..., Any], *arguments: Any, root: Any = None
    ) -> Any:
        """Run a function of `parts` on all ranks."""
        return self.ranks.run_on_all(function, self.key, *arguments, root=root)

    def __del__(self) -> None:
        self.ranks.released.append(self.key)


class SharedSimulation(Simulation):
    """A bed whose steps run on all ranks; `counts` get how often limits of closures
    acted.

    Its model is on the outline of the grid and takes no steps.
    """

    def __init__(
        self,
        model: Model,
        grid: SharedGrid,
        scene: TwoFluidScene,
        particles: ParticleProperties,
        counts: GuardCounts,
    ):
        edge = model.edge
        self.shared, self.counts = Shared(grid), counts
        floating = not (edge.gas.kind == OUTLET).any()
        about = parts.About(
            scene,
            model.materials,
            particles,
            model.options,
            bool(floating),
            model.closed,
        )
        walls, heat = model.closures.wall_froude, model.heat
        given = [
            (
                parts.taken(edge, at),
                None if heat is None else parts.taken_heat(heat, at),
            )
            for at in grid.edges
        ]
        self.shared.run(parts.make, grid.key, about, root=(given, walls, model.timer))
        self._clock: Clock | None = None
        super().__init__(model)

    @property
    def state(self) -> State:
        """The state of the whole bed, gathered where steps have changed it."""
        if self._clock is not None:
            self._gather()
        return self._whole

    @state.setter
    def state(self, value: State) -> None:
        self._whole, self._clock, self._told = value, None, False

    @property
    def clock(self) -> Clock:
        """Times of the last step."""
        return super().clock if self._clock is None else self._clock

    def find_fluxes(self, dt: float) -> None:
        """Find fluxes and pressure that belong to the fields, as after a step of
        `dt` [s] without convection.
        """
        self.tell()
        if error := self.shared.run(parts.find_fluxes, dt):
            raise error
        self._moved(self.clock)

    def step_towards(self, end: float) -> None:
        """One of the equal steps to `end` [s], on all ranks."""
        self.tell()
        error, clock = self.shared.run(parts.step_towards, end)
        self._moved(clock)
        if error:
            raise error

    def _moved(self, clock: Clock) -> None:
        """Forget the fields, which ranks have changed."""
        self._clock = clock
        flat = flatten(self._whole)
        self._whole = rebuild(
            self._whole,
            {
                k: np.empty(0) if isinstance(v, np.ndarray) else v
                for k, v in flat.items()
            },
        )

    def impose(self, conditions: Mapping[str, Condition]) -> None:
        """Other boundary conditions from now on."""
        super().impose(conditions)
        self.shared.run(
            parts.impose,
            root=[parts.taken(self.model.edge, at) for at in self.shared.edges],
        )

    def impose_heat(self, conditions: Mapping[str, Thermal]) -> None:
        """Other conditions of heat from now on."""
        super().impose_heat(conditions)
        heat = self.model.heat
        assert heat is not None
        self.shared.run(
            parts.impose_heat,
            root=[parts.taken_heat(heat, at) for at in self.shared.edges],
        )

    def shear_rate(self) -> Array:
        """Return the shear rate (nc,) [1/s] of the particles, put together from the
        ranks.
        """
        self.tell()
        found = np.empty(len(self.model.grid.cells))
        for rates, cells in zip(
            self.shared.run(parts.own_shear_rate), self.shared.own_cells(), strict=True
        ):
            found[cells] = rates
        return found

    def traffic(self) -> dict[str, float]:
        """Return messages, bytes and reductions of the busiest rank in a step."""
        counted = np.max(self.shared.run(parts.traffic), axis=0) / max(
            1, self.clock.steps
        )
        names = "messages_per_step", "message_bytes_per_step", "reductions_per_step"
        return {
            name: float(number) for name, number in zip(names, counted, strict=True)
        }

    def tell(self) -> None:
        """Give all ranks their parts of a state that was set here."""
        if not self._told:
            self.shared.run(parts.set_state, root=flatten(self._whole))
            self._told = True

    def _gather(self) -> None:
        """Put the parts of all ranks together, and add what their closures counted."""
        whole, counts = self.shared.run(parts.own_state)
        for counted in counts:
            for number, more in zip(self.counts, counted, strict=True):
                number += more
        self._whole, self._clock = rebuild(self._whole, whole), None
