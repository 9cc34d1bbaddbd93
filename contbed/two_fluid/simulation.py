"""A two-fluid bed in time: start, choice of the step, order in time, account."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from contbed.two_fluid.boundary import Condition, assemble
from contbed.two_fluid.compiled import Array
from contbed.two_fluid.fv.gradient import MIN_BINDING_FRACTION
from contbed.two_fluid.model import Model
from contbed.two_fluid.momentum import MAX_SUBCYCLES, SUBCYCLE_COURANT
from contbed.two_fluid.properties import shear_rate
from contbed.two_fluid.state import (
    booked,
    check_finite,
    fastest_gas,
    flatten,
    rebuild,
    zero_state,
)
from contbed.two_fluid.step import initial_fluxes, step

if TYPE_CHECKING:
    from contbed.two_fluid.heat.model import Thermal

# share of the step at which motion driven by its own heat would grow [-]; on random
# fields it does from 0.72 on (test_sound_of_heated_particles)
HEATING_LIMIT = 0.7
# share of a cell that particles cross in a fixed step at most [-]; beyond, a cell would
# give more than it holds
FIXED_COURANT = 1.0
ROUNDING = 1e-9  # share of a step by which a number of steps, or a time, may be off


class Clock(NamedTuple):
    """Time [s], last step [s], the step that it was cut from [s], and the number of
    steps.
    """

    time: float
    dt: float
    dt_wanted: float
    steps: int


class Simulation:
    """A model and its state, which each step replaces.

    Attributes
    ----------
    model : what does not change in time; boundary conditions may be imposed anew
    state : now
    """

    def __init__(self, model: Model):
        self.model, self.state = model, zero_state(model.grid)
        if model.heat is not None:
            from contbed.two_fluid.heat.equations import initial_energy

            self.state = replace(
                self.state, energy=initial_energy(self.state, model.heat, model)
            )

    def start(self, **fields: Any) -> None:
        """Set fields (arrays or numbers) and find the fluxes that belong to them."""
        self.state = self.state.with_fields(fields)
        if self.state.energy is not None and self.model.heat is not None:
            from contbed.two_fluid.heat.equations import fill_with_gas

            energy = fill_with_gas(
                self.state.energy, self.state.eps_s, self.model.heat, self.model
            )
            self.state = replace(self.state, energy=energy)
        self.find_fluxes(self.model.options.dt or self.model.options.dt_first)

    def find_fluxes(self, dt: float) -> None:
        """Find fluxes and pressure that belong to the fields, as after a step of
        `dt` [s] without convection.
        """
        self.state = initial_fluxes(self.state, dt, self.model)

    def impose(self, conditions: Mapping[str, Condition]) -> None:
        """Other boundary conditions from now on."""
        edge = assemble(self.model.grid, conditions, self.model.materials.rho_solid)
        self.model = replace(self.model, edge=edge)

    def impose_heat(self, conditions: Mapping[str, Thermal]) -> None:
        """Other conditions of heat from now on."""
        from contbed.two_fluid.heat.model import build_heat

        assert self.model.heat is not None
        heat = build_heat(self.model.grid, self.model.heat.physics, conditions)
        self.model = replace(self.model, heat=heat)

    @property
    def clock(self) -> Clock:
        """Times of the state, without its fields."""
        return Clock(
            self.state.time, self.state.dt, self.state.dt_wanted, self.state.steps
        )

    def shear_rate(self) -> Array:
        """Return the shear rate (nc,) [1/s] of the particles."""
        return shear_rate(self.state.u_solid, self.state.eps_s, self.model)

    def traffic(self) -> dict[str, float]:
        """Return what ranks send each other in a step; nothing without ranks."""
        return {}

    def saved(self) -> dict[str, Any]:
        """Arrays and numbers of the state by name, for a checkpoint."""
        return flatten(self.state)

    def restore(self, saved: Mapping[str, Any]) -> None:
        """Go back to a `saved` state, bit for bit."""
        self.state = rebuild(self.state, saved)

    def advance(
        self, end: float, callback: Callable[[Simulation], None] | None = None
    ) -> None:
        """Step until `end` [s]; `callback` sees the bed after each step.

        Raises
        ------
        ConvergenceError : a field is not finite; says where
        """
        while self.clock.time < end:
            self.step_towards(end)
            if callback is not None:
                callback(self)

    def step_towards(self, end: float) -> None:
        """One of the equal steps to `end` [s]: a bed at rest feels each change of
        the step.
        """
        left, wanted = end - self.state.time, self.next_step()
        dt = left / np.ceil(left / wanted * (1.0 - ROUNDING))
        self.step(dt)
        now = end if end - self.state.time < ROUNDING * dt else self.state.time
        self.state = replace(self.state, dt_wanted=wanted, time=now)

    def next_step(self) -> float:
        """Length of the next step [s].

        By the Courant number of the particles, cells with few of them left aside; by
        the sub-cycles of the gas; by what a step leaves open of a heated gas; by the
        heat of compression and shear; and by the growth from step to step. A fixed step
        in which particles would cross more than FIXED_COURANT of a cell is cut into
        equal parts.
        """
        o, state = self.model.options, self.state
        if o.dt is not None:
            crossed = o.dt * self._fastest_solid()
            return o.dt / max(
                1, int(np.ceil(crossed / FIXED_COURANT * (1.0 - ROUNDING)))
            )
        gas, solid = fastest_gas(state, self.model.grid.halo), self._fastest_solid()
        courant_gas = MAX_SUBCYCLES * SUBCYCLE_COURANT
        rate = max(
            solid / o.courant,
            gas / courant_gas,
            state.memory.heating_rate / HEATING_LIMIT,
        )
        if self.model.heat is not None:
            from contbed.two_fluid.heat.equations import rate_of_steps

            rate = max(rate, rate_of_steps(state, gas, self.model.heat, self.model))
        longest = min(o.dt_max, 1.0 / rate if rate > 0 else np.inf)
        return min(
            longest, state.dt_wanted * o.growth if state.dt_wanted > 0 else o.dt_first
        )

    def _fastest_solid(self) -> float:
        """Largest rate [1/s] at which particles empty a cell that holds enough of
        them to count.
        """
        state, halo = self.state, self.model.grid.halo
        there = state.eps_s[halo.cells] > MIN_BINDING_FRACTION
        return halo.max(
            float(
                np.max(state.fluxes.outflow_solid[halo.cells], where=there, initial=0.0)
            )
        )

    def step(self, dt: float) -> None:
        """One step of `dt` [s]."""
        new, total = step(self.state, dt, self.model), self.state.fluxes.total
        moved = new.fluxes.moved
        account = booked(
            self.state.account, dt, (moved, total - moved), self.model.grid
        )
        time, steps = self.state.time + dt, self.state.steps + 1
        self.state = replace(
            new, account=account, time=time, dt=dt, dt_wanted=dt, steps=steps
        )
        check_finite(self.state, self.model.grid)
