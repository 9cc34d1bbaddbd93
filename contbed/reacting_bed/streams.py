"""Streams that enter a reacting bed: fluxes, temperatures, where they enter."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from contbed.chemistry.thermo import R_GAS
from contbed.closures.packed_beds import surface_diameter
from contbed.materials.composition import mole_fractions
from contbed.materials.curve import Function, function_of
from contbed.reacting_bed import scene as s
from contbed.reacting_bed.inlet_series import constant
from contbed.reacting_bed.substances import PhaseSpecies, Substances

INWARD = {"left": 1.0, "right": -1.0}  # direction along x into the bed
Boundaries = Mapping[str, s.Boundary]


@dataclass(frozen=True, eq=False)
class Streams:
    """What enters: fluxes per area of the bed.

    gas : mole flux of each gas [mol/m2/s], signed along x
    solid : moles of each constituent where particles enter [mol/m3 bed], also of those
        that only reactions make
    T_solids : temperature of each solid phase [K]; of one at rest that of the gas, or
        of the first that moves
    shares, velocities, densities : of each solid phase its share of the volume of all
        particles, the superficial velocity along x as if it filled the bed [m/s], and
        the mass per volume of bed [kg/m3]
    """

    gas: dict[str, float]
    solid: dict[str, float]
    mass_flux: float
    T_gas: float
    T_solids: dict[str, float]
    pressure: float
    shares: dict[str, float]
    velocities: dict[str, float]
    densities: dict[str, float]

    @property
    def ahead(self) -> bool:
        """Whether the gas flows along x."""
        return self.mass_flux > 0

    @property
    def moles(self) -> float:
        """Molar flux of all gases, signed along x [mol/m2/s]."""
        return sum(self.gas.values())

    @property
    def mean_velocity(self) -> float:
        """Superficial velocity of all particles by volume [m/s]."""
        return sum(share * self.velocities[name] for name, share in self.shares.items())


def streams(scene: s.ReactingScene, species: Substances) -> Streams:
    """Return the streams that enter a scene without series."""
    boundary, pressure = scene.boundary, scene.gas.pressure
    table = gas_inlet(boundary)
    T_gas = temperature_of(table)
    composition = (
        scene.gas.composition if table.composition is None else table.composition
    )
    assert isinstance(composition, str)  # `checks` and `Schedule.frozen` see to it
    entering = mole_fractions(composition)
    mean = sum(x * species.gases[name].molar_mass for name, x in entering.items())
    side, key = flow_of_gas(boundary)
    flow = INWARD[side] * constant(getattr(boundary[side].gas, key))
    if key == "mass_flux":
        moles = flow / mean
    elif key == "molar_flux":
        moles = flow
    else:
        moles = flow * pressure / (R_GAS * T_gas)
    gas = {name: moles * entering.get(name, 0.0) for name in species.gases}
    shares = shares_of(scene.solids)
    velocities = {name: velocity_of(boundary, name) for name in scene.solids}
    densities, solid = {}, {}
    for name, given in scene.solids.items():
        phase = species.phases[name]
        density = particle_density(given, phase) * (1.0 - scene.packed_bed.porosity)
        densities[name] = shares[name] * density
        for constituent, data in phase.solids.items():
            moles_alone = density * phase.fed.get(constituent, 0.0) / data.molar_mass
            solid[phase.full(constituent)] = shares[name] * moles_alone
    T_solids = _temperatures_of_solids(boundary, velocities, T_gas)
    return Streams(
        gas,
        solid,
        moles * mean,
        T_gas,
        T_solids,
        pressure,
        shares,
        velocities,
        densities,
    )


def _temperatures_of_solids(
    boundary: Boundaries, velocities: Mapping[str, float], T_gas: float
) -> dict[str, float]:
    """Return the temperature of each solid phase where it enters."""
    moving = {}
    for name, velocity in velocities.items():
        if velocity:
            given = solid_inlet(boundary, name, velocity)
            T = None if given is None else given.temperature
            moving[name] = T_gas if T is None else constant(T)
    at_rest = next(iter(moving.values()), T_gas)
    return {name: moving.get(name, at_rest) for name in velocities}


def flow_of_gas(boundary: Boundaries) -> tuple[str, str]:
    """Return the boundary that gives the flow of the gas, and its key there; ""
    where none does.
    """
    for side in INWARD:
        table = boundary.get(side)
        for key in s.FLOWS:
            if (
                table is not None
                and table.gas is not None
                and getattr(table.gas, key) is not None
            ):
                return side, key
    return "", ""


def gas_sign(boundary: Boundaries) -> float:
    """Return the direction of the gas along x, 0 where none flows."""
    side, key = flow_of_gas(boundary)
    return (
        float(np.sign(INWARD[side] * constant(getattr(boundary[side].gas, key))))
        if side
        else 0.0
    )


def entry(direction: float) -> str:
    """Return the boundary where a stream with a direction along x enters."""
    return "left" if direction > 0 else "right"


def gas_inlet(boundary: Boundaries) -> s.GasCondition:
    """Return what enters of the gas."""
    table = boundary[entry(gas_sign(boundary))].gas
    assert table is not None  # `checks` sees to it
    return table


def temperature_of(table: s.GasCondition) -> float:
    """Return the temperature of the gas that enters [K]."""
    return constant(
        table.temperature
        if table.fixed_temperature is None
        else table.fixed_temperature
    )


def given_velocity(boundary: Boundaries, phase: str) -> tuple[str, Any]:
    """Return the boundary that gives the velocity of a solid phase, and the value;
    "" and 0 for one at rest.
    """
    for side in INWARD:
        table = boundary[side].solids.get(phase) if side in boundary else None
        if table is not None and table.velocity is not None:
            return side, table.velocity
    return "", 0.0


def velocity_of(boundary: Boundaries, phase: str) -> float:
    """Return the superficial velocity of a solid phase along x [m/s]."""
    side, value = given_velocity(boundary, phase)
    return INWARD[side] * constant(value) if side else 0.0


def solid_inlet(
    boundary: Boundaries, phase: str, velocity: float
) -> s.SolidCondition | None:
    """Return what the boundary says where a solid phase with a velocity along x
    enters.
    """
    side = entry(velocity)
    return boundary[side].solids.get(phase) if side in boundary else None


def particle_density(table: s.Solid, phase: PhaseSpecies) -> float:
    """Return the density of the particles of a phase as they enter [kg/m3], 0 where
    it is not known.
    """
    if table.density is not None:
        return table.density
    if not phase.fed:
        return 0.0
    volume = sum(w / phase.densities[name] for name, w in phase.fed.items())
    return (1.0 - table.porosity) / volume


def shares_of(solids: Mapping[str, s.Solid]) -> dict[str, float]:
    """Return the share of each solid phase in the volume of the particles."""
    total = sum(table.volume_share for table in solids.values())
    return {name: table.volume_share / total for name, table in solids.items()}


def mean_diameter(solids: Mapping[str, s.Solid]) -> float:
    """Return the mean of the diameters by the surface of each [m]."""
    return _mean_by_surface(
        {name: table.diameter for name, table in solids.items()}, solids
    )


def sauter_mean(solids: Mapping[str, s.Solid]) -> float:
    """Return the diameter of spheres with the volume and surface of all [m]."""
    diameters = {
        name: surface_diameter(table.diameter, table.shape)
        for name, table in solids.items()
    }
    return _mean_by_surface(diameters, solids)


def _mean_by_surface(
    diameters: Mapping[str, float], solids: Mapping[str, s.Solid]
) -> float:
    first, *others = diameters.values()
    if not others:
        return first
    return 1.0 / sum(
        share / diameters[name] for name, share in shares_of(solids).items()
    )


def mean_conductivity(solids: Mapping[str, s.Solid]) -> Function | None:
    """Return the mean conductivity of all particles by volume [W/m/K] as a function of
    temperature; None where that of a phase is not known.
    """
    shares = shares_of(solids)
    known = [
        (shares[name], function_of(table.conductivity))
        for name, table in solids.items()
        if table.conductivity is not None
    ]
    if len(known) < len(solids):
        return None
    return lambda T: sum(share * k(T) for share, k in known)
