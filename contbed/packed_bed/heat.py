"""The two-energy problem of one scene on one mesh: coefficients, boundary
conditions, solution, balances.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from contbed.errors import ConvergenceError
from contbed.fem import system as make_system
from contbed.fem.ad.dual import plain
from contbed.fem.domain import Domain
from contbed.fem.skfem import Ops, System
from contbed.packed_bed import scene as s
from contbed.packed_bed.equations import two_energy
from contbed.packed_bed.heat_coefficients import HeatCoefficients, enters
from contbed.packed_bed.inlets import inlet_temperature, key_of
from contbed.packed_bed.inside import modes
from contbed.packed_bed.plan import Plan
from contbed.packed_bed.radiation import coupling
from contbed.packed_bed.schedule import (
    PHASES,
    ScheduleInterval,
    initial_values,
    temperatures_given,
)
from contbed.scene.mesh import SIDE, MeshLine
from contbed.scene.toml_lines import dotted
from contbed.solvers.condensed import Modes
from contbed.solvers.linear import Policy, Solver, constrain
from contbed.solvers.newton import Options, newton

if TYPE_CHECKING:
    from contbed.packed_bed.flow import Flow

INSIDE = ""  # in place of the name of a boundary: heat that enters the bed through none

# relative change of temperatures up to which a correction counts as round-off
ROUNDING = 1e-9
REFINEMENTS = 3


class HeatProblem:
    """Residual, Jacobian and heat content of both phases; see
    `contbed.packed_bed.equations.two_energy`.

    `linear` is true for constant properties; `fixed` and `fixed_values` are the
    prescribed temperatures, `idle` names those that nothing carries into the bed and
    that are left out. In an `interval` of a run in which values change with time,
    `set_time` puts those of a time in place. `coefficients` are those at its start,
    `moving` those of the present mass flux. `system` is that of the same problem with other values on
    this mesh.
    """

    def __init__(
        self,
        plan: Plan,
        flow: Flow | None = None,
        interval: ScheduleInterval | None = None,
        system: System | None = None,
    ):
        self.scene, self.mesh, self.medium = plan.solved, plan.mesh, plan.medium
        self.flow, self.interval = flow, interval
        scene, mesh = self.scene, self.mesh
        self.linear = self.medium.constant
        self.radiation, self.modes = coupling(scene), modes(scene)
        self.system = self._system(plan.section) if system is None else system
        self.T_span = self._temperature_range()
        self.weights = self._weights()
        self.lower = self._lower()
        cells = self.system.cells
        self.build = HeatCoefficients(plan, flow, self.system, self.radiation)
        self.coefficients = self.moving = self.build.of(cells)
        self._storage: list[Any] = [(two_energy.storage, cells, self.coefficients)]
        self.boundaries = list(mesh.boundaries)
        self.perimeter = 0.0  # area of the side of a line per volume [1/m]
        if isinstance(scene.mesh, MeshLine) and SIDE in scene.boundary:
            assert scene.mesh.diameter is not None  # `checks` sees to it
            self.perimeter = 4.0 / scene.mesh.diameter
            self.boundaries.append(SIDE)
        self.boundary_terms = [
            (name, part, self.build.wall(name, phase, part))
            for name in self.boundaries
            for phase in PHASES
            for part in self._parts(name)
        ]
        self._carried = [
            (two_energy.boundary, part, wall)
            for name in mesh.boundaries
            for part in self.system.boundary(name)
            for mode in self.modes
            if (wall := self.build.mode_wall(mode, part)) is not None
        ]
        self._radiating: list[Any] = []
        if self.radiation is not None:
            self._radiating = self.radiation.boundaries(mesh, self.system)
            self._radiating.append(self.radiation.interior(cells))
        self._balances = self._heat_balances()
        self.idle: list[str] = []
        self.fixed, self.fixed_values, self.fixed_owner, self._prescribed = (
            self._dirichlet_values()
        )

    def _system(self, section: float) -> System:
        """Return the unknowns and their quadrature."""
        degree = self.scene.solver.degree
        order = 2 * degree + self.mesh.axisymmetric + 2 * (not self.linear)
        if self.flow is not None:
            # the divergence vanishes in the quadrature of the flow
            order = max(order, self.flow.system.order)
        radiant = () if self.radiation is None else self.radiation.fields
        names = (*two_energy.FIELDS, *radiant, *(mode.name for mode in self.modes))
        return make_system(self.mesh, dict.fromkeys(names, (degree, 0)), order, section)

    def _heat_balances(self) -> list[Any]:
        """Return the forms of the cells and of all boundaries that heat crosses, with
        the values in place.
        """
        sides = tuple(
            wall for name, _, wall in self.boundary_terms if self._is_side(name)
        )
        interior = replace(self.moving, sides=sides, perimeter=self.perimeter)
        return [
            (two_energy.residual, self.system.cells, interior),
            *(
                (two_energy.boundary, part, wall)
                for name, part, wall in self.boundary_terms
                if wall.crossed and not self._is_side(name)
            ),
            *self._carried,
        ]

    def _is_side(self, boundary: str) -> bool:
        """Return whether a boundary is the side of a line."""
        return bool(self.perimeter) and boundary == SIDE

    def _parts(self, boundary: str) -> list[Domain]:
        """Return the domains of a boundary; of the side of a line all cells."""
        if self._is_side(boundary):
            return [self.system.cells]
        parts: list[Domain] = self.system.boundary(boundary)
        return parts

    @property
    def heats(self) -> slice:
        """Rows of the content and of the residual that are heats; those of
        intraparticle modes are none.
        """
        return slice(
            0,
            self.system.offset[self.modes[0].name, 0]
            if self.modes
            else self.system.size,
        )

    @property
    def time_dependent(self) -> bool:
        """Whether temperatures or fluxes of boundaries change with time."""
        return self.interval is not None and bool(self.interval.schedule)

    def set_time(self, time: float) -> None:
        """Put the temperatures and fluxes of boundaries at a time [s] in place."""
        if self.time_dependent:
            self.apply_boundary_values(self.interpolation_weights(time))

    def interpolation_weights(self, time: float) -> Any:
        """Return the weights of the boundary values at a time [s], see
        `ScheduleInterval`.
        """
        assert self.interval is not None
        return self.interval.interpolation_weights(time)

    def apply_boundary_values(self, weights: Any) -> None:
        """Put temperatures and fluxes of boundaries at interpolation weights in place."""
        assert self.interval is not None
        boundary, walls = self.interval.boundary(weights), []
        self._set_share(boundary)
        for name, part, wall in self.boundary_terms:
            condition = self.build.condition(name, wall.phase, boundary)
            if condition is not None:
                enters = wall.inflow is not None
                values = self.build.given(wall.phase, condition, enters)
                wall = replace(wall, **values)
            walls.append((name, part, wall))
        self.boundary_terms = walls
        self._balances = self._heat_balances()
        for nodes, name, phase in self._prescribed:
            prescribed = boundary[name].condition(phase)
            assert prescribed is not None
            self.fixed_values[nodes] = prescribed.fixed_temperature

    def _set_share(self, boundary: Mapping[str, s.Boundary]) -> None:
        """Let the mass flux follow the density of the fluid that enters with a given
        velocity.
        """
        fluid = self.medium.fluid
        if fluid.constant or not np.any(self.build.velocities["fluid"]):
            return
        assert self.interval is not None
        now = self.interval.scene.model_copy(update={"boundary": boundary})
        entering = float(fluid.density(inlet_temperature(now)))
        share = entering / self.medium.mass_flux_scale()
        if share == self.share:
            return
        cells = self.system.cells
        self.build, self.moving = self.build.in_stream(share, self.coefficients, cells)
        self.boundary_terms = [
            (name, part, self.build.wall(name, wall.phase, part))
            for name, part, wall in self.boundary_terms
        ]

    @property
    def share(self) -> float:
        """Mass flux of the fluid over that at the density of the medium."""
        return self.build.share

    def _temperature_range(self) -> tuple[float, float]:
        found = temperatures_given(self.scene)
        if self.radiation is not None:
            found += self.radiation.temperatures(self.mesh)
        if self.interval is not None:
            found += self.interval.temperatures
        return min(found), max(found)

    def _dirichlet_values(self) -> tuple[Any, Any, Any, list[tuple[Any, str, str]]]:
        """Return nodes of prescribed temperatures, their values, the number of the
        boundary of each, and its parts.

        A node of several boundaries belongs to the first; a part is (places in the
        three arrays, boundary, phase).
        """
        found = []
        for name in self.mesh.boundaries:
            for phase in PHASES:
                condition = self.build.condition(name, phase)
                if condition is not None and condition.fixed_temperature is not None:
                    if self._reaches(name, phase):
                        nodes = self.system.nodes(
                            f"T_{phase}", self.mesh.skfem.boundaries[name]
                        )
                        found.append((nodes, name, phase, condition.fixed_temperature))
                    elif not self._reaches_the_other(name, phase):
                        key = key_of(
                            self.scene.boundary, name, phase, "fixed_temperature"
                        )
                        of_bed = self.scene.boundary[name].temperature is not None
                        what = "bed" if of_bed else phase
                        why = f"the {what} neither conducts nor enters there"
                        self.idle.append(f"{dotted(key)} has no effect: {why}")
        every = np.concatenate(
            [np.empty(0, dtype=np.int64), *(nodes for nodes, *_ in found)]
        )
        unique, first = np.unique(every, return_index=True)
        part = np.repeat(
            np.arange(len(found)),
            np.array([len(nodes) for nodes, *_ in found], dtype=np.int64),
        )[first]
        values: Any = np.empty(len(unique))
        owners = np.empty(len(unique), dtype=np.int64)
        parts = []
        for number, (_, name, phase, value) in enumerate(found):
            places = np.flatnonzero(part == number)
            values[places], owners[places] = value, self.boundaries.index(name)
            parts.append((places, name, phase))
        return unique, values, owners, parts

    def _reaches(self, boundary: str, phase: str) -> bool:
        """Return whether a prescribed temperature acts on the bed, by conduction or
        with an entering stream.
        """
        c = getattr(self.coefficients, phase)
        if (
            c.dispersion is not None
            or plain(c.conductivity(self.medium.T_fluid_in)) > 0
        ):
            return True
        return any(
            enters(wall.mass_flux, part)
            for name, part, wall in self.boundary_terms
            if (name, wall.phase) == (boundary, phase)
        )

    def _reaches_the_other(self, boundary: str, phase: str) -> bool:
        """Return whether a temperature that both phases take acts on the other one."""
        of_bed = self.scene.boundary[boundary].temperature is not None
        other = next(each for each in PHASES if each != phase)
        return of_bed and self._reaches(boundary, other)

    @property
    def nodal_modes(self) -> Modes | None:
        """Modes of the particles that are condensed: at the nodes of a line at rest
        with constant properties.
        """
        c, T, system = self.coefficients, self.medium.T_fluid_in, self.system
        if (
            not self.modes
            or not self.linear
            or self.mesh.skfem.dim() > 1
            or c.solid.mass_flux is not None
        ):
            return None
        fluid, solid = (
            system.offset[name, 0] + np.arange(system.fields[name][0].size)
            for name in two_energy.FIELDS
        )
        return Modes(
            capacity=float(c.capacity(T) * c.solid.heat_capacity(T)),
            exchange=float(plain(c.exchange(T, T))),
            decay=np.array([[float(mode.decay(T))] for mode in c.modes]),
            gain=np.array([[mode.gain] for mode in c.modes]),
            fluid=fluid,
            solid=solid,
        )

    def steady(self, state: Any, jacobian: bool) -> tuple[Any, Any]:
        """Assemble the residual of the steady balances and its Jacobian."""
        return self.system.assemble(self._balances + self._radiating, state, jacobian)

    def content(self, state: Any, jacobian: bool) -> tuple[Any, Any]:
        """Assemble the tested heat content and its Jacobian."""
        return self.system.assemble(self._storage, state, jacobian)

    def initial(self) -> Any:
        """Return the state at the start of a transient, or a guess for the steady
        solution, with prescribed values in place.
        """
        state = self.unprescribed()
        state[self.fixed] = self.fixed_values
        if self.radiation is not None:
            self.system.part(state, "G")[:] = self.radiation.emitted(
                self.system.part(state, "T_solid")
            )
        return state

    def unprescribed(self) -> Any:
        """Return the temperatures at the start, or a guess, without values that
        boundaries prescribe; all other unknowns are 0.
        """
        time, state = self.scene.time, np.zeros(self.system.size)
        low, high = self.T_span
        for phase in PHASES:
            name, T = f"T_{phase}", 0.5 * (low + high)
            if time is not None:
                x = self.system.fields[name][0].points[self.mesh.axis]
                T = initial_values(self.scene, phase, x)
            self.system.part(state, name)[:] = T
        return state

    def begin(self, policy: Policy) -> Any:
        """Return the state at the start of a transient."""
        return self.consistent(self.initial(), policy)

    def consistent(self, state: Any, policy: Policy) -> Any:
        """Return the state with the incident radiation of its temperatures, which
        stores no heat.
        """
        if self.radiation is None:
            return state
        residual, matrix = self.steady(state, True)
        rest = np.arange(self.system.size)[: self.system.offset["G", 0]]
        residual[rest] = 0.0
        return state - Solver(constrain(matrix, rest), self.system.ordered(policy))(
            residual
        )

    def _weights(self) -> Any:
        """Return the factors that turn errors of all unknowns into errors of
        temperature.

        They are 1 for temperatures and 1/(16 sigma T^3) for incident radiation.
        """
        weights = np.ones(self.system.size)
        if self.radiation is not None:
            self.system.part(weights, "G")[:] = self.T_span[1] / (
                4.0 * self.radiation.emitted(self.T_span[1])
            )
        return weights

    def _lower(self) -> Any:
        """Return the lower bounds of the unknowns: 0 K for temperatures, none for
        incident radiation.

        Incident radiation, a linear unknown, may undershoot where cells are too few.
        """
        lower = np.zeros(self.system.size)
        if self.radiation is not None:
            self.system.part(lower, "G")[:] = -np.inf
        lower[self.heats.stop :] = -np.inf
        return lower

    def solve(self, policy: Policy, start: Any = None) -> tuple[Any, list[float]]:
        """Find the steady state by Newton, from `start` if given, and where Newton
        fails by continuation, in the range of melting or in time.
        """
        policy = self.system.ordered(policy)
        options = self.options("heat")
        if start is None:
            start = self.initial() if self.linear else self._frozen(policy)
        try:
            return newton(self.steady, start, self.fixed, policy, options, self.linear)
        except ConvergenceError:
            if self.linear:
                raise
        if self._melts:
            with suppress(ConvergenceError):
                start = self._narrowed(policy)
                return newton(self.steady, start, self.fixed, policy, options)
        from contbed.solvers.continuation import relax

        try:
            start = relax(self, self.initial(), policy, self.lower)
        except ConvergenceError as error:
            advice = "refine the mesh, or follow the bed in time by [time]"
            raise ConvergenceError(
                f"{error}; {advice}", error.history, error.state
            ) from None
        return newton(self.steady, start, self.fixed, policy, options)

    @property
    def _melts(self) -> bool:
        """Whether a solid that moves melts in a part of the temperatures."""
        latent, (low, high) = self.medium.solid.latent_heat, self.T_span
        moves = self.coefficients.solid.mass_flux is not None
        return moves and latent is not None and latent.end - latent.start < high - low

    def _narrowed(self, policy: Policy) -> Any:
        """Return the steady state, followed from melting at all temperatures."""
        from contbed.packed_bed.melting import narrowed

        latent, options = self.medium.solid.latent_heat, self.options("melting")
        return narrowed(
            latent,
            self.T_span,
            lambda state: newton(self.steady, state, self.fixed, policy, options)[0],
            self._frozen(policy),
        )

    def options(self, what: str) -> Options:
        """Return the options of Newton's method."""
        return Options.of(self.scene, lower=self.lower, weights=self.weights, what=what)

    def _frozen(self, policy: Policy) -> Any:
        """Solve with all properties at the mean prescribed temperature, as a start
        for Newton.
        """
        uniform = np.full(self.system.size, 0.5 * sum(self.T_span))
        uniform[self.heats.stop :] = 0.0
        if self.radiation is not None:
            self.system.part(uniform, "G")[:] = self.radiation.emitted(uniform[0])
        residual, matrix = self.steady(uniform, True)
        jump = np.zeros_like(uniform)
        jump[self.fixed] = self.fixed_values - uniform[self.fixed]
        rhs = -residual - matrix @ jump
        rhs[self.fixed] = jump[self.fixed]
        state = uniform + Solver(constrain(matrix, self.fixed), policy)(rhs)
        return state if np.all(state > self.lower) else self.initial()

    def refined(self, state: Any, policy: Policy) -> tuple[Any, Any]:
        """Return the state and its residual after further Newton steps, linear in the
        last one.

        Conduction over small cells turns the last digit of a temperature into heat that
        can exceed what the streams carry. The residual of the corrected state without
        rounding is that of the state plus Jacobian times step.
        """
        solver = None
        for _ in range(REFINEMENTS):
            residual, matrix = self.steady(state, True)
            free = residual.copy()
            free[self.fixed] = 0.0
            if solver is None or not self.linear:
                solver = Solver(
                    constrain(matrix, self.fixed), self.system.ordered(policy)
                )
            step = -solver(free)
            state = state + step
            if np.abs(step).max() <= ROUNDING * np.abs(state).max():
                return state, residual + matrix @ step
        return state, self.steady(state, False)[0]

    def capacity(self) -> float:
        """Return the heat above 0 K that the bed holds at the highest prescribed
        temperature [J].
        """
        high, medium = self.T_span[1], self.medium
        slopes = (
            content(high) - content(0.99 * high)
            for content in (medium.content_fluid, medium.content_solid)
        )
        return 100.0 * float(np.sum(self.system.cells.weight)) * float(sum(slopes))

    def throughput(self) -> float:
        """Return the scale of the heat balance [W].

        It is what streams carry out above 0 K at the highest prescribed temperature,
        and what walls radiate.
        """
        high = self.T_span[1]
        radiated = (
            0.0
            if self.radiation is None
            else self.radiation.emission(self.mesh, self.system)
        )
        carried = 0.0
        for _, part, wall in self.boundary_terms:
            if wall.mass_flux is not None:
                leaving = np.maximum(plain(Ops.dot(wall.mass_flux, part.n)), 0.0)
                capacity = getattr(self.coefficients, wall.phase).capacity
                carried += capacity * high * float(np.sum(part.weight * leaving))
        return radiated + carried

    def estimated_error(self, state: Any) -> Any:
        """Estimate the error of theta in each cell, the larger of both phases."""
        from contbed.packed_bed.cell_errors import estimate

        space = self.system.fields["T_fluid"][0]
        errors = [
            estimate(space, self.system.part(state, name)) for name in two_energy.FIELDS
        ]
        return np.maximum(*errors) / self.span_of(state)

    def span_of(self, state: Any) -> float:
        """Return the span of temperatures [K], of those that are given or, where
        these are equal, of the solution.
        """
        low, high = self.T_span
        if not high > low:
            values = np.concatenate(
                [self.system.part(state, name) for name in two_energy.FIELDS]
            )
            low, high = float(values.min()), float(values.max())
        return max(high - low, ROUNDING * abs(high))

    def fluxes(self, state: Any) -> dict[str, dict[str, float]]:
        """Return the heat into the bed [W] through each boundary by the streams, by
        walls and by radiation.

        `INSIDE` holds what species and tubes of given temperature radiate. What
        prescribed temperatures conduct is found by `conducted_in`. Streams count from the lowest
        temperature of the scene.
        """
        T_ref = self.T_span[0]
        out = {
            name: {"T_fluid": 0.0, "T_solid": 0.0, "wall": 0.0}
            for name in self.boundaries
        }
        for name, part, wall in self.boundary_terms:
            if wall.mass_flux is not None:
                out[name][wall.name] -= self._integral(
                    _stream_above(T_ref), part, wall, state
                )
            supplied = self._integral(two_energy.supplied, part, wall, state)
            out[name]["wall"] += supplied * (
                self.perimeter if self._is_side(name) else 1.0
            )
        if self.radiation is not None:
            for name, value in self.radiation.fluxes(
                self.mesh, self.system, state
            ).items():
                out[name]["radiation"] = value
            out[INSIDE] = self.radiation.inside(self.mesh, self.system, state)
        return out

    def _integral(self, function: Any, part: Domain, wall: Any, state: Any) -> float:
        return self.system.integrate(
            lambda unknowns, ops: function(unknowns, wall, ops), [part], state
        )

    def conducted_in(self, residual: Any) -> dict[str, float]:
        """Return the heat that prescribed temperatures conduct into the bed [W] by
        boundary.

        It is found from an unconstrained residual.
        """
        return self.sums_by_boundary(residual[self.fixed])

    def sums_by_boundary(self, reaction: Any) -> dict[str, float]:
        """Sum of the reactions at the prescribed nodes, by boundary."""
        sums = np.bincount(
            self.fixed_owner, weights=reaction, minlength=len(self.boundaries)
        )
        return {
            name: float(value)
            for name, value in zip(self.boundaries, sums, strict=True)
        }

    def source(self) -> float:
        """Return the heat released in the bed [W]."""
        c = self.coefficients
        if not (np.any(c.fluid.source) or np.any(c.solid.source)):
            return 0.0
        return float(
            np.sum(self.system.cells.weight * (c.fluid.source + c.solid.source))
        )


def _stream_above(T_ref: float) -> Callable[[Any, Any, Any], Any]:
    """Return the heat that a stream carries out above a reference
    temperature [W/m2].
    """
    return lambda u, c, o: (
        two_energy.convected(u, c, o) - o.dot(c.mass_flux, o.n) * c.enthalpy(T_ref)
    )
