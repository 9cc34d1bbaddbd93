"""Coefficients of a reacting bed at a state: closures, films, dispersion, resistance, from the scene."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np

from contbed.closures.binding import BoundClosure, bind, is_phase, named
from contbed.closures.ranges import RangeUse
from contbed.closures.reactions import R_GAS
from contbed.errors import SceneError
from contbed.reacting_bed import scene as s
from contbed.reacting_bed.equations.unknowns import LEAST_T, State
from contbed.reacting_bed.inlet_series import constant
from contbed.reacting_bed.local import SHARPEST, Local, Smoothing
from contbed.reacting_bed.substances import Substances
from contbed.scene.tables import Closure

_AREA = {"spheres": 6.0, "rods": 4.0}
_PACKING = ("eps", "d_p")
_STREAM = (*_PACKING, "Re", "Pr", "Pe", "T", "k_fluid", "D_bed")
GIVES: Mapping[str, tuple[str, ...]] = {
    "permeability": _PACKING,
    "forchheimer": _PACKING,
    "nusselt": _STREAM,
    "dispersion": _STREAM,
    "conductivity": ("eps", "d_p", "k_fluid", "k_solid", "T"),
    "wall": (*_STREAM, "k_stagnant"),
    "sherwood": (*_PACKING, "Re", "Sc"),
    "mass_dispersion": (*_PACKING, "v", "D_gas"),
}
CONDUCTIVITIES = ("conductivity_fluid", "conductivity_solid")
SLOW = 1e-9  # share of the speed below which |U| is rounded, so that a change of sign is smooth


def places_of(
    bed: s.Bed, heat: s.Heat | None, mass: s.Mass | None, section: s.Section | None, wall: s.Wall | None
) -> list[tuple[tuple[str, ...], Any, str]]:
    """Return (key, value, kind) of each place where a scene may name a closure."""
    out: list[tuple[tuple[str, ...], Any, str]] = [
        (("bed", kind), getattr(bed, kind), kind) for kind in ("permeability", "forchheimer")
    ]
    if heat is not None:
        out.append((("heat", "nusselt"), heat.nusselt, "nusselt"))
        out += [(("heat", key), getattr(heat, key), "conductivity") for key in CONDUCTIVITIES]
        out.append((("heat", "dispersion"), heat.dispersion, "dispersion"))
    if mass is not None:
        out.append((("mass", "sherwood"), mass.sherwood, "sherwood"))
        out.append((("mass", "dispersion"), mass.dispersion, "mass_dispersion"))
    if section is not None:
        out += [(("section", key), getattr(section, key), "conductivity") for key in CONDUCTIVITIES]
        out.append((("section", "dispersion"), section.dispersion, "dispersion"))
        out.append((("section", "mass_dispersion"), section.mass_dispersion, "mass_dispersion"))
    if wall is not None:
        out.append((("wall", "coefficient"), wall.coefficient, "wall"))
    return out


def bound(spec: Any, kind: str, base: Any, direction: str = "axial") -> BoundClosure:
    """Return the closure that a scene names; of a pair for dispersion that of a direction, axial or transverse."""
    if kind == "dispersion" and isinstance(spec, str | Closure):
        name = spec if isinstance(spec, str) else spec.name
        full = name if name.startswith("dispersion_") else f"dispersion_{name}"
        full = full if full.endswith(f"_{direction}") else f"{full}_{direction}"
        spec = full if isinstance(spec, str) else spec.model_copy(update={"name": full})
    return bind(spec, kind, GIVES[kind], base)


@dataclass(frozen=True)
class Transport:
    """Coefficients at points; see `equations.bed`."""

    exchange: Any = 0.0
    conductivity_fluid: Any = 0.0
    conductivity_solid: Any = 0.0
    wall: Any = 0.0
    pressure_gradient: Any = 0.0
    dispersion: Mapping[str, Any] | None = None
    films: Mapping[str, Any] = field(default_factory=dict)
    kinds: Mapping[str, Transport] = field(default_factory=dict)  # of each of several kinds of particles


@dataclass(frozen=True, eq=False)
class Medium:
    """The bed of a scene. `solids_density` is the mass of particles per volume of bed [kg/m3]."""

    scene: s.ReactingScene
    species: Substances
    velocity_solid: float  # superficial [m/s]
    solids_density: float
    with_pressure: bool
    closures: Mapping[str, BoundClosure]
    share: float = 1.0  # of the volume of all particles, of one of several kinds
    kinds: Mapping[str, Medium] = field(default_factory=dict)  # of each of several kinds of particles

    @classmethod
    def of(cls, scene: s.ReactingScene, species: Substances, solids_density: float, with_pressure: bool) -> Medium:
        """Bind the closures of a scene."""
        found = {}
        for path, spec, kind in places_of(scene.bed, scene.heat, scene.mass, scene.section, scene.wall):
            if named(spec) and not (kind == "conductivity" and is_phase(spec)):
                direction = "transverse" if path[0] == "section" else "axial"
                found[".".join(path)] = bound(spec, kind, scene.origin.base, direction)
        return cls(scene, species, constant(scene.flow.velocity_solid), solids_density, with_pressure, found)

    @property
    def porosity(self) -> float:
        """Porosity of the bed."""
        return self.scene.bed.porosity

    @property
    def area(self) -> float:
        """Specific surface of the packing, or of one of its kinds [1/m]."""
        bed = self.scene.bed
        return _AREA[bed.shape] * (1.0 - bed.porosity) / bed.diameter * self.share

    @property
    def solids(self) -> float:
        """Volume of the particles per volume of bed."""
        return (1.0 - self.scene.bed.porosity) * self.share

    def at(self, state: State) -> Transport:
        """Return the coefficients at a state."""
        needs = _Properties(self, state)
        heat, mass, wall = self.scene.heat, self.scene.mass, self.scene.wall
        exchange: Any = 0.0
        K_f: Any = 0.0
        K_s: Any = 0.0
        q_wall: Any = 0.0
        if heat is not None:
            if heat.nusselt is not None:
                Nu = self._value("heat.nusselt", heat.nusselt, needs)
                exchange = Nu * needs.k_fluid * (self.area / self.scene.bed.diameter)
            K_f = self._conductivity("heat.conductivity_fluid", heat.conductivity_fluid, needs, "fluid")
            K_s = self._conductivity("heat.conductivity_solid", heat.conductivity_solid, needs, "solid")
            if heat.dispersion is not None:
                K_f = K_f + self._value("heat.dispersion", heat.dispersion, needs)
            if wall is not None and self.scene.section is None:
                q_wall = self.through_wall(state.T_fluid, wall.coefficient) * (4.0 / wall.diameter)
        gradient: Any = 0.0
        if self.with_pressure:
            gradient = self.resistance(state, needs)
        dispersion = None
        films: dict[str, Any] = {}
        if mass is not None:
            if mass.dispersion is not None:
                dispersion = self._dispersion("mass.dispersion", mass.dispersion, needs)
            if mass.sherwood is not None:
                films = self._films(mass.sherwood, needs)
        if not self.kinds:
            return Transport(exchange, K_f, K_s, q_wall, gradient, dispersion, films)
        kinds = {kind: medium.of_its_share(state.kinds[kind]) for kind, medium in self.kinds.items()}
        K_s = sum(transport.conductivity_solid for transport in kinds.values())
        return Transport(exchange, K_f, K_s, q_wall, gradient, dispersion, films, kinds)

    def of_its_share(self, state: State) -> Transport:
        """Return the coefficients of one of several kinds, which conducts by its share of the volume."""
        found = self.at(state)
        return replace(found, conductivity_solid=self.share * found.conductivity_solid)

    def wall_coefficient(self, state: State) -> Any:
        """Return the coefficient of the wall [W/m2/K] at a state beside it, None for a wall with a given flux."""
        wall = self.scene.wall
        return None if wall is None else self._value("wall.coefficient", wall.coefficient, _Properties(self, state))

    def through_wall(self, T: Any, coefficient: Any, K: Any = 1.0, distance: float = 0.0) -> Any:
        """Return the heat through the wall into the bed [W/m2 of wall] from a temperature at a distance [m] from it.

        K is the conductivity between both [W/m/K], `coefficient` that of the wall.
        """
        wall = self.scene.wall
        if wall is None:
            return 0.0
        if wall.flux is not None:
            return constant(wall.flux)
        assert wall.ambient is not None
        if distance:
            coefficient = coefficient / (1.0 + (coefficient * distance) / K)
        return coefficient * (constant(wall.ambient) - T)

    def radial(self, state: State) -> Transport:
        """Return the coefficients across the flow at a state: conductivities, of each kind by its share; dispersion."""
        section, needs = self.scene.section, _Properties(self, state)
        assert section is not None
        across = self._across_kinds(state)
        K_f, K_s = self._stagnant(needs, across)
        if section.dispersion is not None:
            K_f = K_f + self._value("section.dispersion", section.dispersion, needs)
        dispersion = None
        if section.mass_dispersion is not None:
            dispersion = self._dispersion("section.mass_dispersion", section.mass_dispersion, needs)
        kinds = {kind: Transport(conductivity_solid=K) for kind, K in across.items()}
        return Transport(conductivity_fluid=K_f, conductivity_solid=K_s, dispersion=dispersion, kinds=kinds)

    def _across_kinds(self, state: State) -> dict[str, Any]:
        """Return the conductivity across the flow of each of several kinds, by its share of the volume [W/m/K]."""
        return {
            kind: medium.share * medium.stagnant(_Properties(medium, state.kinds[kind]))[1]
            for kind, medium in self.kinds.items()
        }

    def stagnant(self, needs: _Properties) -> tuple[Any, Any]:
        """Return the conductivities of gas and particles across the flow without dispersion [W/m/K]."""
        return self._stagnant(needs, self._across_kinds(needs.state))

    def _stagnant(self, needs: _Properties, kinds: Mapping[str, Any]) -> tuple[Any, Any]:
        section = self.scene.section
        assert section is not None  # `checks` sees to it
        K_f = self._conductivity("section.conductivity_fluid", section.conductivity_fluid, needs, "fluid")
        if kinds:
            return K_f, sum(kinds.values())
        return K_f, self._conductivity("section.conductivity_solid", section.conductivity_solid, needs, "solid")

    def resistance(self, state: State, needs: Any = None) -> Any:
        """Return -dp/dx [Pa/m] by permeability and Forchheimer coefficient, on the velocity to particles."""
        needs = needs or _Properties(self, state)
        K = self._value("bed.permeability", self.scene.bed.permeability, needs)
        c_F = self._value("bed.forchheimer", self.scene.bed.forchheimer, needs)
        U = needs.slip
        speed = np.abs(U) if not hasattr(U, "tangents") else (U * U + SLOW**2) ** 0.5
        return needs.viscosity * U / K + c_F * state.rho * speed * U / K**0.5

    def local(
        self,
        state: State,
        transport: Transport,
        reaction: Any,
        small: Smoothing | None = None,
        inner: Mapping[str, Any] | None = None,
    ) -> Local:
        """Return the state as a reaction sees it, with concentrations `inner` of gases inside of particles."""
        particle = reaction.site != "gas"
        c = {**state.c, **state.films} if particle and state.films and not reaction.own_film else state.c
        if inner:
            c = {**c, **inner}
        x = state.x
        if c is not state.c:
            total = state.p / (R_GAS * np.maximum(state.T_fluid, LEAST_T))
            x = {name: value / total for name, value in c.items()}
        T = state.T_solid if particle else state.T_fluid
        bed = self.scene.bed
        return Local(
            np.maximum(T, LEAST_T),
            state.p,
            c,
            x,
            state.n,
            bed.porosity,
            self.solids,
            0.5 * bed.diameter,
            self.solids_density,
            transport.films,
            small or SHARPEST,
        )

    def _dispersion(self, key: str, spec: Any, needs: Any) -> dict[str, Any]:
        if not named(spec):
            return dict.fromkeys(self.species.gases, spec)
        closure, v = self.closures[key], np.abs(needs.state.u) / self.porosity
        bed = self.scene.bed
        return {
            name: closure(eps=bed.porosity, d_p=bed.diameter, v=v, D_gas=D)
            for name, D in zip(self.species.gases, needs.diffusivities, strict=True)
        }

    def _films(self, spec: Any, needs: Any) -> dict[str, Any]:
        bed, out = self.scene.bed, {}
        for name, D in zip(self.species.gases, needs.diffusivities, strict=True):
            if named(spec):
                Sc = needs.viscosity / (needs.state.rho * D)
                Sh = self.closures["mass.sherwood"](eps=bed.porosity, d_p=bed.diameter, Re=needs.reynolds, Sc=Sc)
            else:
                Sh = spec
            out[name] = Sh * D * (1.0 / bed.diameter)
        return out

    def _conductivity(self, key: str, spec: Any, needs: Any, phase: str) -> Any:
        if spec is None:
            return 0.0
        if is_phase(spec):
            eps = self.porosity
            return eps * needs.k_fluid if phase == "fluid" else (1.0 - eps) * needs.k_solid
        return self._value(key, spec, needs)

    def _value(self, key: str, spec: Any, needs: Any) -> Any:
        if not named(spec):
            return spec
        closure = self.closures[key]
        return closure(**{name: needs.argument(name) for name in closure.takes})

    def ranges(self) -> list[RangeUse]:
        """Return how each closure was used in its last evaluation."""
        own = [closure.use() for closure in self.closures.values() if closure._last is not None]
        return own + [use for medium in self.kinds.values() for use in medium.ranges()]


class _Properties:
    """Properties of the gas at a state, each computed once, when it is needed."""

    def __init__(self, medium: Medium, state: State):
        self.medium, self.state = medium, state
        self._known: dict[str, Any] = {}

    def _once(self, name: str, make: Any) -> Any:
        if name not in self._known:
            self._known[name] = make()
        return self._known[name]

    @property
    def _x(self) -> list[Any]:
        return [self.state.x[name] for name in self.medium.species.gases]

    @property
    def _T(self) -> Any:
        return self._once("T", lambda: np.maximum(self.state.T_fluid, LEAST_T))

    def _of(self, name: str) -> Any:
        transport = self.medium.species.transport
        if transport is None or getattr(transport, name) is None:
            key = {"viscosities": "viscosity", "conductivities": "conductivity", "diffusivities": "diffusivity"}[name]
            origin = self.medium.scene.origin
            raise SceneError(
                f"{origin.at(('fluid',))}: fluid.{key}: is needed by a closure of this scene and not given; give one "
                f"number, or values in [fluid.species.NAME]"
            )
        return transport

    @property
    def viscosity(self) -> Any:
        return self._once("mu", lambda: self._of("viscosities").viscosity(self._T, self._x))

    @property
    def k_fluid(self) -> Any:
        return self._once("k", lambda: self._of("conductivities").conductivity(self._T, self._x))

    @property
    def diffusivities(self) -> list[Any]:
        found: list[Any] = self._once(
            "D", lambda: self._of("diffusivities").diffusivity(self._T, self.state.p, self._x)
        )
        return found

    @property
    def k_solid(self) -> Any:
        solid = self.medium.scene.solid
        if solid is None or solid.conductivity is None:
            raise SceneError(
                f"{self.medium.scene.origin.at(('solid',))}: solid.conductivity: missing; a closure of [heat] needs it"
            )
        return solid.conductivity

    @property
    def slip(self) -> Any:
        """Superficial velocity relative to the particles [m/s]."""
        eps = self.medium.porosity
        return self.state.u - eps * self.medium.velocity_solid / (1.0 - eps)

    @property
    def reynolds(self) -> Any:
        def make() -> Any:
            slip = np.abs(self.slip)
            return self.state.rho * slip * self.medium.scene.bed.diameter / self.viscosity

        return self._once("Re", make)

    @property
    def prandtl(self) -> Any:
        def make() -> Any:
            gases = self.medium.species.gases
            cp = sum(self.state.x[name] * item.heat_capacity(self._T) for name, item in gases.items())
            return self.viscosity * cp * self.state.moles / self.state.flux / self.k_fluid

        return self._once("Pr", make)

    def argument(self, name: str) -> Any:
        """Return an argument of a closure."""
        bed, wall = self.medium.scene.bed, self.medium.scene.wall
        values = {
            "eps": lambda: bed.porosity,
            "d_p": lambda: bed.diameter,
            "Re": lambda: self.reynolds,
            "Pr": lambda: self.prandtl,
            "Pe": lambda: self.reynolds * self.prandtl,
            "T": lambda: self.state.T_solid,
            "k_fluid": lambda: self.k_fluid,
            "k_solid": lambda: self.k_solid,
            "k_stagnant": lambda: sum(self.medium.stagnant(self)),
            "D_bed": lambda: wall.diameter if wall is not None else 1e3 * bed.diameter,
        }
        return values[name]()
