"""Streams that enter a reacting bed: fluxes, temperatures, where they enter."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import numpy as np

from contbed.closures.reactions import R_GAS
from contbed.materials.composition import mole_fractions
from contbed.materials.thermo import T_STANDARD
from contbed.reacting_bed import scene as s
from contbed.reacting_bed.inlet_series import constant
from contbed.reacting_bed.substances import PhaseSpecies, Substances


@dataclass(frozen=True, eq=False)
class Streams:
    """What enters: fluxes per area of the bed.

    gas : mole flux of each gas [mol/m2/s], signed along x
    solid : moles of each constituent where particles enter [mol/m3 bed], also of those that only reactions make
    shares, velocities, densities : of each solid phase its share of the volume of all particles, the superficial
        velocity as if it filled the bed [m/s], and the mass per volume of bed [kg/m3]
    """

    gas: dict[str, float]
    solid: dict[str, float]
    mass_flux: float
    T_gas: float
    T_solid: float
    pressure: float
    shares: dict[str, float]
    velocities: dict[str, float]
    densities: dict[str, float]

    @property
    def ahead(self) -> bool:
        """Whether the gas flows along x."""
        return self.mass_flux > 0

    @property
    def mean_velocity(self) -> float:
        """Superficial velocity of all particles by volume [m/s]."""
        return sum(share * self.velocities[name] for name, share in self.shares.items())


def streams(scene: s.ReactingScene, species: Substances) -> Streams:
    """Return the streams that enter a scene without series."""
    fluid, flow = scene.fluid, scene.flow
    sign = gas_sign(flow)
    T_gas = inlet_temperature(scene, "fluid", sign)
    velocities = {
        name: constant(flow.velocity_solid if table.velocity_solid is None else table.velocity_solid)
        for name, table in scene.phases.items()
    }
    direction = float(np.sign(slowest(velocities.values()))) or sign
    T_solid = inlet_temperature(scene, "solid", direction, T_gas)
    assert isinstance(fluid.composition, str)
    entering = mole_fractions(fluid.composition)
    mean = sum(x * species.gases[name].molar_mass for name, x in entering.items())
    if flow.mass_flux is not None:
        moles = constant(flow.mass_flux) / mean
    elif flow.molar_flux is not None:
        moles = constant(flow.molar_flux)
    else:
        assert flow.velocity is not None
        moles = constant(flow.velocity) * fluid.pressure / (R_GAS * T_gas)
    gas = {name: moles * entering.get(name, 0.0) for name in species.gases}
    shares = shares_of(scene.phases)
    densities, solid = {}, {}
    for name, table in scene.phases.items():
        phase = species.phases[name]
        density = particle_density(table, phase) * (1.0 - scene.bed.porosity)
        densities[name] = shares[name] * density
        for constituent, data in phase.solids.items():
            moles_alone = density * phase.fed.get(constituent, 0.0) / data.molar_mass
            solid[phase.full(constituent)] = shares[name] * moles_alone
    return Streams(gas, solid, moles * mean, T_gas, T_solid, fluid.pressure, shares, velocities, densities)


def slowest(velocities: Iterable[float]) -> float:
    """Return the velocity of the slowest solid phase that moves, 0 where none does."""
    return min((v for v in velocities if v), key=abs, default=0.0)


def particle_density(table: s.Solids, phase: PhaseSpecies) -> float:
    """Return the density of the particles of a phase as they enter [kg/m3], 0 where it is not known."""
    if table.density is not None:
        return table.density
    if not phase.fed:
        return 0.0
    volume = sum(w / phase.densities[name] for name, w in phase.fed.items())
    return (1.0 - table.porosity) / volume


def gas_sign(flow: s.Flow) -> float:
    """Return the direction of the gas along x."""
    return float(np.sign(constant(flow.mass_flux or flow.molar_flux or flow.velocity or 0.0)))


def inlet(scene: s.ReactingScene, phase: str, direction: float) -> s.Inlet | None:
    """Return what enters at the end where a phase with this direction enters."""
    table = scene.boundary.get("left" if direction > 0 else "right")
    found: s.Inlet | None = getattr(table, phase) if table is not None else None
    return found


def inlet_temperature(scene: s.ReactingScene, phase: str, direction: float, default: float = T_STANDARD) -> float:
    """Return the temperature of a stream that enters."""
    given = inlet(scene, phase, direction)
    if given is None:
        return default
    value = given.inflow if given.inflow is not None else given.fixed
    return constant(value)


def shares_of(phases: Mapping[str, s.SolidKind]) -> dict[str, float]:
    """Return the share of each solid phase in the volume of the particles."""
    total = sum(table.volume_share for table in phases.values())
    return {name: table.volume_share / total for name, table in phases.items()}


def sauter_mean(phases: Mapping[str, s.SolidKind]) -> float:
    """Return the diameter of spheres with the volume and surface of all [m]."""
    first, *others = phases.values()
    if not others:
        return first.particle_diameter
    return 1.0 / sum(share / phases[name].particle_diameter for name, share in shares_of(phases).items())


def mean_conductivity(phases: Mapping[str, s.SolidKind]) -> float | None:
    """Return the mean conductivity of all particles by volume [W/m/K]; None where that of a phase is not known."""
    known = [table.conductivity for table in phases.values()]
    if None in known:
        return None
    return sum(share * float(k or 0.0) for share, k in zip(shares_of(phases).values(), known, strict=True))
