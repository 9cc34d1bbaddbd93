"""Particles, gas and temperatures together: one clock, forces and heat exchanged in
both directions.

A step of the gas spans several of the particles: as many as `gas_step` holds, fewer
where the gas would cross more than COURANT of a cell. First the particles move, under
the force that the gas gave last, then the gas follows through the room that they leave,
and gives the next force; the gas feels exactly its opposite. Temperatures follow

    m_i c dT_i/dt = h_i A_i (T - T_i) + sum over j of G_ij (T_j - T_i) + Q_i

with the conductances G_ij of `conduction.Solid`, found anew every `heat_interval`, and
in Q_i radiation to the surroundings (`heat.radiation`), which does not keep the energy
of the assembly, and heat from tubes: what both add is counted in `balance`.

    gas = Gas(grid, air, drag_di_felice, nusselt_gunn)
    gas.inlet(1.45, 300.0, slot=(0.098, 0.112), slot_velocity=17.55 / air.density(700.0), slot_T=700.0)
    bed = Bed(simulation, gas, T=300.0, heat_capacity=840.0)
    bed.run(0.18)                 # with the jet
    gas.inlet(1.45, 300.0)
    bed.run(0.42)                 # without
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np

from contbed.arrays import Array
from contbed.cfd_dem.conduction import Solid
from contbed.cfd_dem.gas import Gas
from contbed.cfd_dem.gas_quantities import Motion
from contbed.cfd_dem.tubes import TubeHeat
from contbed.compiled.interrupts import deferred_interrupt
from contbed.dem import heat
from contbed.dem.simulation import Simulation
from contbed.errors import SceneError

# largest share of a cell that the gas crosses in a step; convection is explicit
COURANT = 0.5


class Bed:
    """A simulation of particles in a gas.

    Parameters
    ----------
    simulation : the particles
    gas : on a grid that covers them
    gas_step [s] : longest step of the gas
    T [K] : of the particles, one or each; None without an energy equation of the gas
    heat_capacity [J/kg/K] : of the particles
    solid : conduction between particles, or None
    emissivity : of the particles, 0 without radiation
    heat_interval [s] : after which conductances are found anew
    moving : False keeps the particles where they are
    tubes : surfaces in the bed; those with a temperature heat gas and particles

    Attributes: `T` (n,) [K]; `force` [N] and `received` [W] of the last step; `above`
        number of particles that were
    above the grid, counted at every step of the gas; `from_tubes` heat [J] that each tube has given.
    """

    def __init__(
        self,
        simulation: Simulation,
        gas: Gas,
        gas_step: float = 1e-4,
        T: Any = None,
        heat_capacity: float = 840.0,
        solid: Solid | None = None,
        emissivity: float = 0.0,
        heat_interval: float = 5e-3,
        moving: bool = True,
        tubes: Sequence[TubeHeat] = (),
    ):
        n = len(simulation.position)
        if (T is None) == gas.energy:
            raise SceneError(
                "gas: temperatures of the particles and an energy equation of the gas "
                "go together"
            )
        self.simulation = simulation
        self.gas = gas
        self.solid = solid
        self.moving = moving
        self.tubes, self.from_tubes = tuple(tubes), np.zeros(len(tubes))
        self.gas_step, self.heat_interval, self.emissivity = (
            float(gas_step),
            float(heat_interval),
            float(emissivity),
        )
        self.T = (
            None
            if T is None
            else np.array(np.broadcast_to(np.asarray(T, dtype=float), (n,)))
        )
        self.capacity = simulation.mass * heat_capacity
        self.time, self.above, self._next = 0.0, 0, 0.0
        self.force, self.received = np.zeros((n, 3)), np.zeros(n)
        self._top = float(gas.grid.lower[2] + gas.grid.count[2] * gas.grid.size[2])
        self._network: tuple[heat.Pairs, Array, Array] | None = None
        self._start: tuple[float, float, float] | None = None

    @property
    def motion(self) -> Motion:
        """The particles as the gas sees them."""
        simulation = self.simulation
        v = simulation.velocity if self.moving else np.zeros_like(simulation.velocity)
        return Motion(simulation.position, v, simulation.radius, self.T)

    def run(
        self,
        duration: float,
        interval: float | None = None,
        on_interval: Callable[[Bed], Any] | None = None,
        reached: Callable[[float], None] | None = None,
    ) -> None:
        """Advance by `duration` [s]; `on_interval` is called each time that
        `interval` [s] has passed.

        `reached` is called with the time [s] after each step of the gas.

        Raises
        ------
        ConvergenceError : as those of the particles and of the gas
        """
        end, start = self.time + duration, self.time
        next_call = start + (interval or duration)
        while self.time < end * (1.0 - 1e-12):
            self._advance(min(end, next_call) - self.time)
            if reached is not None:
                reached(self.time)
            if self.time >= next_call * (1.0 - 1e-12):
                next_call += interval or duration
                if on_interval is not None:
                    on_interval(self)

    def mass_balance(self) -> dict[str, float]:
        """Return the gas [kg] since the first step: stored, in and out."""
        sums, held = self.gas.sums, float(self.gas.mass.sum())
        start = held if self._start is None else self._start[2]
        return {
            "in": sums["mass_in"],
            "out": sums["mass_out"],
            "source": 0.0,
            "stored": held - start,
        }

    def balance(self) -> dict[str, float]:
        """Return the heat [J] since the first step: stored in particles and gas,
        carried in and out, by radiation.
        """
        if self.T is None or self._start is None:
            return {}
        sums = self.gas.sums
        given = float(self.from_tubes.sum())
        stored = (
            float(self.capacity @ self.T)
            - self._start[0]
            + float(self.gas.heat.sum())
            - self._start[1]
        )
        return {
            "stored": stored,
            "in": sums["heat_in"],
            "out": sums["heat_out"],
            "source": given,
        }

    def state(self) -> dict[str, Array]:
        """Return all that changes as arrays for a checkpoint."""
        arrays = {
            f"particles_{name}": value
            for name, value in self.simulation.state().items()
        }
        arrays |= {f"gas_{name}": value for name, value in self.gas.state().items()}
        arrays |= {
            "force": self.force.copy(),
            "received": self.received.copy(),
            "from_tubes": self.from_tubes.copy(),
        }
        if self.T is not None:
            arrays["T"] = self.T.copy()
        if self._network is not None:
            pairs, G, radiant = self._network
            arrays |= {
                "pair_i": pairs.i,
                "pair_j": pairs.j,
                "pair_vector": pairs.vector,
                "pair_G": G,
                "pair_radiant": radiant,
            }
        start = self._start or (np.nan, np.nan, np.nan)
        return arrays | {"bed": np.array([self.time, self.above, self._next, *start])}

    def restore(self, state: Mapping[str, Array]) -> None:
        """Continue from the arrays of `state`, bit for bit."""
        for prefix, part in (("particles_", self.simulation), ("gas_", self.gas)):
            found = {
                name.removeprefix(prefix): value
                for name, value in state.items()
                if name.startswith(prefix)
            }
            part.restore(found)
        self.force, self.received = (
            np.array(state["force"]),
            np.array(state["received"]),
        )
        self.from_tubes = np.array(state["from_tubes"])
        self.time, above, self._next, *start = state["bed"].tolist()
        self.above, self._start = (
            int(above),
            None if np.isnan(start[0]) else (start[0], start[1], start[2]),
        )
        if self.T is not None:
            self.T = np.array(state["T"])
        if "pair_i" in state:
            first = np.array(state["pair_i"], dtype=np.int64)
            second = np.array(state["pair_j"], dtype=np.int64)
            pairs = heat.Pairs(first, second, np.array(state["pair_vector"]))
            self._network = (
                pairs,
                np.array(state["pair_G"]),
                np.array(state["pair_radiant"]),
            )

    @deferred_interrupt()
    def _advance(self, longest: float) -> None:
        """Advance by a step of the gas and the steps of the particles in it; an
        interrupt waits for its end.
        """
        gas, simulation = self.gas, self.simulation
        if self._start is None:
            gas.start(self.motion)
            held = 0.0 if self.T is None else float(self.capacity @ self.T)
            self._start = held, float(gas.heat.sum()), float(gas.mass.sum())
        allowed = min(self.gas_step, longest, COURANT / max(gas.courant, 1e-300))
        # equal parts of what is left: a last step far shorter than the others would
        # shake the pressure
        allowed = longest / int(np.ceil(longest / allowed * (1.0 - 1e-9)))
        steps = max(1, round(allowed / simulation.time_step))
        dt = steps * simulation.time_step if self.moving else allowed
        if self.moving:
            simulation.force[:] = self.force
            simulation.advance(steps)
        self.time += dt
        self.above += int((simulation.position[:, 2] > self._top).sum())
        to_particles, to_cells = self._heat_of_tubes(dt)
        self.force, self.received = gas.step(dt, self.motion, to_cells)
        if self.T is not None:
            self._heat_up(dt, to_particles)

    def _heat_of_tubes(self, dt: float) -> tuple[Any, Array | None]:
        """Find the heat from tubes to each particle and cell in a step of dt [s], in
        watts, and count it.
        """
        to_particles: Any = 0.0
        to_cells: Array | None = None
        for k, tube in enumerate(self.tubes):
            if self.T is not None and tube.tube.T is not None:
                particles, cells = tube.heat(
                    self.simulation, self.gas, self.motion, self.T
                )
                self.from_tubes[k] += dt * float(particles.sum() + cells.sum())
                to_particles = to_particles + particles
                to_cells = cells if to_cells is None else to_cells + cells
        return to_particles, to_cells

    def _heat_up(self, dt: float, to_particles: Any) -> None:
        """Advance the temperatures of the particles by dt [s] with the heat
        `to_particles` [W] of tubes.
        """
        T, heat_rate = self.T, self.received + to_particles
        assert T is not None
        if self.solid is not None or self.emissivity > 0.0:
            if self._network is None or self.time >= self._next * (1.0 - 1e-12):
                self._connect()
            assert self._network is not None
            pairs, G, radiant = self._network
            flow = G * (T[pairs.j] - T[pairs.i])
            flow += radiant * (T[pairs.j] ** 4 - T[pairs.i] ** 4)
            heat_rate = (
                heat_rate
                + np.bincount(pairs.i, flow, len(T))
                - np.bincount(pairs.j, flow, len(T))
            )
        self.T = T + dt * heat_rate / self.capacity

    def _connect(self) -> None:
        self._next = self.time + self.heat_interval
        solid = self.solid or Solid(0.0)
        around, d_p = self.gas.around(self.motion), 2.0 * self.simulation.radius
        pairs, parts = solid.exchange(self.simulation, around)
        radiant = np.zeros(len(pairs.i))
        if self.emissivity > 0.0:
            # 4 T^3 is the slope of T^4
            radiant = 0.25 * heat.radiation_conductance(
                pairs, len(d_p), 1.0, float(d_p.mean()), self.emissivity, around.eps
            )
        self._network = pairs, heat.total(parts), radiant
