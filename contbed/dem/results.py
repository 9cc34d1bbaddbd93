"""What a run of a scene of particles found: effective conductivity, shares of the
mechanisms, profile, balance.
"""

from __future__ import annotations

import numpy as np

from contbed.arrays import Array
from contbed.balance import Balance
from contbed.dem.network import Cell, Layers
from contbed.dem.plan import ParticlePlan
from contbed.dem.statistics import surface
from contbed.fields import header
from contbed.result import Result


def fill(
    result: Result,
    plan: ParticlePlan,
    found: Layers | Cell,
    contacts: int,
    factor: float,
) -> None:
    """Fill the result from the solved network; `factor` is the correction of contact
    radii.
    """
    scene = plan.scene
    if isinstance(found, Cell):
        _fill_cell(result, found)
    else:
        _fill_layers(result, plan, found)
    k = found.mean
    result.qoi |= {
        "porosity": plan.porosity,
        "coordination": 2.0 * contacts / len(plan.x),
        "k_eff [W/m/K]": k,
    }
    if scene.particles.packing is not None:
        result.qoi["height [m]"] = surface(plan.x, plan.radius)
    if scene.gas is not None:
        result.qoi["k_eff_over_k_fluid"] = k / scene.gas.conductivity
    lattice, radius = scene.particles.lattice, scene.solid.radius
    if lattice is not None and radius is not None:
        scale = scene.solid.conductivity * lattice.contact_radius * factor
        result.qoi["k_eff_over_contact_scale"] = k * radius / scale


def _fill_cell(result: Result, cell: Cell) -> None:
    names, k = "xyz", cell.mean
    result.qoi |= {
        f"k_{names[a]}{names[b]} [W/m/K]": float(cell.conductivity[a, b])
        for a in range(3)
        for b in range(a, 3)
    }
    result.qoi |= {
        f"share_{name}": float(np.trace(part)) / 3.0 / k
        for name, part in cell.parts.items()
    }


def _fill_layers(result: Result, plan: ParticlePlan, layers: Layers) -> None:
    result.qoi |= {f"share_{name}": share for name, share in layers.shares.items()}
    result.qoi |= {
        "heat [W]": layers.heat,
        "k_between_layers [W/m/K]": layers.between,
        "isolated": layers.isolated,
    }
    leaving = layers.heat * (1.0 - layers.imbalance)
    result.balances["energy"] = Balance(
        layers.heat, leaving, "W", scale=abs(layers.heat)
    ).as_dict()
    result.profiles |= _profile(plan.x[:, 2], layers.T, float(plan.radius.mean()))


def _profile(z: Array, T: Array, thickness: float) -> dict[str, Array]:
    """Average height [m] and temperature [K] of the particles in slices of a
    thickness [m].
    """
    known = np.isfinite(T)
    slot = ((z[known] - z[known].min()) / thickness).astype(int)
    count = np.bincount(slot)
    kept = count > 0
    means = [np.bincount(slot, value[known])[kept] / count[kept] for value in (z, T)]
    return {header("z"): means[0], header("T_solid"): means[1]}
