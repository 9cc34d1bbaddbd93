"""A fully developed flow on a mesh: assembly and solution; see
`developed_flow.equations`.
"""

from __future__ import annotations

from collections.abc import Callable
from copy import copy
from dataclasses import replace
from typing import Any

import numpy as np

from contbed.developed_flow import equations as model
from contbed.developed_flow.plan import DevelopedPlan
from contbed.errors import ConvergenceError
from contbed.fem import system as make_system
from contbed.solvers.continuation import PseudoSteps, relax, unwatched
from contbed.solvers.newton import Options, newton

Array = Any
# order of quadrature beyond the product of two basis functions
EXTRA_QUADRATURE_ORDER = 4
# power of the distance in the profile of the gas that the search starts from
START_PROFILE_POWER = 20
# [m2/s2] granular temperature from which the search starts unless the scene gives one
START_THETA = 0.03
# specularity [-] of the first problem, for which uniform starting profiles converge
START_SPECULARITY = 0.05
# of the way from one problem to another, in one step of Newton's method [-]; 200 um
# in turbulent gas need 0.01 at its begin
FIRST_SHARE, LEAST_SHARE = 0.5, 0.005
# pseudo-time steps, none longer than one before, after which the search ends
PATIENCE = 16
# steps in pseudo-time [s]; granular energy settles within a second
FIRST_PSEUDO_STEP, LAST_PSEUDO_STEP = 1e-5, 1e3


