"""A bubbling bed on a mesh: assembly, solution, energy balance and heat duties; see
`equations.bed`.
"""

from __future__ import annotations

from collections.abc import Callable
from copy import copy
from dataclasses import replace
from typing import Any

import numpy as np

from contbed.bubbling_bed.burning import burns
from contbed.bubbling_bed.coefficients import SMOOTHED
from contbed.bubbling_bed.diagnosis import explain, fluidization, temperatures
from contbed.bubbling_bed.equations import bed as model
from contbed.bubbling_bed.ignition import burning_state, reacting_state, with_freeboard
from contbed.bubbling_bed.plan import BubblingPlan
from contbed.bubbling_bed.scene import BubblingScene
from contbed.bubbling_bed.scene_coefficients import coefficients, typical_numbers
from contbed.closures.optics import SIGMA
from contbed.errors import ConvergenceError
from contbed.fem import system as make_system
from contbed.fem.ad.batched import RecordedForms
from contbed.fem.ad.graph import NotRecordableError
from contbed.radiation.equations.p1 import emitted
from contbed.solvers.continuation import PseudoSteps, relax, unwatched
from contbed.solvers.linear import Solver, scaled
from contbed.solvers.newton import Options, newton

Array = Any
# order of quadrature beyond the product of two basis functions, for powers of T and
# Arrhenius factors
EXTRA = 4
# heat capacity of a phase, only to approach a steady state in time [J/m3/K]
CAPACITY = 5e5
TYPICAL = 1e3  # temperature [K]
# share of a typical flow or inventory by which Newton's method may undershoot zero
MISSED = 0.01
# shares of u_mf over which the excess of gas bends, one after another
ROUNDED = (1.0, 0.3, 0.1, 0.03, 0.01, 0.003)
# relative step from which a residual of rounding does not count as converged: see
# `solve_near`
FAR_STEP = 1e-5
# steps in time, none longer than one before, after which closures have no steady state
# or none is found
PATIENCE = 16
# of Newton's method in such a step: one that needs more is shortened
MAX_ITERATIONS = 15
# relative change of unknowns by Newton's method at which a step in time from the guess
# ends: the next one starts there, and the steady state is solved to
# solver.newton_tolerance
STARTING_TOLERANCE = 0.1
# Jacobian with the same coefficients: recording costs as much as two of them by dual
# numbers
RECORDED_FROM = 2
# times its rounding a residual may have after such a step: more follows from a singular
# Jacobian
AWAY = 1e3
# Newton steps at the end: rounding in thin cells hides what is left of a smooth error
SHARPENED = 2


