"""What a two-fluid scene with [heat] builds: closures as functions of cells, temperatures given."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from contbed.two_fluid import scene as t
from contbed.two_fluid.closures import Bound, constants
from contbed.two_fluid.heat.model import Physics, Thermal
from contbed.two_fluid.heat.scene import Heat, conducts

FIELDS = ("T_gas", "T_solid")


def physics(scene: t.TwoFluidScene, closures: Bound) -> Physics:
    """Heat capacities and closures of a scene with [heat]."""
    table, gas, d_p = scene.heat, scene.gas, scene.solid.particle_diameter
    assert table is not None
    k, given = table.conductivity_gas, constants(scene)
    nusselt, bed_conductivity = closures.get("nusselt"), closures.get("conductivity")

    def coefficient(eps_s: np.ndarray, slip: np.ndarray, dense: Any, T: np.ndarray) -> np.ndarray:
        if nusselt is None:
            return np.full_like(eps_s, k / d_p * float(table.nusselt))  # type: ignore[arg-type]
        Re = (1.0 - eps_s) * gas.density * dense * slip * d_p / gas.viscosity
        return np.asarray(k / d_p * nusselt(Re=Re, eps=1.0 - eps_s, T=T, **given))

    def of_bed(eps_s: np.ndarray, T_gas: np.ndarray, T_solid: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        assert bed_conductivity is not None
        whole = bed_conductivity(eps=1.0 - eps_s, T=T_solid, **given)
        part = k * (1.0 - np.sqrt(eps_s))
        return part, whole - part

    def of_phases(eps_s: np.ndarray, *_: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return table.effective_gas * (1.0 - eps_s), table.effective_solid * eps_s

    conductivity = of_bed if table.conductivity_bed is not None else of_phases
    return Physics(
        table.heat_capacity_gas,
        table.heat_capacity_solid,
        coefficient,
        conductivity if conducts(table) else None,
        table.density,
        table.T_reference or scene.initial.T_gas or np.nan,
        table.pressure,
    )


def initial(scene: t.TwoFluidScene, height: np.ndarray) -> dict[str, np.ndarray]:
    """Temperatures (nc,) at the start."""
    fields = {name: np.empty(len(height)) for name in FIELDS}
    for part in (scene.initial, *scene.initial.layer):
        inside = (height >= getattr(part, "start", -np.inf)) & (height < getattr(part, "end", np.inf))
        for name, value in (("T_gas", part.T_gas), ("T_solid", part.T_solid or part.T_gas)):
            if value is not None:
                fields[name][inside] = value
    return fields


def thermal(parts: Mapping[str, Any]) -> dict[str, Thermal]:
    """Heat at boundaries by their names."""
    found = {}
    for name, part in parts.items():
        if isinstance(part, t.Inlet):
            found[name] = Thermal(part.T_gas, part.T_solid or part.T_gas)
        elif isinstance(part, t.Wall):
            found[name] = Thermal(wall=part.T, flux=part.heat_flux or 0.0)
    return found


def described(table: Heat) -> str:
    """One line for the plan."""
    density = "ideal gas" if table.density == "ideal_gas" else "constant density"
    return f"exchange {table.nusselt}, {'with' if conducts(table) else 'without'} conduction, {density}"
