"""What a run of particles in a gas found: profiles over time, coefficients by
mechanism, balances, closure ranges.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from contbed.balance import Balance
from contbed.cfd_dem.closures import bound
from contbed.cfd_dem.coupling import Bed
from contbed.cfd_dem.heat_transfer import Average
from contbed.cfd_dem.history import History
from contbed.cfd_dem.plan import GasPlan
from contbed.dem.failure import STRIDE
from contbed.dem.simulation import Simulation
from contbed.result import Result, beyond_ranges

# K; heat that warms the particles by less is not known to the ten digits that balances
# are held to
ROUNDING = 0.01
# of the particles, below which a closure out of its range is left to its table
FEW_PARTICLES = 0.01
PERCENTILES = (5, 50, 95)  # of the coefficients of single particles
# resistance of particles to heat over that of the gas around, from which a run warns
LARGE_INSIDE = 0.05


def fill(result: Result, plan: GasPlan, bed: Bed, history: History) -> None:
    """Fill the result with what is known at the end of a run, complete or not."""
    result.profiles |= history.columns
    result.balances["gas"] = _balance(
        bed.mass_balance(), "kg", float(bed.gas.mass.sum())
    )
    if bed.T is not None and (heat := bed.balance()):
        floor = max(abs(bed.gas.sums["gained"]), ROUNDING * float(bed.capacity.sum()))
        result.balances["energy"] = _balance(heat, "J", floor)
        result.qoi |= {
            "T_solid_mean_K": float(np.average(bed.T, weights=bed.capacity)),
            "T_fluid_max_K": float(bed.gas.T.max()),
        }
    result.qoi |= {
        "time [s]": bed.time,
        "bed_weight [Pa]": _weight(plan, bed.simulation),
        "above_grid": bed.above,
        "porosities_raised": bed.gas.counts["raised"],
    }
    for what, number in (
        (
            "particles above the grid of the gas, where they feel none; enlarge "
            "particles.height",
            bed.above,
        ),
        ("porosities below 0.2, raised", bed.gas.counts["raised"]),
    ):
        if number:
            result.warnings.append(f"{number} times {what}")
    if bed.simulation.halvings:
        result.warnings.append(_shorter(bed.simulation))
    if history.average.count:
        _fill_averages(result, plan, bed, history)


def _weight(plan: GasPlan, simulation: Simulation) -> float:
    """Return the weight of the particles over the cross-section [Pa]."""
    weight = -float(simulation.gravity[2]) * float(simulation.mass.sum())
    return weight / float(np.prod(plan.scene.particles.width))


def _shorter(simulation: Simulation) -> str:
    """Say that the run went on with a shorter step of the particles."""
    halvings, step = simulation.halvings, simulation.time_step
    return (
        f"particles were too fast for their time step, which was halved {halvings} "
        f"time{'s' * (halvings > 1)}, "
        f"to {step:.3g} s: it resolves speeds up to "
        f"{STRIDE * simulation.radius.min() / step:.3g} m/s"
    )


def _fill_averages(result: Result, plan: GasPlan, bed: Bed, history: History) -> None:
    average = history.average
    if average.mean:
        _fill_coefficients(result, average)
        if bed.T is not None:
            result.warnings += _inside(plan, bed, average)
    result.qoi |= {
        "coordination": average.coordination,
        "porosity": float(average.eps.mean()),
        "samples": average.count,
    }
    columns = history.columns
    late = columns["t [s]"] >= plan.scene.time.average_from * (1.0 - 1e-9)
    lasted = np.diff(columns["t [s]"], prepend=0.0)
    for name in ("pressure_drop [Pa]", "height [m]"):
        result.qoi[name] = float(columns[name][late].mean())
    if history.levels.heights:
        result.tables["levels"] = history.levels.table()
    for tube in history.tubes:
        name = tube.heat.tube.name
        result.tables[f"tube_{name}"] = table = tube.table()
        for part in ("", "_contact", "_gap", "_convection"):
            result.qoi[f"h_tube_{name}{part} [W/m2/K]"] = float(
                table[f"h{part} [W/m2/K]"].mean()
            )
        result.closures.append(tube.heat.tube.nusselt.use().to_dict())
    for name in history.heating:
        result.qoi[f"heat_tube_{name} [W]"] = float(
            np.average(columns[f"{name} heat_tube [W]"][late], weights=lasted[late])
        )
    _fill_ranges(result, plan, bed, history)


def _fill_coefficients(result: Result, average: Average) -> None:
    """Add the coefficients by mechanism, means over the bed and percentiles."""
    mean, total = average.mean, average.total
    result.qoi |= {
        f"h_{name} [W/m2/K]": value for name, value in average.bed_means().items()
    }
    result.qoi["h_total [W/m2/K]"] = float(total.mean())
    conduction = total - mean["convection"] - mean.get("radiation", 0.0)
    for name, values in (
        ("convection", mean["convection"]),
        ("conduction", conduction),
        ("total", total),
    ):
        result.qoi[f"h_{name}_percentiles [W/m2/K]"] = np.percentile(
            values, PERCENTILES
        ).tolist()


def _inside(plan: GasPlan, bed: Bed, average: Average) -> list[str]:
    """Warn of particles that conduct badly: each has one temperature, so that the
    resistance inside, R/(5 k) of a sphere that cools slowly, is left out.
    """
    k, R = plan.scene.solid.conductivity, bed.simulation.radius
    share = float((average.mean["convection"] * R).mean()) / (5.0 * k)
    if share < LARGE_INSIDE:
        return []
    return [
        "each particle has one temperature, but what it conducts inside resists by "
        f"{share:.2g} of what the gas does (h d/(2 k) = {5.0 * share:.2g}): heat "
        f"between gas and particles is up to {100.0 * share:.0f} % too large"
    ]


def _fill_ranges(result: Result, plan: GasPlan, bed: Bed, history: History) -> None:
    """Compare the averages at every particle with the ranges that drag and heat
    transfer are declared for.
    """
    average = history.average
    known = {
        "Re": average.Re,
        "Pr": average.Pr,
        "eps": average.eps,
        "d_p": 2.0 * bed.simulation.radius,
        "mu": float(np.mean(bed.gas.fluid.viscosity(bed.gas.T))),
    }
    used = [closure.use(**known).to_dict() for closure in bound(plan.scene).values()]
    result.closures += used
    result.warnings += beyond_ranges(used, FEW_PARTICLES)


def _balance(parts: Mapping[str, float], unit: str, floor: float) -> dict[str, Any]:
    """Balance the parts in, out, source and stored against the largest of them and
    `floor`.
    """
    return Balance(
        parts["in"], parts["out"], unit, parts["source"], parts["stored"], floor=floor
    ).as_dict()