class BubblingProblem:
    """Unknowns and equations of a plan; a `solvers.continuation.Problem` in temperatures
    at all nodes.
    """

    linear = False

    def __init__(self, plan: BubblingPlan):
        self.plan, self.c = plan, plan.coefficients
        # is called with the progress to a steady state
        self.watch: Callable[[float, str], None] = unwatched
        self.system = make_system(
            plan.mesh, plan.fields, 2 * plan.scene.solver.degree + EXTRA
        )
        (self.bottom,) = self.system.boundary("bottom")
        (self.top,) = self.system.boundary("top")
        self.fixed = np.empty(0, dtype=np.int64)
        self.radiant = [
            name for name in ("G", "G_freeboard") if name in self.system.fields
        ]
        # why Jacobians are computed by dual numbers, where forms cannot be recorded
        self.unrecorded = ""
        self._record_from = RECORDED_FROM
        self._capacity = CAPACITY
        self._forget()
        # what compares steps of flows and sizes with those of temperatures
        self.weights = np.ones(self.system.size)
        for name, size in getattr(self.c.computed, "sizes", {}).items():
            self.system.part(self.weights, name)[:] = TYPICAL / size
        self.lower = np.zeros(self.system.size)
        flows = getattr(self.chemistry, "sizes", {}) | getattr(self.above, "flows", {})
        for name, size in flows.items():
            # what is exhausted may be missed by little
            self.system.part(self.lower, name)[:] = -MISSED * size

    @property
    def forms(self) -> list[Any]:
        """The weak forms with their domains."""
        ends = (
            (model.residual, self.system.cells),
            (model.bottom, self.bottom),
            (model.top, self.top),
        )
        return [(form, where, self.c) for form, where in ends]

    def typical(self) -> dict[str, Any] | None:
        """Return coefficients that follow the state as numbers, which other scenes on
        this mesh need not find again; None where all are numbers.
        """
        computed = self.c.computed
        return None if computed is None else typical_numbers(self.plan.scene, computed)

    def with_scene(
        self, scene: BubblingScene, typical: dict[str, Any] | None = None
    ) -> BubblingProblem:
        """Return this problem with the coefficients of another scene, on the same
        mesh; `typical` are numbers of this one, see `typical`.
        """
        other = copy(self)
        other.c = coefficients(scene, typical)
        if self.above is not None:
            other.above.rate = self.above.rate
        other.plan = replace(self.plan, scene=scene, coefficients=other.c)
        other._record_from = RECORDED_FROM
        other._forget()
        return other

    def steady_of(
        self, recorded: RecordedForms, x: Array, jacobian: bool
    ) -> tuple[Array, Any]:
        """Assemble recorded forms as `steady` assembles those of the coefficients."""
        return self._in_temperatures(recorded.assemble(self._state(x), jacobian), x)

    def _forget(self) -> None:
        """Begin without recorded forms: they hold for one set of coefficients."""
        self._recorded: RecordedForms | None = None
        self._recorded_content: RecordedForms | None = None
        self._jacobians = 0  # computed by dual numbers since then

    def unknowns(self, state: Array) -> Array:
        """Return the temperatures at all nodes for a state, the inverse of `_state`."""
        x = state.copy()
        for name in self.radiant:
            G = self.system.part(x, name)
            G[:] = (G / (4.0 * SIGMA)) ** 0.25
        return x

    @property
    def above(self) -> Any:
        """The freeboard, None where none is solved for."""
        return self.c.above

    @property
    def chemistry(self) -> Any:
        """The reacting part, None where nothing reacts."""
        return self.c.chemistry

    @property
    def space(self) -> Any:
        """The space of all fields along the height."""
        return self.system.fields["T_emulsion"][0]

    def assemble(self, state: Array, jacobian: bool) -> tuple[Array, Any]:
        """Assemble the residual and the exact Jacobian."""
        if jacobian and self._recorded is None and not self.unrecorded:
            self._jacobians += 1
            if self._jacobians >= self._record_from:
                self._record()
        if self._recorded is not None:
            return self._recorded.assemble(state, jacobian)
        return self.system.assemble(self.forms, state, jacobian)

    def _record(self) -> None:
        try:
            self._recorded = RecordedForms(self.system, self.forms)
            self._recorded_content = RecordedForms(self.system, self._content_forms)
        except NotRecordableError as error:
            self.unrecorded = str(error)

    def solve(self, guess: float | None = None) -> tuple[Array, list[float]]:
        """Solve by Newton's method from a uniform temperature, that of the scene if
        absent.

        Instead of G at a node the unknown is the temperature of its equilibrium, (G/(4
        sigma))^(1/4): emission and absorption of the species are then curved alike, and
        far from the solution a step leaves their difference small.
        """
        initial = self.plan.scene.initial
        T = initial.temperature if guess is None else guess
        if self.chemistry is None:
            return self.solve_from(self._start(T))
        given = guess is not None or "temperature" in initial.model_fields_set

        def solve() -> tuple[Array, list[float]]:
            return (
                burning_state(self, T, given)
                if burns(self)
                else reacting_state(self, T)
            )

        if self.above is None or not self.above.reacts:
            return solve()
        return with_freeboard(self, solve)

    def react_above(self, share: float) -> None:
        """Let gases react above the bed at a share of their rates."""
        self.above.rate = share
        self._forget()

    def settled(self, T: float, slower: float = 1.0) -> Array:
        """Return the state after steps in time from one temperature, whose heat
        changes so many times slower than that of solids and gas.
        """
        x = self._start(T)
        self._record_from = 1  # steps in time need twenty Jacobians
        self._capacity = slower * CAPACITY
        self._forget()
        try:
            with np.errstate(all="ignore"):
                return relax(
                    self,
                    x,
                    self.plan.policy,
                    self.lower,
                    PseudoSteps(last=1e7, growth=8.0, patience=PATIENCE),
                    tolerance=STARTING_TOLERANCE,
                    watch=self.watch,
                )
        except ConvergenceError as error:
            failed = x if error.state is None else error.state
            raise self._explained([failed], error.history) from error
        finally:
            self._capacity = CAPACITY
            self._recorded_content = None

    # states that no method accepts may leave the range of a property
    @np.errstate(all="ignore")
    def solve_from(self, x: Array, near: bool = False) -> tuple[Array, list[float]]:
        """Solve by Newton's method from known temperatures and other unknowns, or by
        what is slower and safer unless they are known to be `near`.

        Raises
        ------
        ConvergenceError
            Where no steady state is found; its message says where, by how much, and what to change.

        """
        history: list[float] = []
        failed: list[Array] = []
        ways = (self.solve_near, self._unbent, self._marched)
        for way in ways[:1] if near else ways:
            if way == self._marched and any(
                not temperatures(self, x) and fluidization(self, x) for x in failed
            ):
                break  # steps in time would come to rest at the same edge
            try:
                found, steps = way(x)
                return self._sharpened(found), history + steps
            except ConvergenceError as error:
                history += error.history
                failed.append(x if error.state is None else error.state)
        raise self._explained(failed, history)

    def _explained(self, failed: list[Array], history: list[float]) -> ConvergenceError:
        """Return the error of states at which no method went on."""
        text = (
            f"{self.plan.scene.origin.at(('bubbling_bed',))}: bubbling_bed: no "
            "steady state is found: "
        )
        return ConvergenceError(text + explain(self, failed), history, failed[-1])

    def _unbent(self, x: Array) -> tuple[Array, list[float]]:
        """Solve with the edge between a fluidized bed and one at rest rounded, less and
        less.

        Where the bed comes to rest at a height that is not known beforehand, bubbles
        and mixing end within a cell, and Newton's method finds the place only from a
        state near by.
        """
        if self.c.computed is None or not self.c.computed.bubbling:
            raise ConvergenceError("the frozen coefficients need no smoothing", [], x)
        history: list[float] = []
        try:
            for self.c.computed.smoothed in (*ROUNDED, SMOOTHED):
                self._forget()
                x, steps = self.solve_near(x)
                history += steps
        finally:
            self.c.computed.smoothed = SMOOTHED
            self._forget()
        return x, history

    def _marched(self, x: Array) -> tuple[Array, list[float]]:
        """Solve by steps in time."""
        steps = PseudoSteps()
        if self.c.computed is not None:
            steps = PseudoSteps(patience=PATIENCE, iterations=MAX_ITERATIONS)
        return self.solve_near(
            relax(self, x, self.plan.policy, self.lower, steps, watch=self.watch)
        )

    def _sharpened(self, x: Array) -> Array:
        for _ in range(SHARPENED):
            residual, matrix = self.steady(x, True)
            try:
                better = x - Solver(matrix, self.plan.policy)(residual)
            except ConvergenceError:
                break  # the residual is rounding, which no factors reduce
            before = max(float(np.linalg.norm(residual)), _rounding(matrix, x))
            if not np.linalg.norm(self.steady(better, False)[0]) <= AWAY * before:
                raise ConvergenceError(
                    "the Jacobian is nearly singular at the solution; change "
                    "initial.temperature",
                    [],
                    x,
                )
            x = better
        return self._state(x)

    def _start(self, T: float) -> Array:
        """Return a state of one temperature, with the bubbles of a bed that has it."""
        x = np.full(self.system.size, T)
        if self.c.computed is not None:
            places = self.space.points[0]
            for name, values in self.c.computed.start(T, places).items():
                self.system.part(x, name)[:] = values
        for part in self.c.parts:
            for name, value in getattr(part, "initial", {}).items():
                self.system.part(x, name)[:] = value
        return x

    def solve_near(self, x: Array) -> tuple[Array, list[float]]:
        """Solve by Newton's method alone, from unknowns close to the solution; return
        the unknowns and the history.
        """
        _, matrix = self.steady(x, True)
        options = Options.of(
            self.plan.scene,
            lower=self.lower,
            floor=_rounding(matrix, x),
            # conduction over thin cells rounds one balance by more than another whole
            # balance is worth
            far_step=FAR_STEP if self.c.computed is not None else np.inf,
            weights=self.weights,
            what="bubbling bed",
        )
        return newton(self.steady, x, self.fixed, self.plan.policy, options)

    def _state(self, x: Array) -> Array:
        """Return the fields for temperatures at all nodes."""
        state = x.copy()
        for name in self.radiant:
            G = self.system.part(state, name)
            G[:] = emitted(G)
        return state

    def steady(self, x: Array, jacobian: bool) -> tuple[Array, Any]:
        """Assemble the residual and its Jacobian with respect to temperatures at all
        nodes.
        """
        return self._in_temperatures(self.assemble(self._state(x), jacobian), x)

    def _in_temperatures(
        self, assembled: tuple[Array, Any], x: Array
    ) -> tuple[Array, Any]:
        """Return a residual with its Jacobian to fields as one to temperatures at
        all nodes.
        """
        residual, matrix = assembled
        if matrix is not None and self.radiant:
            slope = np.ones_like(x)
            for name in self.radiant:
                self.system.part(slope, name)[:] = (
                    16.0 * SIGMA * self.system.part(x, name) ** 3
                )
            matrix = scaled(matrix, slope)
        return residual, matrix

    @property
    def _content_forms(self) -> list[Any]:
        capacity = self._capacity * self.c.section

        def form(unknowns: Any, tests: Any, names: tuple[str, ...], o: Any) -> Any:
            return capacity * sum(
                (getattr(unknowns, name) * getattr(tests, name) for name in names),
                start=0.0,
            )

        parts = [(part.content, self.system.cells, None) for part in self.c.parts]
        plate = (
            [(form, self.bottom, ("T_distributor",))]
            if self.c.plate is not None
            else []
        )
        return [(form, self.system.cells, tuple(self.c.streams)), *plate, *parts]

    def content(self, x: Array, jacobian: bool) -> tuple[Array, Any]:
        """Assemble a heat content of all phases, by which the bed approaches its
        steady state in time.
        """
        if self._recorded_content is not None:
            return self._recorded_content.assemble(x, jacobian)
        return self.system.assemble(self._content_forms, x, jacobian)

    def total(self, expression: Any, state: Array) -> float:
        """Integrate `expression(unknowns, ops)` [W/m] over the height [W]."""
        return self.system.integrate(expression, [self.system.cells], state)

    def at(self, expression: Any, end: Any, state: Array) -> float:
        """Return the value of an expression at one end of the bed."""
        return self.system.integrate(expression, [end], state)

    def duties(self, state: Array) -> dict[str, float]:
        """Return the heat that leaves the particles by mechanism [W]; positive out
        of the bed.
        """
        c, out = self.c, {}
        for name, x in c.surfaces.items():
            out[f"{name}_convection_W"] = self.total(
                lambda u, o, n=name: model.convected(u, c, n, c.at(u, o)), state
            )
            out[f"{name}_radiation_W"] = self.total(
                lambda u, o, x=x: model.radiated(u, c, x), state
            )
        if c.plate is not None:
            out["distributor_convection_W"] = self.at(
                lambda u, o: model.heat_to_distributor(u, c)[0], self.bottom, state
            )
            out["distributor_radiation_W"] = self.at(
                lambda u, o: model.heat_to_distributor(u, c)[1], self.bottom, state
            )
        if self.above is None:
            out["top_radiation_W"] = self.at(
                lambda u, o: model.to_freeboard(u, c), self.top, state
            )
            return out
        out["top_radiation_W"] = self.at(
            lambda u, o: self.above.part.surface_radiation(u), self.top, state
        )
        above: dict[str, float] = self.above.duties(self, state)
        return out | above

    def releases(self, state: Array) -> dict[str, float]:
        """Return the heat release of each phase [W]."""
        return {
            name.removeprefix("T_"): self.total(
                lambda u, o, n=name, s=stream: model.released(u, s, n, o), state
            )
            for name, stream in self.c.streams.items()
            if stream.release is not None
        }

    def carried(self, state: Array) -> dict[str, tuple[float, float]]:
        """Return the heat above 0 K that each stream brings and takes away [W]."""
        c, out = self.c, {}
        for name in c.gases:
            brought = self.at(
                lambda u, o, n=name: c.at(u, o).flows[n] * c.at(u, o).h(n, c.inlet),
                self.bottom,
                state,
            )
            taken = self.at(
                lambda u, o, n=name: (
                    c.at(u, o).flows[n] * c.at(u, o).h(n, getattr(u, n))
                ),
                self.top,
                state,
            )
            out[name] = (brought, taken if self.above is None else 0.0)
        for name, stream in c.streams.items():
            if stream.fed is None:
                continue
            ends = [
                self.at(
                    lambda u, o, n=name, s=stream: (
                        s.flow(o.x[0]) * s.enthalpy(getattr(u, n))
                    ),
                    end,
                    state,
                )
                for end in (self.bottom, self.top)
            ]
            brought = self.total(
                lambda u, o, s=stream: s.fed(o.x[0]) * s.enthalpy(s.feed_temperature),
                state,
            )
            out[name] = (brought, ends[1] - ends[0])
        if self.chemistry is not None:
            from contbed.bubbling_bed.chemistry.streams import carried

            out |= carried(self, self.chemistry, state)
        return out if self.above is None else out | self.above.carried(self, state)


def _rounding(matrix: Any, x: Array) -> float:
    """Return the rounding of a residual: that of each temperature times what it
    multiplies.
    """
    return float(
        np.finfo(float).eps * float((abs(matrix) @ np.abs(x)).max()) * len(x) ** 0.5
    )
