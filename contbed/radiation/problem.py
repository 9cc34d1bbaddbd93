"""The radiation of one scene: optics from its particles, coupling to the two-energy
model, and a stand-alone medium.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from contbed.closures import optics as closures
from contbed.closures.optics import SIGMA
from contbed.fem import system as make_system
from contbed.fem.skfem import System
from contbed.mesh.mesh import Mesh
from contbed.radiation.equations import p1 as radiation
from contbed.radiation.optics import Optics, optics
from contbed.radiation.scene import Radiating
from contbed.solvers.linear import Policy, Solver, constrain
from contbed.solvers.newton import Options, newton

REFINEMENTS = 3  # of a linear solution
# optical thickness from which the diffusion limit is closer to the solution than one
# temperature
THICK = 100.0


def surface_of(table: Any) -> radiation.Surface | None:
    """Return a boundary as a radiating surface; None for a mirror."""
    condition = None if table is None else table.radiation
    if condition is None:
        return None
    if condition.temperature is not None:
        return radiation.Surface(condition.emissivity, SIGMA * condition.temperature**4)
    return radiation.Surface(1.0, float(condition.radiosity or 0.0))


def surfaces(
    scene: Radiating, mesh: Mesh, system: System
) -> list[tuple[str, Any, radiation.Surface]]:
    """Return the radiating boundaries as (name, domain, surface)."""
    found = {name: surface_of(scene.boundary.get(name)) for name in mesh.boundaries}
    return [
        (name, part, surface)
        for name, surface in found.items()
        if surface
        for part in system.boundary(name)
    ]


def span(
    c: Optics, surfaces: list[tuple[str, Any, radiation.Surface]]
) -> tuple[float, float]:
    """Return the lowest and highest given temperature [K]; a radiosity counts as
    that of a black surface.
    """
    found = [power_temperature(surface.power) for _, _, surface in surfaces]
    if c.passive:
        found.append(power_temperature(c.emission / (4.0 * c.passive)))
    return min(found), max(found)


def boundary_fluxes(
    found: list[tuple[str, Any, radiation.Surface]], system: System, state: Any
) -> dict[str, float]:
    """Return the radiation into the bed through each radiating boundary [W]."""
    out: dict[str, float] = {}
    for name, part, surface in found:

        def supplied(
            unknowns: Any, o: Any, surface: radiation.Surface = surface
        ) -> Any:
            return radiation.supplied(unknowns, surface, o)

        out[name] = out.get(name, 0.0) + system.integrate(supplied, [part], state)
    return out


def emission(
    c: Optics,
    found: list[tuple[str, Any, radiation.Surface]],
    mesh: Mesh,
    section: float,
) -> float:
    """Return what black walls and species of given temperature emit [W].

    It is the scale of the energy balance, because a small net flux is a difference of
    such emissions.
    """
    walls = [
        surface.power * (section if part is None else float(np.sum(part.weight)))
        for _, part, surface in found
    ]
    return sum(walls) + (c.emission * mesh.measure() * section if c.passive else 0.0)


def net_emission(c: Optics, system: System, state: Any) -> float:
    """Return what species of given temperature emit less what they absorb [W]."""
    return system.integrate(
        lambda unknowns, o: c.emission - c.passive * unknowns.G, [system.cells], state
    )


class RadiationCoupling:
    """Radiation coupled to the two-energy equations: its forms, and what the solid
    absorbs.
    """

    fields = radiation.FIELDS
    emitted = staticmethod(radiation.emitted)

    def __init__(self, scene: Radiating):
        self.scene, self.optics = scene, optics(scene)
        c = self.optics
        self.coefficients = radiation.Coefficients(
            {"T_solid": c.active}, c.diffusion, c.emission, c.passive
        )

    def interior(self, cells: Any) -> tuple[Any, Any, Any]:
        """Return the form of the balance of the incident radiation."""
        return radiation.residual, cells, self.coefficients

    def boundaries(self, mesh: Mesh, system: System) -> list[tuple[Any, Any, Any]]:
        """Return the forms of walls and openings."""
        forms = [
            (radiation.boundary, part, surface)
            for _, part, surface in surfaces(self.scene, mesh, system)
        ]
        sink = self._tubes(mesh)
        return (
            forms if sink is None else [*forms, (radiation.tubes, system.cells, sink)]
        )

    def _tubes(self, mesh: Mesh) -> radiation.Tubes | None:
        """Return the tubes of all regions as one value in each cell (ncells, 1)."""
        given = {
            name: region.tubes
            for name, region in self.scene.region.items()
            if region.tubes is not None
        }
        if not given:
            return None
        area, power = np.zeros((2, mesh.skfem.nelements, 1))
        bed = closures.radiation_emissivity_half_space(
            self.optics.scattering / self.optics.extinction
        )
        for name, item in given.items():
            cells = mesh.skfem.subdomains[name]
            area[cells] = item.area * closures.emissivity_immersed(bed, item.emissivity)
            power[cells] = SIGMA * item.temperature**4
        return radiation.Tubes(area, power)

    def net_absorption(self, unknowns: Any) -> Any:
        """Return the radiation that the solid absorbs less what it emits [W/m3]."""
        return radiation.absorbed(unknowns.T_solid, unknowns.G, self.optics.active)

    def temperatures(self, mesh: Mesh) -> list[float]:
        """Return the temperatures of walls, species, and black surfaces of a
        radiosity [K].
        """
        table = self.scene.radiation
        assert table is not None
        conditions = [
            self.scene.boundary[name].radiation
            for name in mesh.boundaries
            if name in self.scene.boundary
        ]
        tubes = [region.tubes for region in self.scene.region.values()]
        found = [
            item.temperature
            for item in (*conditions, *self.scene.solids.values(), *tubes)
            if item is not None
        ]
        entering = [
            item.radiosity
            for item in conditions
            if item is not None and item.radiosity is not None
        ]
        return [T for T in found if T is not None] + [
            float(power_temperature(power)) for power in entering
        ]

    def emission(self, mesh: Mesh, system: System) -> float:
        """Return what black walls and species of given temperature emit [W]."""
        return emission(
            self.optics,
            surfaces(self.scene, mesh, system),
            mesh,
            system.measure.get("section", 1.0),
        )

    def fluxes(self, mesh: Mesh, system: System, state: Any) -> dict[str, float]:
        """Return the radiation into the bed through each boundary [W]."""
        return boundary_fluxes(surfaces(self.scene, mesh, system), system, state)

    def inside(self, mesh: Mesh, system: System, state: Any) -> dict[str, float]:
        """Return the radiation into the bed [W] from "species" of given temperature
        and from "tubes".
        """
        out: dict[str, float] = {}
        if self.optics.passive:
            out["species"] = net_emission(self.optics, system, state)
        sink = self._tubes(mesh)
        if sink is not None:
            out["tubes"] = -system.integrate(
                lambda unknowns, o: radiation.taken_by_tubes(unknowns, sink, o),
                [system.cells],
                state,
            )
        return out


class RadiationProblem:
    """A medium that radiates and may conduct: unknown G, and `T_solid` where it
    conducts; see `equations.p1`.

    Without conductivity and temperature the medium is in radiative equilibrium: it
    emits what it absorbs.
    """

    def __init__(self, scene: Radiating, mesh: Mesh, section: float = 1.0):
        table = scene.radiation
        assert table is not None
        self.scene, self.mesh, self.optics = scene, mesh, optics(scene)
        self.conductivity = table.conductivity or 0.0
        self.equilibrium = not self.conductivity and not self.optics.passive
        degree = scene.solver.degree
        fields = {"G": (degree, 0)} | (
            {"T_solid": (degree, 0)} if self.conductivity else {}
        )
        self.system = make_system(
            mesh, fields, 2 * degree + (4 if self.conductivity else 1), section
        )
        active = {"T_solid": self.optics.active} if self.conductivity else {}
        c = radiation.Coefficients(
            active, self.optics.diffusion, self.optics.emission, self.optics.passive
        )
        self.surfaces = surfaces(scene, mesh, self.system)
        self.forms: list[Any] = [(radiation.residual, self.system.cells, c)]
        self.forms += [
            (radiation.boundary, part, surface) for _, part, surface in self.surfaces
        ]
        if self.conductivity:
            self.forms.append((self._conduction, self.system.cells, None))
        self.fixed, self.fixed_values, self.fixed_owner = self._fixed()

    def _conduction(self, unknowns: Any, tests: Any, c: Any, o: Any) -> Any:
        gain = radiation.absorbed(unknowns.T_solid, unknowns.G, self.optics.active)
        return (
            self.conductivity * o.dot(o.grad(unknowns.T_solid), o.grad(tests.T_solid))
            - gain * tests.T_solid
        )

    def _fixed(self) -> tuple[Any, Any, Any]:
        """Return nodes, values and boundary numbers of fixed temperatures.

        A conducting medium has the temperature of the walls it touches.
        """
        nodes, values, owners = (
            [np.empty(0, dtype=np.int64)],
            [np.empty(0)],
            [np.empty(0, dtype=np.int64)],
        )
        for k, name in enumerate(self.mesh.boundaries if self.conductivity else ()):
            table = self.scene.boundary.get(name)
            if (
                table is not None
                and table.radiation is not None
                and table.radiation.temperature is not None
            ):
                found = self.system.nodes("T_solid", self.mesh.skfem.boundaries[name])
                nodes.append(found)
                values.append(np.full(len(found), table.radiation.temperature))
                owners.append(np.full(len(found), k))
        unique, first = np.unique(np.concatenate(nodes), return_index=True)
        return unique, np.concatenate(values)[first], np.concatenate(owners)[first]

    def assemble(self, state: Any, jacobian: bool) -> tuple[Any, Any]:
        """Assemble the residual and the Jacobian."""
        return self.system.assemble(self.forms, state, jacobian)

    def solve(self, policy: Policy) -> tuple[Any, list[float]]:
        """Solve by Newton's method from the mean of the given temperatures; linear
        without conduction.

        Thick beds start from the diffusion limit, from which Newton's method needs a
        few steps instead of hundreds.
        """
        policy, state = self.system.ordered(policy), self.start()
        if not self.conductivity:
            return self._linear(state, policy), [1.0]
        thickness = self.optics.extinction * np.ptp(self.mesh.skfem.p, axis=1).max()
        if "G" in self.system.fields and len(self.fixed) and thickness > THICK:
            state = self._diffusion_limit(state, policy)
        lower = np.zeros(self.system.size)
        if "G" in self.system.fields:  # linear: may undershoot where cells are too few
            self.system.part(lower, "G")[:] = -np.inf
        options = Options.of(self.scene, lower=lower, what="radiation")
        return newton(self.assemble, state, self.fixed, policy, options)

    def start(self) -> Any:
        """Return the state at the mean of the given temperatures."""
        low, high = self.T_span
        middle = (0.5 * (low**4 + high**4)) ** 0.25
        state = np.full(self.system.size, middle)
        self.system.part(state, "G")[:] = radiation.emitted(middle)
        state[self.fixed] = self.fixed_values
        return state

    def _diffusion_limit(self, state: Any, policy: Policy) -> Any:
        """Return the state in which G = 4 sigma T^4 everywhere and k T + 4 D sigma
        T^4 is a harmonic function.
        """

        def harmonic(unknowns: Any, tests: Any, c: Any, o: Any) -> Any:
            return (
                o.dot(o.grad(unknowns.T_solid), o.grad(tests.T_solid))
                + unknowns.G * tests.G
            )

        potential = np.zeros(self.system.size)
        potential[self.fixed] = self._potential(self.fixed_values)
        residual, matrix = self.system.assemble(
            [(harmonic, self.system.cells, None)], potential, True
        )
        residual[self.fixed] = 0.0
        potential = potential - Solver(constrain(matrix, self.fixed), policy)(residual)
        low, high = self.T_span
        # temperatures between which the start is interpolated
        known = np.linspace(low, high, 10_000)
        T = np.interp(
            self.system.part(potential, "T_solid"), self._potential(known), known
        )
        self.system.part(state, "T_solid")[:] = T
        self.system.part(state, "G")[:] = radiation.emitted(T)
        state[self.fixed] = self.fixed_values
        return state

    def _potential(self, T: Any) -> Any:
        """Return the potential of conduction and radiation in the diffusion
        limit [W/m].
        """
        return self.conductivity * T + self.optics.diffusion * radiation.emitted(T)

    def _linear(self, state: Any, policy: Policy) -> Any:
        """Solve once and refine: in thin media the fluxes are small differences of
        G.
        """
        residual, matrix = self.assemble(state, True)
        solver = Solver(matrix, policy)
        for _ in range(REFINEMENTS):
            state = state - solver(residual)
            residual, _ = self.assemble(state, False)
        return state

    @property
    def T_span(self) -> tuple[float, float]:
        """Lowest and highest given temperature."""
        return span(self.optics, self.surfaces)

    @property
    def space(self) -> Any:
        """The space of G and of the temperature."""
        return self.system.fields["G"][0]

    def incident(self, state: Any) -> Any:
        """Return G at the nodes [W/m2]."""
        return self.system.part(state, "G")

    def flux(self, state: Any, probe: Any) -> Any:
        """Return the radiative flux along the axis at the points of a probe [W/m2]."""
        return -self.optics.diffusion * probe.slope(
            self.space, self.incident(state), self.mesh.axis
        )

    def temperature(self, state: Any) -> Any:
        """Return nodal temperatures: solved for, given, or those of species that
        emit what they absorb.
        """
        if self.conductivity:
            return self.system.part(state, "T_solid")
        return temperature_of_medium(self.optics, self.incident(state))

    def fluxes(self, state: Any) -> dict[str, float]:
        """Return the radiation into the bed through each boundary [W]."""
        return dict.fromkeys(self.mesh.boundaries, 0.0) | boundary_fluxes(
            self.surfaces, self.system, state
        )

    def conducted(self, residual: Any) -> dict[str, float]:
        """Return the heat that walls conduct into the medium [W], from an
        unconstrained residual.
        """
        sums = np.bincount(
            self.fixed_owner,
            weights=residual[self.fixed],
            minlength=len(self.mesh.boundaries),
        )
        return {
            name: float(value)
            for name, value in zip(self.mesh.boundaries, sums, strict=True)
        }

    def rounding(self, state: Any) -> float:
        """Return what the last digit of temperatures and G makes of the heat
        balance, over all nodes [W].
        """
        if not self.conductivity:
            return 0.0
        _, matrix = self.assemble(state, True)
        parts = self.system.part(abs(matrix) @ np.abs(state), "T_solid")
        return float(np.finfo(float).eps * np.linalg.norm(parts))

    def released(self, state: Any) -> float:
        """Return what species of given temperature emit less what they absorb [W]."""
        return net_emission(self.optics, self.system, state)


def temperature_of_medium(c: Optics, incident: Any) -> Any:
    """Return the temperatures [K] at which a medium that does not conduct is given, or
    emits what it absorbs of G [W/m2].
    """
    if c.passive and not c.active:
        T = power_temperature(c.emission / (4.0 * c.passive))
        return np.full_like(incident, T)
    return power_temperature(incident / 4.0)


def power_temperature(power: Any) -> Any:
    """Return the temperature [K] of a black surface of emissive power [W/m2]."""
    return (np.maximum(power, 0.0) / SIGMA) ** 0.25
