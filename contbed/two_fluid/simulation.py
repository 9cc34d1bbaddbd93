"""The two-fluid model with kinetic theory of granular flow: start, time, account, restart.

    d eps_s/dt + div(eps_s u_s) = 0,   eps_g = 1 - eps_s,   div(eps_g u_g + eps_s u_s) = 0
    eps_g rho_g D u_g/dt = -eps_g grad p + div tau_g - beta (u_g - u_s) + eps_g rho_g g
    eps_s rho_s D u_s/dt = -eps_s grad p - grad p_s + div tau_s + beta (u_g - u_s) + eps_s rho_s g
    3/2 rho_s eps_s D theta/dt = -p_s div u_s + tau_s : grad u_s + div(k grad theta) - gamma - 3 beta theta

with p_s = rho_s eps_s theta (1 + 2 (1 + e) eps_s g0) and friction near packing (Gidaspow 1994, Multiphase Flow and
Fluidization, Academic Press). The step is in step.py, the mesh in grid.py, the boundaries in boundary.py.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from contbed.two_fluid.boundary import Condition, assemble
from contbed.two_fluid.fv import limiter
from contbed.two_fluid.step import CROSSED, FIELDS, PASSES, Materials, Options, Sources, Stepper

__all__ = ["FIELDS", "Materials", "Options", "Sources", "TwoFluid"]

_MEMORY = ("lag_g", "lag_s", "lag_eps", "lag_theta", "force_g", "force_s", "drag", "stiffness", "grad_p", "own",
           "outflow")  # fmt: skip
_FLUXES = ("flux_solid", "flux_total")
_SCALARS = ("time", "dt", "wanted", "adiabatic")
HEATED = 0.7  # of the step at which compression and its heat would grow; measured on random fields, they do from 0.72


class TwoFluid(Stepper):
    """State and time of one bed.

    Parameters
    ----------
    grid : cells and faces
    materials, closures : of gas and particles
    boundaries : condition of each named boundary
    options : how to step

    Attributes
    ----------
    eps_s, theta, p (nc,), u_gas, u_solid (nc, dim) : fields in the order of the grid, set by `start`
    time, dt, steps : now, the last step, and their number; wanted : the step that the last one was cut from
    account : volumes [m3] of solids and gas that came in and went out
    counters : how often a limiter or guard acted
    """

    def __init__(self, *arguments: Any, **named: Any):
        super().__init__(*arguments, **named)
        self.dt = self.wanted = 0.0
        self.account = {"solid_in": 0.0, "solid_out": 0.0, "gas_in": 0.0, "gas_out": 0.0}

    def start(self, **fields: Any) -> None:
        """Set fields (arrays or numbers) and find the fluxes that belong to them."""
        known = self.fields()
        for name, value in fields.items():
            known[name][...] = value
        if self.heat is not None:
            self.heat.start()
        self.settle_fluxes(self.options.dt or self.options.dt_first)

    def impose(self, conditions: Mapping[str, Condition]) -> None:
        """Other conditions from now on."""
        self.edge = assemble(self.grid, conditions, self.materials.rho_solid)

    def state(self) -> dict[str, Any]:
        """Everything that the next step depends on."""
        kept: dict[str, Any] = {name: getattr(self, name).copy() for name in (*FIELDS, *_FLUXES, *_MEMORY)}
        scalars = {name: getattr(self, name) for name in (*_SCALARS, "steps")}
        if self.heat is not None:
            kept |= self.heat.state()
        return kept | scalars | {"counters": dict(self.counters), "account": dict(self.account)}

    def restore(self, state: Mapping[str, Any]) -> None:
        """Go back to a `state`, bit for bit."""
        for name in (*FIELDS, *_FLUXES, *_MEMORY):
            setattr(self, name, np.array(state[name]))
        for name in _SCALARS:
            setattr(self, name, float(state[name]))
        self.steps = int(state["steps"])
        self.counters, self.account = dict(state["counters"]), dict(state["account"])
        if self.heat is not None:
            self.heat.restore(state)

    def advance(self, end: float, callback: Callable[[TwoFluid], None] | None = None) -> None:
        """Step until `end` [s]; `callback` sees the state after each step.

        Raises
        ------
        ConvergenceError : a field is not finite; says where
        """
        while self.time < end:
            left = end - self.time
            # equal steps to the end: a bed at rest feels each change of the step
            wanted = self.next_step()
            dt = left / np.ceil(left / wanted * (1.0 - 1e-9))
            self.step(dt)
            self.wanted = wanted
            if end - self.time < 1e-9 * dt:
                self.time = end
            if callback is not None:
                callback(self)

    def next_step(self) -> float:
        """Length of the next step [s] by the Courant number of the particles, cells with few of them left aside, and
        by the passes of the gas, which carries its temperature in one; and by the heat of compression.
        """
        o = self.options
        if o.dt is not None:
            return o.dt
        gas = float(np.max(self.outflow[:, 0], initial=0.0))
        solid = float(np.max(self.outflow[:, 1], where=self.eps_s > 1e-6, initial=0.0))
        rate = max(
            solid / o.courant, gas / (PASSES * CROSSED if self.heat is None else o.courant), self.adiabatic / HEATED
        )
        longest = min(o.dt_max, 1.0 / rate if rate > 0 else np.inf)
        return min(longest, self.wanted * o.growth if self.wanted > 0 else o.dt_first)

    def step(self, dt: float) -> None:
        """One step of `dt` [s]."""
        if self.options.order == 1:
            total = self.flux_total.copy()
            self.substep(dt)
            self._book(dt, self.moved, total)
        else:
            self._extrapolated(dt)
        self.time += dt
        self.dt = self.wanted = dt
        self.steps += 1
        self.check_finite()

    def _extrapolated(self, dt: float) -> None:
        """Twice two half steps less one step: second order in time. Fluxes are extrapolated and limited, so that
        fractions stay conserved and within bounds. Where a limit acts or a cell packs, time has no second order, and
        what extrapolation adds can grow from step to step: then the half steps stay as they are.
        """
        before, old, acted = self.state(), self.eps_s, self._acted()
        self.substep(dt)
        whole = {name: getattr(self, name) for name in (*FIELDS, *_FLUXES)}
        first, counters = self.moved, self.counters
        self.restore(before)
        self.counters = counters
        moved, total = np.zeros_like(first), np.zeros_like(first)
        for _ in range(2):
            total += 0.5 * self.flux_total
            self.substep(0.5 * dt)
            moved += 0.5 * self.moved
        if self._acted() > acted:
            self.counters["first_order_steps"] += 1
            self.moved = moved
            self._book(dt, moved, total)
            return
        self.moved = 2.0 * moved - first
        total = 2.0 * total - before["flux_total"]
        new = np.empty_like(old)
        g, highest = self.grid.geometry, self.materials.eps_max
        touched, rounds = limiter.limit(g, dt, old, self.sources.solid, highest, self.moved, new, self.drained)
        self.counters["limited_faces"] += int(touched)
        self.counters["limiter_rounds"] += int(rounds)
        self._book(dt, self.moved, total)
        for name in (*FIELDS[1:], *_FLUXES):
            value = 2.0 * getattr(self, name) - whole[name]
            if name == "theta" and (below := value < 0.0).any():
                self.counters["theta_clipped_cells"] += int(below.sum())
                value[below] = self.theta[below]
            setattr(self, name, value)
        self.eps_s = new

    def _acted(self) -> int:
        """How often a limit has acted or a cell packed."""
        return self.counters["limited_faces"] + self.counters["packing_rounds"]

    def _book(self, dt: float, moved: np.ndarray, total: np.ndarray) -> None:
        """What crossed the boundary in this step."""
        solid = moved[self.grid.interior :]
        for name, rate in (("solid", solid), ("gas", total[self.grid.interior :] - solid)):
            self.account[f"{name}_out"] += dt * float(np.sum(rate, where=rate > 0))
            self.account[f"{name}_in"] -= dt * float(np.sum(rate, where=rate < 0))
