"""A bubbling bed on a mesh: assembly, solution, energy balance and heat duties. See `models.bubbling_bed`."""

from __future__ import annotations

from typing import Any

import numpy as np

from contbed.bubbling_planning import BubblingPlan
from contbed.engine.skfem import System
from contbed.models import bubbling_bed as model
from contbed.models.radiation import emitted
from contbed.solve.linear import Solver
from contbed.solve.newton import newton

Array = Any
EXTRA = 4  # order of quadrature beyond the product of two basis functions, for powers of T and Arrhenius factors
SHARPENED = 2  # Newton steps at the end: rounding in thin cells hides what is left of a smooth error


class BubblingProblem:
    """The unknowns of a plan and their equations."""

    def __init__(self, plan: BubblingPlan):
        self.plan, self.c = plan, plan.coefficients
        self.system = System(plan.mesh.skfem, plan.fields, 2 * plan.scene.solver.degree + EXTRA)
        (self.bottom,), (self.top,) = self.system.boundary("bottom"), self.system.boundary("top")
        self.forms = [
            (model.residual, self.system.cells, self.c),
            (model.bottom, self.bottom, self.c),
            (model.top, self.top, self.c),
        ]

    @property
    def space(self) -> Any:
        """The space of all fields along the height."""
        return self.system.fields["T_emulsion"][0]

    def assemble(self, state: Array, jacobian: bool) -> tuple[Array, Any]:
        """Residual and exact Jacobian."""
        return self.system.assemble(self.forms, state, jacobian)

    def uniform(self, temperature: float) -> Array:
        """A state of one temperature in radiative equilibrium."""
        state = np.full(self.system.size, float(temperature))
        if "G" in self.system.fields:
            self.system.part(state, "G")[:] = emitted(temperature)
        return state

    def solve(self) -> tuple[Array, list[float]]:
        """Newton from the uniform temperature of the scene."""
        options = self.plan.scene.solver
        state = self.uniform(options.guess)
        _, matrix = self.assemble(state, True)
        # rounding of each temperature times what it multiplies: units of G and T differ by a thousand
        rounding = np.finfo(float).eps * float((abs(matrix) @ np.abs(state)).max()) * len(state) ** 0.5
        state, history = newton(
            self.assemble, state, np.empty(0, dtype=np.int64), self.plan.policy, tolerance=options.newton_tolerance,
            iterations=options.newton_iterations, lower=0.0, floor=rounding, what="bubbling bed",
        )  # fmt: skip
        for _ in range(SHARPENED):
            residual, matrix = self.assemble(state, True)
            state = state - Solver(matrix, self.plan.policy)(residual)
        return state, history

    def total(self, expression: Any, state: Array) -> float:
        """Integral over the height of `expression(unknowns, ops)` [W/m] in W."""
        return self.system.integrate(expression, [self.system.cells], state)

    def at(self, expression: Any, end: Any, state: Array) -> float:
        """Value at one end of the bed."""
        return self.system.integrate(expression, [end], state)

    def duties(self, state: Array) -> dict[str, float]:
        """Heat that leaves the particles by mechanism [W]; positive out of the bed."""
        c, out = self.c, {}
        for name, x in c.surfaces.items():
            out[f"{name}_convection_W"] = self.total(lambda u, o, x=x: model.convected(u, c, x), state)
            out[f"{name}_radiation_W"] = self.total(lambda u, o, x=x: model.radiated(u, c, x), state)
        if c.plate is not None:
            out["distributor_convection_W"] = self.at(lambda u, o: model.to_plate(u, c)[0], self.bottom, state)
            out["distributor_radiation_W"] = self.at(lambda u, o: model.to_plate(u, c)[1], self.bottom, state)
        out["top_radiation_W"] = self.at(lambda u, o: model.to_freeboard(u, c), self.top, state)
        return out

    def releases(self, state: Array) -> dict[str, float]:
        """Heat release of each phase [W]."""
        return {
            name.removeprefix("T_"): self.total(lambda u, o, n=name, s=stream: model.released(u, s, n, o), state)
            for name, stream in self.c.streams.items()
            if stream.release is not None
        }

    def carried(self, state: Array) -> dict[str, tuple[float, float]]:
        """Heat above 0 K that each stream brings and takes away [W]."""
        c, out = self.c, {}
        for name, stream in c.streams.items():
            ends = [self.at(lambda u, o, n=name, s=stream: s.flow(o.x[0]) * getattr(u, n), end, state)
                    for end in (self.bottom, self.top)]  # fmt: skip
            if name in c.gases:
                brought = self.at(lambda u, o, s=stream: s.flow(o.x[0]) * c.inlet, self.bottom, state)
                out[name] = (brought, ends[1])
            elif stream.fed is not None:
                brought = self.total(lambda u, o, s=stream: s.fed(o.x[0]) * s.feed_temperature, state)
                out[name] = (brought, ends[1] - ends[0])
        return out