class DevelopedProblem:
    """Unknowns and equations of a plan; a `solvers.continuation.Problem` in granular
    energy.
    """

    linear = False
    watch: Callable[[float, str], None] = staticmethod(unwatched)

    def __init__(
        self, plan: DevelopedPlan, coefficients: model.Coefficients | None = None
    ):
        self.plan, self.c = plan, coefficients or plan.coefficients
        degree = plan.scene.solver.degree
        self.particles = self.c.solid_flux > 0
        fields = {"u_gas": (degree, 0), "gradient": (0, 0)}
        if self.particles:
            fields |= {"u_solid": (degree, 0), "root": (degree, 0), "pressure": (0, 0)}
        self.system = make_system(
            plan.mesh, fields, 2 * degree + EXTRA_QUADRATURE_ORDER
        )
        (self.wall,) = self.system.boundary("wall")
        self.fixed = self.system.nodes("u_gas", plan.mesh.skfem.boundaries["wall"])
        # what compares steps of pressures with those of velocities
        self.weights = np.ones(self.system.size)
        for name in ("gradient", "pressure") if self.particles else ("gradient",):
            self.system.part(self.weights, name)[:] = (
                self.c.velocity / self.system.part(self.start(START_THETA), name)
            )
        self.lower = np.full(self.system.size, -np.inf)
        for name in ("root", "pressure") if self.particles else ():
            self.system.part(self.lower, name)[:] = 0.0

    @property
    def r(self) -> Array:
        """Distance of the nodes from the centre [m]."""
        return self.system.fields["u_gas"][0].points[0]

    def steady(self, state: Array, jacobian: bool) -> tuple[Array, Any]:
        """Assemble the residual and the exact Jacobian."""
        if not self.particles:
            return self.system.assemble(
                [(model.gas, self.system.cells, self.c)], state, jacobian
            )
        forms = [
            (model.residual, self.system.cells, self.c),
            (model.wall, self.wall, self.c),
        ]
        return self.system.assemble(forms, state, jacobian)

    def content(self, state: Array, jacobian: bool) -> tuple[Array, Any]:
        """Assemble the granular energy and its Jacobian."""
        return self.system.assemble(
            [(model.content, self.system.cells, self.c)], state, jacobian
        )

    def start(self, theta: float) -> Array:
        """Return a start with evenly spread particles, one granular temperature and
        a flat gas profile.
        """
        c, x = self.c, np.zeros(self.system.size)
        eps_s = model.uniform_fraction(c) if self.particles else 0.0
        place = self.r / self.r.max()
        self.system.part(x, "u_gas")[:] = (
            c.velocity / (1.0 - eps_s) * (1.0 - place**START_PROFILE_POWER)
        )
        self.system.part(x, "gradient")[:] = (
            (1.0 - eps_s) * c.rho_gas + eps_s * c.rho_solid
        ) * c.gravity
        if self.particles:
            self.system.part(x, "u_solid")[:] = c.solid_flux / (c.rho_solid * eps_s)
            self.system.part(x, "root")[:] = theta**0.5
            self.system.part(x, "pressure")[:] = (
                c.rho_solid * theta * c.relative_pressure(eps_s)
            )
        return x

    def solve(self, theta: float) -> tuple[Array, list[float]]:
        """Find the solution that granular energy relaxes to from a level `theta`;
        return it with Newton's history.

        A rough wall, near which the solution differs most from the start, is reached
        from a smooth one, turbulent gas from laminar gas.
        """
        x = self.start(theta)
        if not self.particles:
            return self.solve_from(x)
        rough, turbulent = self.c.specularity, "eddy_viscosity" in self.c.closures
        smooth = min(rough, START_SPECULARITY)
        ways: list[Callable[[float], dict[str, float]]] = []
        if rough > smooth:
            ways.append(
                lambda s: {
                    "specularity": smooth * (rough / smooth) ** s,
                    "eddies_share": 0.0,
                }
            )
        if turbulent:
            ways.append(lambda s: {"eddies_share": s})
        part = 1.0 / (1 + len(ways))
        x = self.with_values(specularity=smooth, eddies_share=0.0)._relaxed(x, part)
        x, history = self.with_values(specularity=smooth, eddies_share=0.0).solve_from(
            x
        )
        for number, values in enumerate(ways, 1):
            x, history = self._followed(x, values, (number * part, part))
        return x, history

    def _relaxed(self, x: Array, part: float = 0.0) -> Array:
        """Return the state to which granular energy relaxes in pseudo-time, `part`
        of the way of a solution.
        """
        return relax(
            self,
            x,
            self.plan.policy,
            self.lower,
            PseudoSteps(FIRST_PSEUDO_STEP, LAST_PSEUDO_STEP, patience=PATIENCE),
            tolerance=1e-5,
            watch=(lambda share, note: self.watch(part * share, note))
            if part
            else unwatched,
        )

    def _followed(
        self,
        x: Array,
        values: Callable[[float], dict[str, float]],
        part: tuple[float, float],
    ) -> tuple[Array, list[float]]:
        """Follow a solution while `values(share)` change from share 0, to which `x`
        belongs, to 1.

        A step that Newton's method does not take is halved; one that is too short for
        that is taken in pseudo-time. `part` of the way of the whole solution begins
        here and is this long.
        """
        history: list[float] = []
        done, step = 0.0, FIRST_SHARE
        while done < 1.0:
            ahead = min(1.0, done + step)
            there = self.with_values(**values(ahead))
            try:
                x, history = there.solve_from(x)
            except ConvergenceError:
                if step > LEAST_SHARE:
                    step /= 2.0
                    continue
                x, history = there.solve_from(there._relaxed(x))
            done, step = ahead, 2.0 * step
            self.watch(part[0] + part[1] * done, "wall and turbulence")
        return x, history

    def with_values(self, **values: Any) -> DevelopedProblem:
        """Return this problem with other coefficients, on the same mesh."""
        other = copy(self)
        other.c = replace(self.c, **values)
        return other

    def solve_from(self, x: Array) -> tuple[Array, list[float]]:
        """Solve by Newton's method from a state close to the solution."""
        options = Options.of(
            self.plan.scene,
            lower=self.lower,
            weights=self.weights,
            what="developed flow",
        )
        linear = not self.particles and "eddy_viscosity" not in self.c.closures
        return newton(self.steady, x, self.fixed, self.plan.policy, options, linear)
