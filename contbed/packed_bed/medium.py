"""Properties of the bed of one scene as functions of state, from its materials and
closures, with used ranges recorded.

Every function takes pointwise values (numbers, arrays or dual numbers) and returns the
same, so that constants stay numbers and a problem with constant properties stays
linear.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from contbed.closures import optics
from contbed.closures.binding import BoundClosure, is_phase, named
from contbed.closures.packed_beds import (
    SURFACE,
    Packing,
    comoving_velocity,
    surface_diameter,
)
from contbed.closures.ranges import RangeUse
from contbed.materials import Solid
from contbed.materials.constants import fluid_of
from contbed.materials.curve import latent_heat_of
from contbed.materials.pointwise import pointwise
from contbed.packed_bed import scene as s
from contbed.packed_bed.closures import At, all_bound
from contbed.packed_bed.inlets import inlet_temperature
from contbed.scene.boundary import conditions_of
from contbed.scene.mesh import (
    Mesh,
    MeshAxisymmetric,
    MeshBox,
    MeshLine,
    MeshRectangle,
)

# of the cubic spline of rho c_p over the range of a fluid: 3e-7 off for air to 3000 K,
# at the bends of its data, and 1e-5 at the peak of CO2 at 100 bar
CONTENT_NODES = 8001
# conduction inside counts as d/(10 k_s) in series with the film of spheres
_INSIDE = {"spheres": 10.0, "rods": 8.0}


def solid_of(settings: s.Solid) -> Solid | None:
    """Return the material of the particles, None without a density."""
    if settings.density is None:
        return None
    heat_capacity = 1.0 if settings.heat_capacity is None else settings.heat_capacity
    conductivity = 1.0 if settings.conductivity is None else settings.conductivity
    return Solid(
        settings.density,
        heat_capacity,
        conductivity,
        settings.data_range,
        settings.material or "solid",
        latent_heat=latent_heat_of(settings.melting),
    )


def bed_diameter(mesh: Mesh) -> float:
    """Return the hydraulic diameter of a built-in bed [m]; infinite without walls."""
    if isinstance(mesh, MeshRectangle):
        return 2.0 * mesh.height
    if isinstance(mesh, MeshAxisymmetric):
        return 2.0 * mesh.radius
    if isinstance(mesh, MeshBox):
        return 2.0 * mesh.width * mesh.height / (mesh.width + mesh.height)
    if isinstance(mesh, MeshLine) and mesh.diameter is not None:
        return mesh.diameter
    return float("inf")


@dataclass(frozen=True)
class Medium:
    """Materials, packing and closures of a bed.

    Velocities are superficial; `T_fluid_in` fixes the density of the mass flux.
    `rosseland` is the diffusion coefficient D [m] where radiation is a conductivity,
    else None. `closures` holds bound closures by kind and name, `used` those that were
    evaluated.
    """

    scene: s.Scene
    fluid: Any
    solid: Any
    T_fluid_in: float
    bed_diameter: float
    rosseland: float | None = None
    closures: Mapping[tuple[str, Any], Any] = field(default_factory=dict)
    used: set[BoundClosure] = field(default_factory=set)
    tables: dict[str, Any] = field(default_factory=dict)

    @classmethod
    def of(cls, scene: s.Scene, fluid: Any = None) -> Medium:
        """Resolve the materials of a scene; `fluid` if it is known from one with the
        same.
        """
        return cls(
            scene,
            fluid_of(scene.gas, scene.origin) if fluid is None else fluid,
            solid_of(scene.solid),
            inlet_temperature(scene),
            bed_diameter(scene.mesh),
            _rosseland(scene),
            all_bound(scene),
        )

    @property
    def constant(self) -> bool:
        """Whether no property depends on temperature and no boundary makes the
        problem nonlinear.
        """
        conditions = [table for *_, table in conditions_of(self.scene.boundary)]
        if (
            self.scene.radiation is not None
            or self._radiating()
            or not all(table.linear for table in conditions)
        ):
            return False
        return self.fluid.constant and (self.solid is None or self.solid.constant)

    def _radiating(self) -> bool:
        """Return whether a conductivity depends on temperature because it includes
        radiation.
        """
        return any(
            kind == "conductivity" and "T" in closure.sheet.arguments
            for (kind, _), closure in self.closures.items()
        )

    @property
    def area(self) -> float:
        """Specific surface of the packing [1/m]."""
        scene = self.scene
        return (
            SURFACE[scene.solid.shape]
            * (1.0 - scene.packed_bed.porosity)
            / scene.diameter
        )

    def packing(self, kind: str) -> float:
        """Return the permeability [m2] or Forchheimer coefficient [1] of the bed."""
        scene, spec = self.scene, getattr(self.scene.closures, kind)
        if not named(spec):
            return float(spec)
        closure = self.closures[kind, spec]
        self.used.add(closure)
        eps, d = scene.packed_bed.porosity, scene.diameter
        surface = surface_diameter(d, scene.solid.shape)
        return float(closure.at(Packing.of(closure.sheet.name, eps, d, surface)))

    def mass_flux_scale(self) -> float:
        """Return the density that turns superficial velocity into mass flux [kg/m3]."""
        return float(self.fluid.density(self.T_fluid_in))

    def comoving(self, velocity_solid: Any) -> Any:
        """Return the superficial velocity of a fluid that moves with the particles
        [m/s].

        `velocity_solid` is theirs, superficial too.
        """
        bed = self.scene.packed_bed
        if bed.relative_velocity == "superficial":
            return velocity_solid
        return comoving_velocity(velocity_solid, bed.porosity)

    def relative_speed(
        self, velocity: Any, velocity_solid: Any
    ) -> Callable[[Any], float]:
        """Return the superficial speed relative to the particles [m/s] as a function
        of the fluid's density; the velocities are numbers or vectors.
        """
        comoving, scale = self.comoving(velocity_solid), self.mass_flux_scale()
        return lambda density: float(
            np.linalg.norm(scale / density * velocity - comoving)
        )

    @property
    def capacities(self) -> tuple[float, float]:
        """Heat capacities of fluid and solid per volume that moves at their
        superficial velocities [J/m3/K].
        """
        T, solid = self.T_fluid_in, self.solid
        return (
            self.mass_flux_scale() * float(self.fluid.heat_capacity(T)),
            float(solid.density(T)) * float(solid.heat_capacity(T)),
        )

    def reynolds(self, T: Any, speed: Callable[[Any], Any]) -> Any:
        """Return the particle Reynolds number.

        `speed(density)` is the relative superficial mass flux over density [m/s].
        """
        fixed = self.scene.packed_bed.reynolds
        if fixed is not None:
            return fixed
        density = self.fluid.density(T)
        relative = speed(density)
        if isinstance(relative, float) and relative == 0.0:
            return 0.0
        return density * relative * self.scene.diameter / self.fluid.viscosity(T)

    def prandtl(self, T: Any) -> Any:
        """Return the Prandtl number of the fluid."""
        return (
            self.fluid.viscosity(T)
            * self.fluid.heat_capacity(T)
            / self.fluid.conductivity(T)
        )

    def exchange(self, T_fluid: Any, speed: Callable[[Any], Any]) -> Any:
        """Return the volumetric exchange coefficient h a [W/m3/K], with conduction
        inside if the scene says so.
        """
        nusselt = self._value(self.scene.closures.nusselt, "nusselt", T_fluid, speed)
        diameter, solid = self.scene.diameter, self.scene.solid
        film = nusselt * self.fluid.conductivity(T_fluid) * (self.area / diameter)
        if solid.inside is None or solid.inside.heat != "effective":
            return film
        resistance = diameter / (_INSIDE[solid.shape] * self.area)
        return film / (1.0 + film * resistance / self.solid.conductivity(T_fluid))

    def wall(self, spec: Any, T_fluid: Any, speed: Callable[[Any], Any]) -> Any:
        """Return the wall coefficient [W/m2/K]."""
        return self._value(spec, "wall", T_fluid, speed)

    def stagnant(self, T: Any) -> Any:
        """Return the conductivity of both phases without flow [W/m/K]."""
        return self.conductivity_fluid(T) + self.conductivity_solid(T)

    def conductivity(self, phase: str, T: Any) -> Any:
        """Return the effective conductivity of a phase [W/m/K], tortuosity included,
        dispersion excluded.
        """
        own = (
            self.conductivity_fluid(T)
            if phase == "fluid"
            else self.conductivity_solid(T)
        )
        shares = self.tortuosity(T)
        total = own if shares is None else own + shares[0 if phase == "fluid" else 1]
        if phase == "solid" and self.rosseland is not None:
            total = total + optics.conductivity(T, self.rosseland)
        return total

    def conductivity_fluid(self, T: Any) -> Any:
        """Return the conductivity of the fluid phase, without tortuosity and
        dispersion [W/m/K].
        """
        spec = self.scene.closures.conductivity_gas
        if is_phase(spec):
            return self.scene.packed_bed.porosity * self.fluid.conductivity(T)
        return self._value(spec, "conductivity", T)

    def conductivity_solid(self, T: Any) -> Any:
        """Return the conductivity of the solid phase, without tortuosity [W/m/K]."""
        spec = self.scene.closures.conductivity_solids
        if is_phase(spec):
            return (1.0 - self.scene.packed_bed.porosity) * self.solid.conductivity(T)
        return self._value(spec, "conductivity", T)

    def tortuosity(self, T: Any) -> tuple[Any, Any, Any] | None:
        """Return the tortuosity terms of the conductivities [W/m/K]: fluid, solid
        and cross (Nakayama 2001).
        """
        spec = self.scene.closures.tortuosity
        if spec is None:
            return None
        G: Any = self._value(spec, "tortuosity", T)
        k_fluid = self.fluid.conductivity(T)
        ratio = self.solid.conductivity(T) / k_fluid
        return G * k_fluid, G * k_fluid * ratio**2, -G * k_fluid * ratio

    @property
    def cross_conductivity(self) -> Callable[[Any], Any] | None:
        """Cross conductivity as a function of temperature [W/m/K], None without
        tortuosity.
        """

        def cross(T: Any) -> Any:
            shares = self.tortuosity(T)
            assert shares is not None
            return shares[2]

        return None if self.scene.closures.tortuosity is None else cross

    def dispersion(self, T: Any, speed: Callable[[Any], Any]) -> tuple[Any, Any] | None:
        """Return the dispersion conductivities along and across the flow [W/m/K]."""
        spec = self.scene.closures.dispersion
        if spec is None:
            return None
        if isinstance(spec, s.Dispersion):
            return spec.axial, spec.transverse
        axial, transverse = self.closures["dispersion", spec]
        return self._at(axial, T, speed), self._at(transverse, T, speed)

    def content_fluid(self, T: Any) -> Any:
        """Return the heat content of the fluid per bed volume [J/m3].

        It is the integral of eps rho c_p over temperature.
        """
        eps = self.scene.packed_bed.porosity
        if self.fluid.constant:
            return eps * self.fluid.density(T) * self.fluid.enthalpy(T)
        integral, slope = self._content_table()
        return pointwise(lambda t: eps * integral(t), lambda t: eps * slope(t), T)

    def _content_table(self) -> tuple[Any, Any]:
        """Return the integral of rho c_p and rho c_p itself as functions of T.

        Beyond the range of the properties rho c_p is that of its end: the under- and
        overshoots of a steep front reach some kelvins beyond the temperatures that
        enter.
        """
        if "content" not in self.tables:
            from scipy.interpolate import CubicSpline

            low, high = self.fluid.T_range
            ends = [max(low, 1.0), min(high, 6000.0)]
            nodes = np.linspace(ends[0], ends[1], CONTENT_NODES)
            series = CubicSpline(
                nodes, self.fluid.density(nodes) * self.fluid.heat_capacity(nodes)
            )
            integral = series.antiderivative()

            def content(t: Any) -> Any:
                inside = np.clip(t, *ends)
                return integral(inside) + series(inside) * (t - inside)

            self.tables["content"] = (content, lambda t: series(np.clip(t, *ends)))
        value, derivative = self.tables["content"]
        return value, derivative

    def content_solid(self, T: Any) -> Any:
        """Return the heat content of the solid per bed volume [J/m3]."""
        return (
            (1.0 - self.scene.packed_bed.porosity)
            * self.solid.density(T)
            * self.solid.enthalpy(T)
        )

    def ranges(self) -> list[RangeUse]:
        """Return how each closure was used in its last evaluation, or in the states
        that are recorded.
        """
        return [closure.use() for closure in self._bound() if closure in self.used]

    def record(self) -> None:
        """Add the last evaluation of each closure to the record of used ranges."""
        for closure in self.used:
            closure.record()

    def state(self) -> dict[str, Any]:
        """Return the record of used ranges for a checkpoint."""
        return {
            f"ranges_{k}": closure.state() for k, closure in enumerate(self._bound())
        }

    def restore(self, arrays: Mapping[str, Any]) -> None:
        """Restore the record of used ranges from a checkpoint."""
        for k, closure in enumerate(self._bound()):
            rows = arrays.get(f"ranges_{k}")
            if rows is not None and rows.any():
                closure.restore(rows)
                self.used.add(closure)

    def _bound(self) -> list[BoundClosure]:
        """Return all closures, those of a pair one by one."""
        pairs = (
            found if isinstance(found, tuple) else (found,)
            for found in self.closures.values()
        )
        return [closure for pair in pairs for closure in pair]

    def _value(
        self,
        spec: Any,
        kind: str,
        T: Any = None,
        speed: Callable[[Any], Any] | None = None,
    ) -> Any:
        """Return a number of the scene, or the value of the closure that it names."""
        if not named(spec):
            return spec
        return self._at(self.closures[kind, spec], T, speed)

    def _at(self, closure: Any, T: Any, speed: Callable[[Any], Any] | None) -> Any:
        """Return the value of a closure at a state."""
        self.used.add(closure)
        return closure.at(At(self, T, speed))


def _rosseland(scene: s.Scene) -> float | None:
    if scene.radiation is None or scene.radiation.level != "rosseland":
        return None
    from contbed.radiation.optics import optics

    return optics(scene).diffusion
