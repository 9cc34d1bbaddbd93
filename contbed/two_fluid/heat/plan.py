"""What a two-fluid scene with [heat] builds: closures as functions of cells,
temperatures given.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np

from contbed.closures.optics import optical_coefficients, radiation_rosseland
from contbed.two_fluid import scene as t
from contbed.two_fluid.closures import Bound, conducts, constants
from contbed.two_fluid.conditions import Inlet, Wall
from contbed.two_fluid.fv.gradient import FEW_PARTICLES
from contbed.two_fluid.heat import wall_laws
from contbed.two_fluid.heat.model import Physics, Thermal

FIELDS = ("T_gas", "T_solid")


def physics(scene: t.TwoFluidScene, closures: Bound) -> Physics:
    """Heat capacities and closures of a scene with [heat]."""
    table, fluid, solid = scene.two_fluid, scene.fluid, scene.solid
    k, d_p, given = fluid.conductivity, solid.diameter, constants(scene)
    assert (
        k is not None
        and fluid.heat_capacity is not None
        and solid.heat_capacity is not None
    )
    nusselt, bed_conductivity = closures.get("nusselt"), closures.get("conductivity")

    def coefficient(
        eps_s: np.ndarray, slip: np.ndarray, dense: Any, T: np.ndarray
    ) -> np.ndarray:
        if nusselt is None:
            return np.full_like(eps_s, k / d_p * float(scene.closures.nusselt))  # type: ignore[arg-type]
        Re = (1.0 - eps_s) * fluid.density * dense * slip * d_p / fluid.viscosity
        return np.asarray(k / d_p * nusselt(Re=Re, eps=1.0 - eps_s, T=T, **given))

    def of_bed(
        eps_s: np.ndarray, T_gas: np.ndarray, T_solid: np.ndarray
    ) -> tuple[np.ndarray, np.ndarray]:
        assert bed_conductivity is not None
        whole = bed_conductivity(eps=1.0 - eps_s, T=T_solid, **given)
        part = k * (1.0 - np.sqrt(eps_s))
        return part, whole - part

    def of_phases(eps_s: np.ndarray, *_: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return table.conductivity_gas * (1.0 - eps_s), table.conductivity_solids * eps_s

    conductivity = of_bed if bed_conductivity is not None else of_phases
    return Physics(
        fluid.heat_capacity,
        solid.heat_capacity,
        coefficient,
        conductivity if conducts(scene.closures, table) else None,
        scene.gas.density_law,
        scene.gas.reference_temperature or scene.initial.gas.temperature or np.nan,
        scene.gas.pressure,
        wall_laws.wall_laws(scene, closures, given),
        radiative(scene),
    )


def radiative(
    scene: t.TwoFluidScene,
) -> Callable[[np.ndarray, np.ndarray], np.ndarray] | None:
    """Return the conductivity [W/m/K] of the radiation between particles; None without
    [radiation].
    """
    if scene.radiation is None:
        return None

    def of_cells(eps_s: np.ndarray, T_solid: np.ndarray) -> np.ndarray:
        dense = np.maximum(eps_s, FEW_PARTICLES)
        return np.asarray(radiation_rosseland(T_solid, transport(scene, dense)))

    return of_cells


def transport(scene: t.TwoFluidScene, eps_s: Any) -> Any:
    """Return the transport coefficient [1/m] of particles that radiate."""
    table, solid = scene.radiation, scene.solid
    assert table is not None
    each = [eps_s], [solid.diameter], [solid.emissivity]
    return optical_coefficients(*each, table.correction, table.anisotropy).transport


def initial(scene: t.TwoFluidScene, height: np.ndarray) -> dict[str, np.ndarray]:
    """Temperatures (nc,) at the start."""
    fields = {name: np.empty(len(height)) for name in FIELDS}
    for part in scene.initial.parts:
        inside = (height >= getattr(part, "start", -np.inf)) & (
            height < getattr(part, "end", np.inf)
        )
        T_gas = part.gas.temperature
        for name, value in (
            ("T_gas", T_gas),
            ("T_solid", part.solid.temperature or T_gas),
        ):
            if value is not None:
                fields[name][inside] = value
    return fields


def thermal(parts: Mapping[str, Any], scene: t.TwoFluidScene) -> dict[str, Thermal]:
    """Heat at boundaries by their names."""
    found = {}
    for name, part in parts.items():
        if isinstance(part, Inlet):
            T_gas = part.gas.temperature
            found[name] = Thermal(T_gas, part.solid.temperature or T_gas)
        elif isinstance(part, Wall):
            heated = part.outside is not None
            more = wall_laws.condition(name, part, scene) if heated else {}
            flux = part.heat_flux or 0.0
            found[name] = Thermal(wall=part.outside, flux=flux, **more)
    return found


def described(scene: t.TwoFluidScene) -> str:
    """One line for the plan."""
    density = (
        "ideal gas" if scene.gas.density_law == "ideal_gas" else "constant density"
    )
    conduction = "with" if conducts(scene.closures, scene.two_fluid) else "without"
    if scene.radiation is not None:
        conduction += " radiation and"
    return f"exchange {scene.closures.nusselt}, {conduction} conduction, {density}"
