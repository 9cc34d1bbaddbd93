"""What is resolved inside of the particles of a bed: one temperature, a corrected film, or temperatures inside.

The Biot number Bi = h R/k_s decides. Below 0.1 the particle is uniform; below 1 its mean temperature follows the fluid
through 1/h_eff = 1/h + R/((s + 2) k_s), s = 3 for spheres and 2 for rods; above, a transient needs temperatures inside.
A steady bed at rest has h_eff exactly, one that moves as long as particles stay for Fo = alpha t/R^2 of 0.3 or more.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from contbed.packed_bed import scene as s
from contbed.packed_bed.medium import Medium
from contbed.particle.interior import SURFACE_OVER_VOLUME, interior
from contbed.particle.uptake import breakthrough_error, moving_bed_error

UNIFORM = 0.1  # Biot number below which a particle has one temperature
CORRECTED = 1.0  # Biot number below which the corrected film coefficient suffices in a transient
SHORT_STAY = 0.3  # Fourier number below which a particle that passes through a steady bed remembers its inlet
USUAL_UNITS = 20.0  # transfer units for which errors are predicted where the length or the flow is not known
SHAPES = {"spheres": "sphere", "rods": "cylinder"}


@dataclass(frozen=True)
class Inside:
    """Level and the numbers that chose it.

    level : lumped, effective or interior
    biot : h R/k_s at the temperature of the inlet; units : h a L/(G c)
    fourier : alpha L/(v R^2) of moving particles, None at rest; gamma : heat capacity flow of solids over fluid, signed
    error : of each level in the temperature of the fluid that leaves, over the span
    """

    level: str
    biot: float
    units: float
    fourier: float | None
    gamma: float
    error: dict[str, float]

    def __str__(self) -> str:
        which = {
            "lumped": "one temperature per particle, film alone",
            "effective": "one temperature per particle, film coefficient corrected for conduction inside",
            "interior": "temperatures inside",
        }[self.level]
        stay = "" if self.fourier is None else f", Fo = {self.fourier:.3g}"
        cheaper = {"lumped": ("lumped",), "effective": ("lumped", "effective"), "interior": ("lumped", "effective")}
        errors = ", ".join(f"{name} {self.error[name]:.1e}" for name in cheaper[self.level] if name in self.error)
        return f"{which}: Bi = {self.biot:.3g}{stay}; error of the outlet over the span: {errors}"


def inside_of(scene: s.Scene, medium: Medium, velocity: Any, velocity_solid: Any) -> Inside | None:
    """Return the level for a scene whose film is not corrected; None without two phases or without exchange.

    `velocity` and `velocity_solid` are vectors on the mesh [m/s].
    """
    if scene.heat is None or medium.solid is None:
        return None
    relative = float(np.linalg.norm(np.asarray(velocity) - np.asarray(velocity_solid)))
    T = medium.T_fluid_in
    exchange = float(medium.exchange(T, lambda density: relative))
    if exchange <= 0.0:
        return None
    radius, conductivity = 0.5 * scene.bed.particle_diameter, float(medium.solid.conductivity(T))
    biot = exchange / medium.area * radius / conductivity
    heat_fluid = medium.mass_flux_scale() * float(medium.fluid.heat_capacity(T)) * float(np.linalg.norm(velocity))
    capacity = float(medium.solid.density(T) * medium.solid.heat_capacity(T))
    speed, length = float(np.linalg.norm(velocity_solid)), getattr(scene.mesh, "length", None)
    units = USUAL_UNITS if length is None or heat_fluid == 0.0 else exchange * length / heat_fluid
    fourier, gamma = None, 0.0
    if speed > 0.0 and length is not None:
        solid_share = 1.0 - scene.bed.porosity
        fourier = conductivity / capacity * length * solid_share / (speed * radius * radius)
        if heat_fluid > 0.0:
            sign = np.sign(np.dot(velocity, velocity_solid)) or 1.0
            gamma = float(sign) * capacity * speed / heat_fluid
    steady = scene.time is None
    level: str = "lumped" if scene.particle is None else scene.particle.heat
    if level == "auto":
        level = _by_numbers(scene, biot, fourier, steady)
    return Inside(level, biot, units, fourier, gamma, _errors(scene, biot, units, fourier, gamma, steady))


def _by_numbers(scene: s.Scene, biot: float, fourier: float | None, steady: bool) -> str:
    if biot < UNIFORM:
        return "lumped"
    if biot < CORRECTED or scene.radiation is not None:
        return "effective"
    if steady and (fourier is None or fourier >= SHORT_STAY):
        return "effective"
    return "interior"


def _errors(
    scene: s.Scene, biot: float, units: float, fourier: float | None, gamma: float, steady: bool
) -> dict[str, float]:
    """Return the predicted error of the cheaper levels; none where no closed form is near the scene."""
    shape, levels = SHAPES[scene.bed.shape], ("lumped", "effective")
    if not steady:
        return {level: breakthrough_error(units, biot, level, shape) for level in levels}  # type: ignore[arg-type]
    if fourier is not None and gamma != 0.0:
        return {level: moving_bed_error(gamma, biot, fourier, level, shape) for level in levels}  # type: ignore[arg-type]
    # a bed at rest: the outlet misses exp(-units) by the error of the coefficient
    wrong = biot / (SURFACE_OVER_VOLUME[shape] + 2)
    return {"lumped": float(units * np.exp(-min(units, 1.0)) * wrong / (1.0 + wrong)) if units < 1.0 else wrong / np.e}


@dataclass(frozen=True)
class Mode:
    """One mode of conduction inside, as its share of the temperature at the surface.

    (1 - eps) rho c dT_m/dt = -decay T_m + gain (heat taken up through the surface per bed volume)
    """

    name: str
    decay: float  # [W/m3/K] for a conductivity of 1 W/m/K
    gain: float
    centre: float  # at the centre over that at the surface


def modes(scene: s.Scene) -> tuple[Mode, ...]:
    """Return the modes of the particles of a scene with temperatures inside; none for other levels."""
    if scene.particle is None or scene.particle.heat != "interior":
        return ()
    radius = 0.5 * scene.bed.particle_diameter
    inside = interior(scene.particle.points, SHAPES[scene.bed.shape])
    rates, vectors = inside.modes()
    middle = inside.at_centre() @ vectors
    scale = (1.0 - scene.bed.porosity) / (radius * radius)
    return tuple(
        Mode(f"T_inside_{m}", scale * float(rates[m]), float(vectors[-1, m] ** 2), float(middle[m] / vectors[-1, m]))
        for m in range(1, len(rates))
    )
