"""Profiles and named results of a stand-alone radiating medium."""

from __future__ import annotations

from typing import Any

import numpy as np

from contbed.fem.probe import Line
from contbed.fields import header
from contbed.radiation.plan import Plan
from contbed.result import Result
from contbed.scene.mesh import power_units


def fill(
    plan: Plan,
    line: Line,
    problem: Any,
    state: Any,
    fluxes: dict[str, float],
    conducted: dict[str, float],
    result: Result,
) -> None:
    """Fill in temperature, G and radiative flux along the axis, and the heat through
    each boundary.

    Between two plates also the dimensionless flux q/(sigma (T1^4 - T2^4)) and the
    temperature slip 1 - Phi(0).
    """
    positions, probe = line.positions, line.probe
    space, G, temperature = (
        problem.space,
        problem.incident(state),
        problem.temperature(state),
    )
    result.profiles = {
        header(plan.coordinate): positions,
        "T_solid [K]": probe(space, temperature),
        "G [W/m2]": probe(space, G),
        "q_radiation [W/m2]": problem.flux(state, probe),
    }
    result.nodal |= {"G": (space, G), "T_solid": (space, temperature)}
    optics = problem.optics
    extent = float(np.ptp(plan.mesh.skfem.p[plan.mesh.axis]))
    result.qoi |= {
        "optical_thickness": optics.extinction * extent,
        "albedo": optics.scattering / optics.extinction,
    }
    result.qoi |= {
        f"heat_{name}_W": value + conducted[name] for name, value in fluxes.items()
    }
    result.units |= power_units(result.qoi, plan.scene.mesh)
    plates = [surface.power for _, _, surface in problem.surfaces]
    if plan.mesh.skfem.dim() == 1 and len(plates) == 2 and plates[0] != plates[1]:
        first = problem.surfaces[0][0]
        span = plates[0] - plates[1]
        result.qoi["flux_dimensionless"] = (fluxes[first] + conducted[first]) / span
        low = plan.mesh.skfem.boundaries[first]
        here = float(G[space.on_facets(low)[0]])
        result.qoi["temperature_slip"] = 1.0 - (here / 4.0 - plates[1]) / span
        result.qoi["flux_over_emissive_power"] = (
            fluxes[first] + conducted[first]
        ) / max(plates)
