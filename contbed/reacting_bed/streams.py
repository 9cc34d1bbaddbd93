"""Streams that enter a reacting bed: fluxes, temperatures, where they enter."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from contbed.closures.reactions import R_GAS
from contbed.materials.composition import mole_fractions
from contbed.materials.thermo import T_STANDARD
from contbed.reacting_bed import scene as s
from contbed.reacting_bed.inlet_series import constant
from contbed.reacting_bed.substances import Substances


@dataclass(frozen=True, eq=False)
class Streams:
    """What enters: fluxes per area of the bed.

    gas : mole flux of each gas [mol/m2/s], signed along x
    solid : inventory of each constituent where particles enter [mol/m3 bed], also of those that only reactions make
    """

    gas: dict[str, float]
    solid: dict[str, float]
    mass_flux: float
    T_gas: float
    T_solid: float
    pressure: float
    solids_density: float  # mass of particles per volume of bed [kg/m3]

    @property
    def ahead(self) -> bool:
        """Whether the gas flows along x."""
        return self.mass_flux > 0


def streams(scene: s.ReactingScene, species: Substances) -> Streams:
    """Return the streams that enter a scene without series."""
    fluid, flow, solid = scene.fluid, scene.flow, scene.solid
    sign = gas_sign(flow)
    T_gas = inlet_temperature(scene, "fluid", sign)
    direction = float(np.sign(constant(flow.velocity_solid))) or sign
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
    eps = scene.bed.porosity
    density = 0.0
    inside: dict[str, float] = {}
    if solid is not None:
        if solid.density is not None:
            density = solid.density
        elif species.fed:
            volume = sum(w / species.skeletal[name] for name, w in species.fed.items())
            density = (1.0 - solid.porosity) / volume
        density *= 1.0 - eps
        inside = {
            name: density * species.fed.get(name, 0.0) / species.solids[name].molar_mass for name in species.solids
        }
    return Streams(gas, inside, moles * mean, T_gas, T_solid, fluid.pressure, density)


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
