"""The bed of one scene as functions of state: materials and closures resolved, with a record of the ranges used.

Every function takes pointwise values (numbers, arrays or dual numbers) and returns the same, so that constants stay
numbers and a problem with constant properties stays linear by itself.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any, TypeGuard

import numpy as np

from contbed.closures import optics, registry
from contbed.closures.binding import is_phase, own_parameters, resolve_closure, resolve_dispersion
from contbed.materials import ConstantFluid, Solid, gas_mixture, real_fluid
from contbed.materials.pointwise import pointwise
from contbed.packed_bed import scene as s
from contbed.scene.quantities import ClosureFile
from contbed.scene.tables import Closure, FluidCantera, FluidConstant, FluidCoolProp

_AREA = {"spheres": 6.0, "rods": 4.0}


def fluid_of(settings: FluidConstant | FluidCantera | FluidCoolProp) -> Any:
    """The fluid of a scene; Cantera and CoolProp are imported only when named."""
    if isinstance(settings, FluidCantera):
        return gas_mixture(settings.composition, settings.pressure, settings.mechanism)
    if isinstance(settings, FluidCoolProp):
        return real_fluid(settings.name, settings.pressure, settings.T_range)
    conductivity = 1.0 if settings.conductivity is None else settings.conductivity
    return ConstantFluid(settings.density, settings.heat_capacity or 1.0, settings.viscosity, conductivity)


@dataclass(frozen=True)
class Medium:
    """Materials, packing and closures. Velocities are superficial; `T_fluid_in` fixes the density of the mass flux.
    `rosseland` is the diffusion coefficient D [m] where radiation is a conductivity, else None.
    """

    scene: s.Scene
    fluid: Any
    solid: Any
    T_fluid_in: float
    bed_diameter: float
    rosseland: float | None = None
    uses: dict[str, Any] = field(default_factory=dict)

    @classmethod
    def of(cls, scene: s.Scene, T_fluid_in: float, bed_diameter: float) -> Medium:
        """Resolve the materials of a scene."""
        solid = scene.solid
        return cls(
            scene,
            fluid_of(scene.fluid),
            None if solid is None else Solid(solid.density, solid.heat_capacity, solid.conductivity),
            T_fluid_in,
            bed_diameter,
            _rosseland(scene),
        )

    @property
    def heat(self) -> s.Heat:
        """The [heat] table of a scene that has one."""
        assert self.scene.heat is not None
        return self.scene.heat

    @property
    def constant(self) -> bool:
        """Whether no property depends on temperature."""
        if self.scene.radiation is not None or self._radiating():
            return False
        return self.fluid.constant and (self.solid is None or self.solid.constant)

    def _radiating(self) -> bool:
        heat = self.scene.heat
        specs = () if heat is None else (heat.conductivity_fluid, heat.conductivity_solid)
        named = [spec for spec in specs if _named(spec) and not is_phase(spec)]
        closures: list[Any] = [resolve_closure(spec, "conductivity", self.scene.origin.base)[0] for spec in named]
        return any("T" in closure.sheet.arguments for closure in closures)

    @property
    def area(self) -> float:
        """Specific surface of the packing [1/m]."""
        bed = self.scene.bed
        return _AREA[bed.shape] * (1.0 - bed.porosity) / bed.particle_diameter

    def packing(self, kind: str) -> float:
        """Permeability [m2] or Forchheimer coefficient [1] of the bed."""
        bed = self.scene.bed
        spec = getattr(bed, kind)
        if isinstance(spec, int | float):
            return float(spec)
        return float(self.evaluate(spec, kind, eps=bed.porosity, d_p=bed.particle_diameter))

    def mass_flux_scale(self) -> float:
        """Density that turns superficial velocity into mass flux [kg/m3]."""
        return float(self.fluid.density(self.T_fluid_in))

    def reynolds(self, T: Any, speed: Callable[[Any], Any]) -> Any:
        """Particle Reynolds number; `speed(density)` is the relative superficial mass flux over density [m/s]."""
        fixed = self.heat.reynolds
        if fixed is not None:
            return fixed
        density = self.fluid.density(T)
        relative = speed(density)
        if isinstance(relative, float) and relative == 0.0:
            return 0.0
        return density * relative * self.scene.bed.particle_diameter / self.fluid.viscosity(T)

    def prandtl(self, T: Any) -> Any:
        """Prandtl number of the fluid."""
        return self.fluid.viscosity(T) * self.fluid.heat_capacity(T) / self.fluid.conductivity(T)

    def exchange(self, T_fluid: Any, speed: Callable[[Any], Any]) -> Any:
        """Volumetric exchange coefficient h a [W/m3/K]."""
        bed, heat = self.scene.bed, self.heat
        nusselt = heat.nusselt
        if _named(nusselt):
            nusselt = self.evaluate(nusselt, "nusselt", **self._state(T_fluid, speed))
        return nusselt * self.fluid.conductivity(T_fluid) * (self.area / bed.particle_diameter)

    def wall(self, spec: Any, T_fluid: Any, speed: Callable[[Any], Any]) -> Any:
        """Wall coefficient [W/m2/K]."""
        if not _named(spec):
            return spec
        return self.evaluate(spec, "wall", **self._state(T_fluid, speed), k_stagnant=self._stagnant(T_fluid))

    def _stagnant(self, T: Any) -> Any:
        return self.conductivity_fluid(T) + self.conductivity_solid(T)

    def _state(self, T: Any, speed: Callable[[Any], Any]) -> dict[str, Any]:
        Re, Pr = self.reynolds(T, speed), self.prandtl(T)
        return {
            "Re": Re,
            "Pr": Pr,
            "Pe": Re * Pr,
            "eps": self.scene.bed.porosity,
            "T": T,
            "d_p": self.scene.bed.particle_diameter,
            "D_bed": self.bed_diameter,
            "k_fluid": self.fluid.conductivity(T),
        }

    def conductivity(self, phase: str, T: Any) -> Any:
        """Effective conductivity of one phase without dispersion, the tortuosity's share included [W/m/K]."""
        own = self.conductivity_fluid(T) if phase == "fluid" else self.conductivity_solid(T)
        shares = self.tortuosity(T)
        total = own if shares is None else own + shares[0 if phase == "fluid" else 1]
        if phase == "solid" and self.rosseland is not None:
            total = total + optics.conductivity(T, self.rosseland)
        return total

    def conductivity_fluid(self, T: Any) -> Any:
        """Conductivity of the fluid phase, without tortuosity and dispersion [W/m/K]."""
        spec = self.heat.conductivity_fluid
        if is_phase(spec):
            return self.scene.bed.porosity * self.fluid.conductivity(T)
        return self._conductivity(spec, T)

    def conductivity_solid(self, T: Any) -> Any:
        """Conductivity of the solid phase, without tortuosity [W/m/K]."""
        spec = self.heat.conductivity_solid
        if is_phase(spec):
            return (1.0 - self.scene.bed.porosity) * self.solid.conductivity(T)
        return self._conductivity(spec, T)

    def _conductivity(self, spec: Any, T: Any) -> Any:
        if not _named(spec):
            return spec
        return self.evaluate(spec, "conductivity", **self._pair(T), T=T, d_p=self.scene.bed.particle_diameter)

    def _pair(self, T: Any) -> dict[str, Any]:
        eps = self.scene.bed.porosity
        return {"k_fluid": self.fluid.conductivity(T), "k_solid": self.solid.conductivity(T), "eps": eps}

    def tortuosity(self, T: Any) -> tuple[Any, Any, Any] | None:
        """Additions to the conductivities of fluid and solid and the cross conductivity [W/m/K] (Nakayama 2001)."""
        spec = self.heat.tortuosity
        if spec is None:
            return None
        pair = self._pair(T)
        G: Any = self.evaluate(spec, "tortuosity", **pair) if _named(spec) else spec
        k_fluid, ratio = pair["k_fluid"], pair["k_solid"] / pair["k_fluid"]
        return G * k_fluid, G * k_fluid * ratio**2, -G * k_fluid * ratio

    @property
    def cross_conductivity(self) -> Callable[[Any], Any] | None:
        """Cross conductivity as a function of temperature [W/m/K], None without tortuosity."""

        def cross(T: Any) -> Any:
            shares = self.tortuosity(T)
            assert shares is not None
            return shares[2]

        return None if self.heat.tortuosity is None else cross

    def dispersion(self, T: Any, speed: Callable[[Any], Any]) -> tuple[Any, Any] | None:
        """Dispersion conductivities along and across the flow [W/m/K]."""
        spec = self.heat.dispersion
        if spec is None:
            return None
        if isinstance(spec, s.Dispersion):
            return spec.axial, spec.transverse
        axial, transverse, parameters = resolve_dispersion(spec)
        state = self._state(T, speed)
        return self._call(axial, parameters, state), self._call(transverse, parameters, state)

    def content_fluid(self, T: Any) -> Any:
        """Heat content of the fluid per bed volume [J/m3], the integral of eps rho c_p over temperature."""
        eps = self.scene.bed.porosity
        if self.fluid.constant:
            return eps * self.fluid.density(T) * self.fluid.enthalpy(T)
        integral, slope = self._content_table()
        return pointwise(lambda t: eps * integral(t), lambda t: eps * slope(t), T)

    def _content_table(self) -> tuple[Any, Any]:
        if "content" not in self.uses:
            low, high = self.fluid.T_range
            series = np.polynomial.Chebyshev.interpolate(
                lambda t: self.fluid.density(t) * self.fluid.heat_capacity(t), 120, [max(low, 1.0), min(high, 6000.0)]
            )
            self.uses["content"] = (series.integ(), series)
        return self.uses["content"]

    def content_solid(self, T: Any) -> Any:
        """Heat content of the solid per bed volume [J/m3]."""
        return (1.0 - self.scene.bed.porosity) * self.solid.density(T) * self.solid.enthalpy(T)

    def evaluate(self, spec: Any, kind: str, **available: Any) -> Any:
        """Value of a closure that takes what it needs from `available`."""
        function, parameters = resolve_closure(spec, kind, self.scene.origin.base)
        return self._call(function, parameters, available)

    def _call(self, function: Any, parameters: dict[str, Any], available: dict[str, Any]) -> Any:
        sheet = function.sheet
        arguments = {name: available[name] for name in sheet.arguments if name not in parameters}
        arguments |= own_parameters(function, parameters)
        self.uses[sheet.name] = (function, arguments)
        return function(**arguments)

    def ranges(self) -> list[registry.RangeUse]:
        """How each closure was used in its last evaluation."""
        return [
            registry.usage(function, **{name: getattr(value, "value", value) for name, value in arguments.items()})
            for key, (function, arguments) in self.uses.items()
            if key != "content"
        ]


def _rosseland(scene: s.Scene) -> float | None:
    if scene.radiation is None or scene.radiation.level != "rosseland":
        return None
    from contbed.radiation import problem as radiation_problem

    return radiation_problem.optics(scene).diffusion


def _named(spec: Any) -> TypeGuard[str | Closure | ClosureFile]:
    return isinstance(spec, str | Closure | ClosureFile)
