"""Coefficients of a reacting bed at a state: closures, films, dispersion,
resistance, from the scene.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np

from contbed.chemistry.local import SHARPEST, Local, Smoothing
from contbed.chemistry.thermo import R_GAS
from contbed.closures.binding import BoundClosure, is_phase
from contbed.closures.packed_beds import SURFACE, Packing, comoving_velocity
from contbed.closures.ranges import RangeUse
from contbed.errors import SceneError
from contbed.materials.curve import Function, function_of
from contbed.reacting_bed import scene as s
from contbed.reacting_bed.closures import given, of_bed, of_phase
from contbed.reacting_bed.equations.unknowns import LEAST_T, State
from contbed.reacting_bed.gas_properties import Properties
from contbed.reacting_bed.inlet_series import constant
from contbed.reacting_bed.streams import (
    Streams,
    mean_conductivity,
    mean_diameter,
    sauter_mean,
)
from contbed.reacting_bed.substances import Substances

# share of the speed below which |U| is rounded, so that a change of sign is smooth
SLOW = 1e-9


@dataclass(frozen=True)
class PhaseTransport:
    """Coefficients of one solid phase at points: exchange [W/m3/K],
    conductivity [W/m/K] by its share, films [m/s].
    """

    exchange: Any = 0.0
    conductivity_solid: Any = 0.0
    films: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Transport:
    """Coefficients of a bed at points; see `equations.bed`."""

    conductivity_fluid: Any = 0.0
    wall: Any = 0.0
    pressure_gradient: Any = 0.0
    dispersion: Mapping[str, Any] | None = None
    phases: Mapping[str, PhaseTransport] = field(default_factory=dict)

    @property
    def conductivity(self) -> Any:
        """Conductivity of gas and particles [W/m/K]."""
        return sum(
            (each.conductivity_solid for each in self.phases.values()),
            self.conductivity_fluid,
        )


class At(NamedTuple):
    """What a bed or a solid phase gives closures: `closures`, the properties of the
    gas, and the diffusivity of one gas [m2/s].
    """

    closures: Any
    properties: Properties
    D_gas: Any

    @property
    def eps(self) -> float:
        """Porosity."""
        return float(self.closures.porosity)

    @property
    def d_p(self) -> float:
        """Diameter of the particles [m]."""
        return float(self.closures.diameter)

    @property
    def D_bed(self) -> float:
        """Diameter of the bed [m]; far more than that of the particles without one."""
        width = self.closures.scene.mesh.diameter
        return float(1e3 * self.d_p if width is None else width)

    @property
    def v(self) -> Any:
        """Speed of the gas between the particles [m/s]."""
        return np.abs(self.properties.state.u) / self.eps

    @property
    def T(self) -> Any:
        """Temperature of the particles [K]."""
        return self.properties.state.T_solid

    @property
    def Re(self) -> Any:
        """Particle Reynolds number."""
        return self.closures.reynolds(self.properties)

    @property
    def Pr(self) -> Any:
        """Prandtl number."""
        return self.properties.prandtl

    @property
    def Pe(self) -> Any:
        """Particle Peclet number."""
        return self.Re * self.Pr

    @property
    def Sc(self) -> Any:
        """Schmidt number of the gas."""
        properties = self.properties
        return properties.viscosity / (properties.state.rho * self.D_gas)

    @property
    def k_fluid(self) -> Any:
        """Conductivity of the gas [W/m/K]."""
        return self.properties.k_fluid

    @property
    def k_solid(self) -> Any:
        """Conductivity of the particles [W/m/K]."""
        return self.closures.k_solid(self.properties)

    @property
    def k_stagnant(self) -> Any:
        """Conductivity across the bed without dispersion [W/m/K]."""
        return self.closures.stagnant(self.properties)


@dataclass(frozen=True, eq=False)
class Closures:
    """Closures and numbers of a scene by the key of each, evaluated at a state of a
    packing.

    diameter : of the particles [m]
    conductivity : of the particles [W/m/K] as a function of temperature
    velocity_solid : superficial velocity of the particles [m/s]
    """

    scene: s.ReactingScene
    species: Substances
    specs: Mapping[str, Any]
    bound: Mapping[str, BoundClosure]
    diameter: float
    conductivity: Function | None
    velocity_solid: float

    @property
    def porosity(self) -> float:
        """Porosity of the bed."""
        return self.scene.packed_bed.porosity

    def value(self, key: str, properties: Properties, D: Any = None) -> Any:
        """Return the value of a closure at a state, of one for a gas with its
        diffusivity [m2/s]; a number as it is.
        """
        if key not in self.bound:
            return self.specs[key]
        return self.bound[key].at(At(self, properties, D))

    def reynolds(self, properties: Properties) -> Any:
        """Return the Reynolds number of the particles, on the velocity relative to
        them.
        """
        slip, d = self.slip(properties.state), self.diameter
        return properties.once(
            f"Re {d!r} {self.velocity_solid!r}", lambda: properties.reynolds(d, slip)
        )

    def conductivity_of(self, key: str, properties: Properties, phase: str) -> Any:
        """Return an effective conductivity; 0 where none is given, that of a phase
        by its volume for "phase".
        """
        spec = self.specs.get(key)
        if spec is None:
            return 0.0
        if is_phase(spec):
            eps = self.porosity
            return (
                eps * properties.k_fluid
                if phase == "fluid"
                else (1.0 - eps) * self.k_solid(properties)
            )
        return self.value(key, properties)

    def k_solid(self, properties: Properties) -> Any:
        """Return the conductivity of the particles at their temperature [W/m/K].

        Raises
        ------
        SceneError : it is not given
        """
        if self.conductivity is None:
            solids, origin = self.scene.solids, self.scene.origin
            name = next(k for k, table in solids.items() if table.conductivity is None)
            where = origin.place(("solids", name, "conductivity"))
            raise SceneError(f"{where}: missing; a closure of a conductivity needs it")
        return self.conductivity(properties.state.T_solid)

    def slip(self, state: State) -> Any:
        """Return the superficial velocity relative to the particles [m/s]."""
        return state.u - comoving_velocity(self.velocity_solid, self.porosity)

    def used(self) -> list[RangeUse]:
        """Return how each closure was used in its last evaluation."""
        return [
            closure.use()
            for closure in self.bound.values()
            if closure._last is not None
        ]


@dataclass(frozen=True, eq=False)
class PhaseMedium(Closures):
    """One solid phase of the bed of a scene.

    shape : of its particles
    share : of the volume of all particles
    density : mass of its particles per volume of bed [kg/m3]
    """

    shape: str
    share: float
    density: float

    @cached_property
    def area(self) -> float:
        """Specific surface of the particles [1/m]."""
        return SURFACE[self.shape] * (1.0 - self.porosity) / self.diameter * self.share

    @cached_property
    def solids(self) -> float:
        """Volume of the particles per volume of bed."""
        return (1.0 - self.porosity) * self.share

    def at(self, properties: Properties) -> PhaseTransport:
        """Return the coefficients at a state."""
        exchange: Any = 0.0
        if "nusselt" in self.specs:
            exchange = (
                self.value("nusselt", properties)
                * properties.k_fluid
                * (self.area / self.diameter)
            )
        K = self.share * self.conductivity_of(
            "conductivity_solids", properties, "solid"
        )
        films = self._films(properties) if "sherwood" in self.specs else {}
        return PhaseTransport(exchange, K, films)

    def across(self, properties: Properties) -> Any:
        """Return the conductivity across the flow, by the share of the
        volume [W/m/K].
        """
        return self.share * self.conductivity_of(
            "section.conductivity_solids", properties, "solid"
        )

    def _films(self, properties: Properties) -> dict[str, Any]:
        """Return the coefficient of the film of each gas [m/s]."""
        out = {}
        for name, D in zip(self.species.gases, properties.diffusivities, strict=True):
            Sh = self.value("sherwood", properties, D)
            out[name] = Sh * D * (1.0 / self.diameter)
        return out

    def local(
        self,
        state: State,
        transport: PhaseTransport,
        reaction: Any,
        small: Smoothing | None = None,
        inner: Mapping[str, Any] | None = None,
    ) -> Local:
        """Return the state as a reaction sees it, with intraparticle concentrations
        `inner` of gases.
        """
        at_surface = reaction.site != "gas" and state.films and not reaction.own_film
        c = {**state.c, **state.films} if at_surface else state.c
        if inner:
            c = {**c, **inner}
        x = state.x
        if c is not state.c:
            total = state.p / (R_GAS * np.maximum(state.T_fluid, LEAST_T))
            x = {name: value / total for name, value in c.items()}
        return Local(
            np.maximum(
                state.T_fluid if reaction.site == "gas" else state.T_solid, LEAST_T
            ),
            state.p,
            c,
            x,
            state.n,
            self.porosity,
            self.solids,
            0.5 * self.diameter,
            self.density,
            transport.films,
            small or SHARPEST,
        )


@dataclass(frozen=True, eq=False)
class Medium(Closures):
    """The bed of a scene: its gas, the wall, and solid phases by name.

    `diameter`, `conductivity` and `velocity_solid` are means of all phases.
    """

    with_pressure: bool
    phases: Mapping[str, PhaseMedium]

    @classmethod
    def of(
        cls,
        scene: s.ReactingScene,
        species: Substances,
        entering: Streams,
        with_pressure: bool,
    ) -> Medium:
        """Bind the closures of a scene."""
        phases = {}
        for name, table in scene.solids.items():
            k = table.conductivity
            phases[name] = PhaseMedium(
                scene,
                species,
                *given(scene, of_phase(scene, table)),
                table.diameter,
                None if k is None else function_of(k),
                entering.velocities[name],
                table.shape,
                entering.shares[name],
                entering.densities[name],
            )
        return cls(
            scene,
            species,
            *given(scene, of_bed(scene)),
            mean_diameter(scene.solids),
            mean_conductivity(scene.solids),
            entering.mean_velocity,
            with_pressure,
            phases,
        )

    def within(self, scene: s.ReactingScene, entering: Streams) -> Medium:
        """Return the medium with the streams and surroundings of a scene that
        differs in nothing else.
        """
        phases = {
            name: replace(phase, scene=scene, velocity_solid=entering.velocities[name])
            for name, phase in self.phases.items()
        }
        return replace(
            self, scene=scene, velocity_solid=entering.mean_velocity, phases=phases
        )

    def at(self, state: State) -> Transport:
        """Return the coefficients at a state."""
        properties = Properties(self.scene, self.species, state)
        K_f = self.conductivity_of("conductivity_gas", properties, "fluid")
        if "dispersion" in self.specs:
            K_f = K_f + self.value("dispersion", properties)
        wall, width = self.scene.wall, self.scene.mesh.diameter
        q_wall: Any = 0.0
        if (
            self.scene.heat is not None
            and wall is not None
            and self.scene.section is None
        ):
            assert width is not None  # `checks` sees to it
            q_wall = self.through_wall(state.T_fluid, wall.coefficient) * (4.0 / width)
        gradient = self.resistance(state, properties) if self.with_pressure else 0.0
        dispersion = self._dispersion("dispersion_mass", properties)
        phases = {
            name: phase.at(properties.of(name)) for name, phase in self.phases.items()
        }
        return Transport(K_f, q_wall, gradient, dispersion, phases)

    def radial(self, state: State) -> Transport:
        """Return the coefficients across the flow: conductivities, of each phase by
        its share, and dispersion.
        """
        properties = Properties(self.scene, self.species, state)
        K_f = self.conductivity_of("section.conductivity_gas", properties, "fluid")
        if "section.dispersion" in self.specs:
            K_f = K_f + self.value("section.dispersion", properties)
        dispersion = self._dispersion("section.dispersion_mass", properties)
        phases = {
            name: PhaseTransport(conductivity_solid=phase.across(properties.of(name)))
            for name, phase in self.phases.items()
        }
        return Transport(conductivity_fluid=K_f, dispersion=dispersion, phases=phases)

    def stagnant(self, properties: Properties) -> Any:
        """Return the conductivity of gas and particles across the flow without
        dispersion [W/m/K].
        """
        K_f = self.conductivity_of("section.conductivity_gas", properties, "fluid")
        return sum(
            (phase.across(properties.of(name)) for name, phase in self.phases.items()),
            K_f,
        )

    def wall_coefficient(self, state: State) -> Any:
        """Return the coefficient of the wall [W/m2/K] at a state beside it, None for
        a wall with a given flux.
        """
        if "coefficient" not in self.specs:
            return None
        return self.value("coefficient", Properties(self.scene, self.species, state))

    def through_wall(
        self, T: Any, coefficient: Any, K: Any = 1.0, distance: float = 0.0
    ) -> Any:
        """Return the heat through the wall into the bed [W/m2 of wall] from a
        temperature at a distance [m] from it.

        K is the conductivity between both [W/m/K], `coefficient` that of the wall.
        """
        wall = self.scene.wall
        if wall is None or (wall.heat_flux is None and wall.ambient is None):
            return 0.0
        if wall.heat_flux is not None:
            return constant(wall.heat_flux)
        if distance:
            coefficient = coefficient / (1.0 + (coefficient * distance) / K)
        return coefficient * (constant(wall.ambient) - T)

    def resistance(self, state: State, properties: Properties | None = None) -> Any:
        """Return -dp/dx [Pa/m] by permeability and Forchheimer coefficient, on the
        velocity to particles.
        """
        properties = properties or Properties(self.scene, self.species, state)
        K, c_F = self.permeability, self.value("forchheimer", properties)
        U = self.slip(state)
        speed = np.abs(U) if not hasattr(U, "tangents") else (U * U + SLOW**2) ** 0.5
        return properties.viscosity * U / K + c_F * state.rho * speed * U / K**0.5

    @cached_property
    def permeability(self) -> Any:
        """Permeability of the bed [m2]."""
        if "permeability" not in self.bound:
            return self.specs["permeability"]
        closure, surface = self.bound["permeability"], sauter_mean(self.scene.solids)
        name = closure.sheet.name
        return closure.at(Packing.of(name, self.porosity, self.diameter, surface))

    def local(self, state: State, small: Smoothing | None = None) -> Local:
        """Return the state as a reaction in the gas sees it."""
        return Local(
            np.maximum(state.T_fluid, LEAST_T),
            state.p,
            state.c,
            state.x,
            state.n,
            self.porosity,
            1.0 - self.porosity,
            0.5 * self.diameter,
            sum(phase.density for phase in self.phases.values()),
            {},
            small or SHARPEST,
        )

    def _dispersion(self, key: str, properties: Properties) -> dict[str, Any] | None:
        """Return the dispersion of each gas [m2/s]; None without dispersion."""
        if key not in self.specs:
            return None
        if key not in self.bound:
            return dict.fromkeys(self.species.gases, self.specs[key])
        gases = zip(self.species.gases, properties.diffusivities, strict=True)
        return {name: self.value(key, properties, D) for name, D in gases}

    def ranges(self) -> list[RangeUse]:
        """Return how each closure of the bed and of its solid phases was used in its
        last evaluation.
        """
        return [use for each in (self, *self.phases.values()) for use in each.used()]
