"""What a two-fluid run finds: rows over time, tables along and across the bed,
balance, named results.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from contbed.balance import Balance
from contbed.two_fluid import filters, momentum_budget, wall_shear
from contbed.two_fluid import scene as t
from contbed.two_fluid.averages import Averages, along, spectrum
from contbed.two_fluid.closures import (
    ABSENT,
    MIN_REPORTED_FRACTION,
    dissipative_restitution,
)
from contbed.two_fluid.conditions import Wall, of_kind
from contbed.two_fluid.fv.grid import Grid
from contbed.two_fluid.of_fluidized import SPECTRUM, fluidized_findings
from contbed.two_fluid.simulation import Simulation
from contbed.two_fluid.vessel import depth

if TYPE_CHECKING:
    from contbed.two_fluid.state import Energy

COLUMNS = ("t [s]", "pressure_drop [Pa]", "solids [kg]", "centre_of_solids [m]", "u_solid_max [m/s]",
           "theta_mean [m2/s2]", "eps_s_max [1]", "dt [s]")  # fmt: skip
WITH_HEAT = (
    "T_gas_mean [K]",
    "T_solid_mean [K]",
    "T_gas_max [K]",
    "T_solid_max [K]",
    "p0 [Pa]",
)

BINS = 200  # along the bed at most
WALL_BINS = 64  # across it
# cosine between the wall's normal and the radius, all around, of a bed that counts as
# round
ROUND = 0.95


def held(bed: Simulation) -> float:
    """Mass of the particles [kg]; in a plane per metre of depth, on a line per
    square metre.
    """
    return float(
        bed.model.materials.rho_solid
        * (bed.state.eps_s @ bed.model.grid.geometry.volume)
    )


def contents(bed: Simulation) -> dict[str, float]:
    """Return what has a balance: mass of the particles; with heat also mass of the
    gas [kg] and heat [J].
    """
    solids = {"solids": held(bed)}
    if bed.state.energy is None:
        return solids
    from contbed.two_fluid.heat.equations import stored_heat

    gas = float(bed.state.energy.mass @ bed.model.grid.geometry.volume)
    return solids | {"gas": gas, "heat": stored_heat(bed.state, bed.model)}


def columns(bed: Simulation) -> tuple[str, ...]:
    """Headers of the rows over time."""
    if bed.model.heat is None:
        return COLUMNS
    from contbed.two_fluid.heat import wall_results

    warm = WITH_HEAT[: 4 + bed.model.heat.ideal]
    return (*COLUMNS, *warm, *wall_results.columns(bed))


def row(bed: Simulation) -> list[float]:
    """One row under the `columns`."""
    s, volume, height = (
        bed.state.eps_s,
        bed.model.grid.geometry.volume,
        bed.model.grid.centres[:, -1],
    )
    mass = s * volume
    total = max(float(mass.sum()), 1e-300)
    warm = [] if bed.state.energy is None else _temperatures(bed, bed.state.energy)
    return [
        bed.state.time,
        pressure_drop(bed),
        held(bed),
        float(mass @ height) / total,
        fastest(bed),
        float(mass @ bed.state.theta) / total,
        float(s.max()),
        bed.state.dt,
        *warm,
    ]


def _temperatures(bed: Simulation, heat: Energy) -> list[float]:
    """Means by volume of the phase, and the hottest gas and particles; those of particles are nan
    where none are left.
    """
    volume = bed.model.grid.geometry.volume
    solid = bed.state.eps_s * volume
    gas = volume - solid
    hottest = float(
        np.max(
            heat.T_solid, where=bed.state.eps_s > MIN_REPORTED_FRACTION, initial=-np.inf
        )
    )
    held = float(solid.sum())
    from contbed.two_fluid.heat import wall_results

    return [
        float(gas @ heat.T_gas / gas.sum()),
        float(solid @ heat.T_solid) / held if held > 0.0 else np.nan,
        float(heat.T_gas.max()),
        hottest if hottest > 0.0 else np.nan,
        *([heat.p0] if bed.model.heat is not None and bed.model.heat.ideal else []),
        *wall_results.row(bed),
    ]


def pressure_drop(bed: Simulation) -> float:
    """Pressure [Pa] on the floor less that on the roof or outlet, means over their
    areas.
    """
    floor, roof = bed.model.ends
    return floor.mean(bed.state.p) - roof.mean(bed.state.p)


def fastest(bed: Simulation) -> float:
    """Largest speed of particles [m/s]."""
    speed = np.linalg.norm(bed.state.u_solid, axis=1)
    return float(
        np.max(speed, where=bed.state.eps_s > MIN_REPORTED_FRACTION, initial=0.0)
    )


def balances(bed: Simulation, start: dict[str, float]) -> dict[str, dict[str, Any]]:
    """Balance what came in, went out and stayed of what is `contents`."""
    rho, account, now = bed.model.materials.rho_solid, bed.state.account, contents(bed)
    found = {
        "solids": _balance(
            rho * account.solid_in, rho * account.solid_out, 0.0, start, now, "solids"
        )
    }
    if bed.state.energy is not None:
        a = bed.state.energy.account
        found["gas"] = _balance(a.gas_in, a.gas_out, 0.0, start, now, "gas")
        found["heat"] = _balance(a.heat_in, a.heat_out, a.walls, start, now, "heat")
    return found


def _balance(
    came: float,
    went: float,
    walls: float,
    start: Mapping[str, float],
    now: Mapping[str, float],
    what: str,
) -> dict[str, Any]:
    scale, unit = max(start[what], came, 1e-300), "J" if what == "heat" else "kg"
    return Balance(came, went, unit, walls, now[what] - start[what], scale).as_dict()


def tables(
    plan: Any, bed: Simulation, averages: Averages | None, rows: dict[str, np.ndarray]
) -> dict[str, dict[str, Any]]:
    """Return axial.csv and, where there is a lateral direction, lateral.csv.

    They hold averages, or the last state without them. With averages there is also
    spectrum.csv, the power of the pressure drop by frequency.
    """
    fields = bed.state.fields() if averages is None else averages.means()
    volume, centres = bed.model.grid.geometry.volume, bed.model.grid.centres
    s = fields["eps_s"]
    values = {
        "eps_s [1]": s,
        "u_solid [m/s]": fields["u_solid"][:, -1],
        "u_gas [m/s]": fields["u_gas"][:, -1],
        "theta [m2/s2]": fields["theta"],
        "p [Pa]": fields["p"],
    }
    warm = {name: fields[name] for name in ("T_gas", "T_solid") if name in fields}
    values |= {f"{name} [K]": value for name, value in warm.items()}
    weights = {"T_gas [K]": 1.0 - s, "T_solid [K]": s} if warm else {}
    weights |= {"u_solid [m/s]": s, "theta [m2/s2]": s, "u_gas [m/s]": 1.0 - s}
    if averages is not None:
        for name in ("theta_total [m2/s2]", "speed_solid [m/s]"):
            values[name], weights[name] = fields[name.partition(" ")[0]], s
    corners = plan.mesh.skfem.p[:, plan.mesh.skfem.t].T
    height = centres[:, -1]
    place, columns = along(
        height, volume, values, weights, min(BINS, _layers(height, corners[..., -1]))
    )
    found = {"axial": {"height [m]": place, **columns}}
    if bed.model.grid.dimension > 1:
        window = plan.scene.output.window
        inside = np.full(len(volume), True)
        if window is not None:
            inside = (height >= window.start) & (height <= window.end)
        pick = {name: value[inside] for name, value in values.items()}
        lean = {name: value[inside] for name, value in weights.items()}
        name, lateral = across(bed.model.grid)
        x = lateral(centres[inside])
        bins = min(WALL_BINS, _layers(x, lateral(corners)))
        place, columns = along(x, volume[inside], pick, lean, bins)
        found["lateral"] = {name: place, **columns}
        if plan.scene.output.levels:
            found["levels"] = _levels(plan, bed, values, weights)
    late = np.zeros(0) if averages is None else rows["t [s]"] >= averages.start
    if late.sum() >= SPECTRUM:
        frequency, power = spectrum(
            rows["t [s]"][late], rows["pressure_drop [Pa]"][late]
        )
        found["spectrum"] = {
            "frequency [Hz]": frequency,
            "spectral_density [Pa2 s]": power,
        }
    return found


def _levels(
    plan: Any,
    bed: Simulation,
    values: dict[str, np.ndarray],
    weights: dict[str, np.ndarray],
) -> dict[str, np.ndarray]:
    """Lateral profiles at each of `output.levels`, of the cells that the level cuts."""
    corners = plan.mesh.skfem.p[:, plan.mesh.skfem.t].T[bed.model.grid.cells]
    low, high = corners[..., -1].min(axis=1), corners[..., -1].max(axis=1)
    volume, (name, lateral) = bed.model.grid.geometry.volume, across(bed.model.grid)
    parts: dict[str, list[np.ndarray]] = {}
    for level in plan.scene.output.levels:
        cut = (low <= level) & (level < high)
        x = lateral(bed.model.grid.centres[cut])
        place, columns = along(
            x,
            volume[cut],
            {key: value[cut] for key, value in values.items()},
            {key: value[cut] for key, value in weights.items()},
            _layers(x, lateral(corners[cut])),
        )
        for key, column in {
            "height [m]": np.full(len(place), level),
            name: place,
            **columns,
        }.items():
            parts.setdefault(key, []).append(column)
    return {key: np.concatenate(columns) for key, columns in parts.items()}


def across(grid: Grid) -> tuple[str, Callable[[np.ndarray], np.ndarray]]:
    """Return the name of the lateral coordinate and its value at points (..., dim).

    It is the distance from the middle where a bed in 3-D is round, or else the first
    coordinate.
    """
    if grid.dimension == 3:
        side = np.abs(grid.geometry.normal[:, 2]) < 0.5
        side[: grid.interior] = False
        normal, wall = grid.geometry.normal[side, :2], grid.middles[side, :2]
        middle = 0.5 * (
            wall.min(axis=0, initial=np.inf) + wall.max(axis=0, initial=-np.inf)
        )
        outwards = (wall - middle) / np.linalg.norm(wall - middle, axis=1)[:, None]
        oblique = np.abs(normal).max(axis=1, initial=0.0) < ROUND
        if oblique.any() and ((normal * outwards).sum(axis=1) > ROUND).all():
            return "r [m]", lambda points: np.linalg.norm(
                points[..., :2] - middle, axis=-1
            )
    return "r [m]" if grid.axisymmetric else "x [m]", lambda points: points[..., 0]


def _layers(position: np.ndarray, corners: np.ndarray) -> int:
    """How many different positions cells have, to a thousandth of the extent, but
    not more than cells fit in a row.
    """
    span = max(float(np.ptp(position)), 1e-300)
    places = len(np.unique(np.round((position - position.min()) / span, 3)))
    return min(places, 1 + round(span / float(np.median(np.ptp(corners, axis=-1)))))


def results(
    plan: Any,
    bed: Simulation,
    start: dict[str, float],
    averages: Averages | None,
    rows: dict[str, np.ndarray],
    tables: dict[str, dict[str, Any]],
) -> dict[str, Any]:
    """Named results; those of check cases only where the scene is such a case."""
    scene: t.TwoFluidScene = plan.scene
    last = dict(zip(columns(bed), row(bed), strict=True))
    found: dict[str, Any] = {
        "time [s]": bed.state.time,
        "steps": bed.state.steps,
        "mass_drift_relative": balances(bed, start)["solids"]["relative_residual"],
        "max_velocity": last["u_solid_max [m/s]"],
        "theta_final": last["theta_mean [m2/s2]"],
        "eps_s_max": last["eps_s_max [1]"],
        "pressure_drop [Pa]": last["pressure_drop [Pa]"],
    }
    slip = _slip(bed)
    if np.isfinite(slip):
        found["slip_velocity"] = slip
    if bed.model.heat is not None:
        from contbed.two_fluid.heat import wall_results

        warm = WITH_HEAT[: 4 + bed.model.heat.ideal]
        found |= {name: last[name] for name in warm}
        since = 0.0 if averages is None else averages.start
        found |= wall_results.results(bed, rows, since)
    weight = scene.two_fluid.gravity * bed.model.materials.rho_solid
    found["weight_of_solids"] = weight * depth(bed.model.grid, bed.state.eps_s)
    found |= filters.results(scene)
    if scene.closures.effective_restitution != ABSENT:
        found["effective_restitution"] = dissipative_restitution(scene)
    shear = _shear(scene, plan)
    if shear:
        speed = shear * bed.model.materials.d_p
        found["theta_over_s2d2"] = last["theta_mean [m2/s2]"] / speed**2
    found |= _fronts(scene, bed)
    if averages is not None:
        late = rows["t [s]"] >= averages.start
        found["pressure_drop_mean [Pa]"] = float(
            np.mean(rows["pressure_drop [Pa]"][late])
        )
        found["averaged [s]"] = float(averages.weight.sum())
        found["difference_of_halves"] = averages.drift()
        if found["weight_of_solids"] > 0.0:
            found |= momentum_budget.shares(averages.forces())
    found |= wall_shear.results(bed)
    found |= fluidized_findings(scene, bed, averages)
    if "spectrum" in tables:
        frequency, power = tables["spectrum"].values()
        found["dominant_frequency [Hz]"] = float(frequency[np.argmax(power)])
    return found


def _slip(bed: Simulation) -> float:
    """Mean velocity of the gas past the particles in the middle fifth of the
    height [m/s]; nan where there are none.
    """
    height = bed.model.grid.centres[:, -1]
    low, span = height.min(), np.ptp(height)
    middle = (np.abs(height - low - 0.5 * span) <= 0.1 * span) & (
        bed.state.eps_s > 1e-12
    )
    mass = (bed.state.eps_s * bed.model.grid.geometry.volume)[middle]
    past = (bed.state.u_gas - bed.state.u_solid)[middle, -1]
    return float(mass @ past / mass.sum()) if middle.any() else float("nan")


def _shear(scene: t.TwoFluidScene, plan: Any) -> float:
    """Rate of shear between two walls that move [1/s], or of the start."""
    moving = [
        part.velocity[0]
        for part in of_kind(scene.boundary, Wall).values()
        if part.velocity
    ]
    if len(moving) == 2:
        return abs(moving[0] - moving[1]) / float(np.ptp(plan.mesh.skfem.p[-1]))
    return abs(scene.initial.shear)


def _fronts(scene: t.TwoFluidScene, bed: Simulation) -> dict[str, Any]:
    """Fronts on a line: of settling from a uniform start, or of a jump in the start
    that runs at c = sqrt(theta).
    """
    if bed.model.grid.dimension > 1:
        return {}
    order = np.argsort(bed.model.grid.centres[:, 0])
    x, s = bed.model.grid.centres[order, 0], bed.state.eps_s[order]
    start, solid = scene.initial, scene.initial.solid
    if not start.layer and solid.volume_fraction > 0 and scene.two_fluid.gravity > 0:
        densest = 0.5 * (solid.volume_fraction + scene.solid.packing_limit)
        return {
            "front_position_m": _crossing(x, s, 0.5 * solid.volume_fraction, -1),
            "lower_front_position_m": _crossing(x, s, densest, 0),
        }
    if (
        scene.two_fluid.granular_temperature == "frozen"
        and len(start.layer) == 1
        and solid.granular_temperature > 0
    ):
        jump, c = start.layer[0].end, solid.granular_temperature**0.5
        right = s[-1]
        way = c * bed.state.time
        # between the tail of the fan and the shock the state is uniform; its middle
        # third is read
        between = (x > jump - 0.1 * way) & (x < jump + 0.3 * way)
        star = float(np.median(s[between])) if between.any() else float("nan")
        return {
            "eps_star": star,
            "shock_speed": (_crossing(x, s, 0.5 * (star + right), -1) - jump)
            / max(way, 1e-300),
        }
    return {}


def _crossing(x: np.ndarray, s: np.ndarray, level: float, which: int) -> float:
    """Where s falls through a level, the first or the last time."""
    falls = np.flatnonzero((s[:-1] >= level) & (s[1:] < level))
    if not len(falls):
        return float("nan")
    i = falls[which]
    return float(x[i] + (s[i] - level) / (s[i] - s[i + 1]) * (x[i + 1] - x[i]))
