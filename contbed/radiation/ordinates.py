"""A plane stand-alone medium by discrete ordinates: radiative equilibrium, given
temperature, conduction.

Species that neither conduct nor have a temperature emit what they absorb, which is
isotropic scattering to the ordinates. A conducting medium solves, with the elements of
the ordinates and their response G = R e + G0,

    -k T'' = K_a,active (G - 4 sigma T^4),   e = sum_m K_a,m sigma T_m^4,   T = T_w on walls of given temperature

by Newton's method over all nodal temperatures; what the radiation loses the medium
gains, to round-off. Anisotropic scattering enters as K_s (1 - g), as in P1.
"""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.sparse import csc_matrix

from contbed.closures.optics import SIGMA
from contbed.fem.elements import Space
from contbed.mesh.mesh import Mesh
from contbed.radiation.equations import p1 as radiation
from contbed.radiation.equations.ordinates import Ordinates, OrdinatesSolution, Wall
from contbed.radiation.optics import optics
from contbed.radiation.problem import span, surface_of, temperature_of_medium
from contbed.radiation.scene import Radiating
from contbed.solvers.linear import Policy, Solver, constrain
from contbed.solvers.newton import Options, newton


class OrdinatesProblem:
    """The scene's medium on a line; the state holds temperatures at the points of a
    conducting medium.
    """

    def __init__(self, scene: Radiating, mesh: Mesh, section: float = 1.0):
        table = scene.radiation
        assert table is not None
        self.scene, self.mesh, self.section, self.optics = (
            scene,
            mesh,
            section,
            optics(scene),
        )
        self.conductivity = table.conductivity or 0.0
        c = self.optics
        scattering = c.scattering * (1.0 - table.anisotropy)
        absorption = c.passive
        if self.conductivity:
            absorption += c.active
        else:
            scattering += c.active
        z = np.sort(mesh.skfem.p[0])
        found = {name: surface_of(scene.boundary.get(name)) for name in mesh.boundaries}
        self.surfaces = [
            (name, None, surface)
            for name, surface in found.items()
            if surface is not None
        ]
        self.ends = {name: self._end(name, z) for name in mesh.boundaries}
        walls = {
            self.ends[name]: Wall(surface.power, surface.emissivity)
            for name, _, surface in self.surfaces
        }
        degree = scene.solver.degree
        self.bed = Ordinates(
            z,
            absorption,
            scattering,
            walls.get(0),
            walls.get(-1),
            table.directions,
            degree,
        )
        self.space = Space(mesh.skfem, degree)
        self._fields: dict[bytes, OrdinatesSolution] = {}
        self._order = np.argsort(self.space.points[0])
        if self.conductivity:
            self.response, _ = self.bed.response()
            self.mass = self.bed.mass_matrix()
            self.stiffness = self._stiffness()
        wanted = {
            end: scene.boundary[name].radiation
            for name, end in self.ends.items()
            if end in walls
        }
        given = {
            end: condition.temperature
            for end, condition in wanted.items()
            if condition and condition.temperature
        }
        self.fixed_values = given if self.conductivity else {}

    def _end(self, name: str, z: Any) -> int:
        """Return 0 for the boundary at the first node, -1 for the last."""
        grid = self.mesh.skfem
        return 0 if grid.p[0, grid.facets[0, grid.boundaries[name][0]]] == z[0] else -1

    def _stiffness(self) -> Any:
        """Return the conduction matrix, dense like the response; its rows sum to
        zero.
        """
        bed = self.bed
        matrix = np.zeros((len(bed.points), len(bed.points)))
        ones = np.ones((len(bed.width), len(bed.element.weights)))
        for cell, block in zip(
            bed.index, bed.element.stiffness(bed.width, ones), strict=True
        ):
            matrix[np.ix_(cell, cell)] += self.conductivity * block
        return matrix

    @property
    def fixed(self) -> Any:
        """Numbers of the points with the temperature of a wall."""
        return np.array(
            [end % len(self.bed.points) for end in self.fixed_values], dtype=np.int64
        )

    def _emission(self, T: Any) -> Any:
        """Return e = sum K_a,m sigma T_m^4 at the points [W/m3]."""
        return 0.25 * (self.optics.active * radiation.emitted(T) + self.optics.emission)

    def assemble(self, state: Any, jacobian: bool) -> tuple[Any, Any]:
        """Assemble the heat balance at the points [W] and its derivative."""
        if not self.conductivity:
            return np.zeros(0), None
        K, section = self.optics.active, self.section
        G = self.field(state).G
        # differences of temperature lose no digits to their level
        conducted = self.stiffness @ (state - state[0])
        residual = section * (conducted - self.mass @ radiation.absorbed(state, G, K))
        if not jacobian:
            return residual, None
        slope = 16.0 * SIGMA * state**3
        exchange = self.mass @ (
            K * (np.eye(len(state)) - 0.25 * K * self.response) * slope
        )
        return residual, csc_matrix(section * (self.stiffness + exchange))

    def solve(self, policy: Policy) -> tuple[Any, list[float]]:
        """Solve by Newton's method from the mean of the given temperatures.

        Without conduction one solution of the ordinates is enough.
        """
        if not self.conductivity:
            return np.zeros(0), [1.0]
        low, high = self.T_span
        state = np.full(len(self.bed.points), (0.5 * (low**4 + high**4)) ** 0.25)
        for end, T in self.fixed_values.items():
            state[end] = T
        options = Options.of(self.scene, lower=0.0, what="radiation")
        state, history = newton(self.assemble, state, self.fixed, policy, options)
        # one step with the matrix of the solution itself closes the balance to
        # round-off
        residual, matrix = self.assemble(state, True)
        residual[self.fixed] = 0.0
        return state - Solver(constrain(matrix, self.fixed), policy)(residual), history

    @property
    def T_span(self) -> tuple[float, float]:
        """Lowest and highest given temperature."""
        return span(self.optics, self.surfaces)

    def field(self, state: Any) -> OrdinatesSolution:
        """Return the radiation field of a state; the last one is kept."""
        key = state.tobytes()
        if key not in self._fields:
            emission = (
                self._emission(state)
                if self.conductivity
                else 0.25 * self.optics.emission
            )
            self._fields = {key: self.bed.solve(emission)}
        return self._fields[key]

    def _net(self, state: Any, field: OrdinatesSolution) -> Any:
        """Return the net emission at the points, q' [W/m3]."""
        c = self.optics
        net = c.emission - c.passive * field.G
        return (
            net - radiation.absorbed(state, field.G, c.active)
            if self.conductivity
            else net
        )

    def _nodal(self, values: Any) -> Any:
        """Interpolate values at the points of the ordinates (Lobatto) to the
        equispaced nodes of the space.
        """
        element, nodes = self.bed.element, self.space.element.nodes[:, 0]
        lattice = np.sort(nodes)
        table = np.linalg.solve(
            np.vander(element.points).T, np.vander(lattice, len(lattice)).T
        ).T
        local = values[self.bed.index] @ table.T
        out = np.empty(self.space.size)
        out[self._order] = np.append(local[:, :-1].ravel(), local[-1, -1])
        return out

    def incident(self, state: Any) -> Any:
        """Return G at the nodes [W/m2]."""
        return self._nodal(self.field(state).G)

    def temperature(self, state: Any) -> Any:
        """Return the temperatures at the nodes [K].

        They are solved for, given, or those of a medium that emits what it absorbs.
        """
        if self.conductivity:
            return self._nodal(state)
        return temperature_of_medium(self.optics, self.incident(state))

    def flux(self, state: Any, probe: Any) -> Any:
        """Return the radiative flux at the points of a probe [W/m2].

        It is that at the ends of a cell plus what the cell emits in between.
        """
        field, element = self.field(state), self.bed.element
        count = element.degree + 1
        powers = np.arange(1, count + 1)
        moments = np.linalg.inv(np.vander(element.points, increasing=True))
        before = (element.points[:, None] ** powers / powers) @ moments
        net = self._net(state, field)[self.bed.index]
        local = field.q[:-1, None] + self.bed.width[:, None] * (net @ before.T)
        values = np.append(local[:, :-1].ravel(), field.q[-1])
        return probe(self.space, self._nodal(values))

    def fluxes(self, state: Any) -> dict[str, float]:
        """Return the radiation into the bed through each boundary [W]."""
        q = self.field(state).q
        inward = {0: q[0], -1: -q[-1]}
        return {
            name: self.section * float(inward[end]) for name, end in self.ends.items()
        }

    def conducted(self, residual: Any) -> dict[str, float]:
        """Return the heat that walls conduct into the medium [W], from an
        unconstrained residual.
        """
        return {
            name: float(residual[end]) if end in self.fixed_values else 0.0
            for name, end in self.ends.items()
        }

    def rounding(self, state: Any) -> float:
        """Return what the last digit of the temperatures makes of conducted and
        emitted heat, over all points [W].
        """
        if not self.conductivity:
            return 0.0
        parts = np.abs(self.stiffness) @ np.abs(state) + self.mass @ (
            self.optics.active * radiation.emitted(state)
        )
        return self.section * float(np.finfo(float).eps * np.linalg.norm(parts))

    def released(self, state: Any) -> float:
        """Return what species of given temperature emit less what they absorb [W]."""
        c = self.optics
        net = c.emission - c.passive * self.field(state).G
        return self.section * float((self.bed.mass_matrix() @ net).sum())
