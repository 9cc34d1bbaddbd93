"""What a two-fluid run finds: rows over time, tables along and across the bed, balance, named results."""

from __future__ import annotations

from typing import Any

import numpy as np

from contbed.two_fluid import settings as t
from contbed.two_fluid.simulation import TwoFluid
from contbed.two_fluid.statistics import Averages, along, spectrum

COLUMNS = ("t [s]", "pressure_drop [Pa]", "solids [kg]", "centre_of_solids [m]", "u_solid_max [m/s]",
           "theta_mean [m2/s2]", "eps_s_max [1]", "dt [s]")  # fmt: skip
SCANT = 1e-6  # fraction of particles below which their speed says nothing
BINS = 200  # along the bed at most
WALL_BINS = 64  # across it
SPECTRUM = 64  # samples from which a spectrum is taken


def held(bed: TwoFluid) -> float:
    """Mass of the particles [kg]; in a plane per metre of depth, on a line per square metre."""
    return float(bed.materials.rho_solid * (bed.eps_s @ bed.grid.geometry.volume))


def row(bed: TwoFluid) -> list[float]:
    """One row under COLUMNS."""
    s, volume, height = bed.eps_s, bed.grid.geometry.volume, bed.grid.centres[:, -1]
    mass = s * volume
    total = max(float(mass.sum()), 1e-300)
    low, high = height <= height.min() * (1 + 1e-9) + 1e-12, height >= height.max() * (1 - 1e-9) - 1e-12
    return [bed.time, float(bed.p[low].mean() - bed.p[high].mean()), held(bed), float(mass @ height) / total,
            fastest(bed), float(mass @ bed.theta) / total, float(s.max()), bed.dt]  # fmt: skip


def fastest(bed: TwoFluid) -> float:
    """Largest speed of particles [m/s]."""
    speed = np.linalg.norm(bed.u_solid, axis=1)
    return float(np.max(speed, where=bed.eps_s > SCANT, initial=0.0))


def balance(bed: TwoFluid, start: float) -> dict[str, Any]:
    """Solids: what came in, went out and stayed [kg]."""
    rho, account = bed.materials.rho_solid, bed.account
    came, went, now = rho * account["solid_in"], rho * account["solid_out"], held(bed)
    scale = max(start, came, 1e-300)
    return {"in": came, "out": went, "source": 0.0, "stored": now - start, "unit": "kg",
            "relative_residual": (now - start - came + went) / scale}  # fmt: skip


def tables(bed: TwoFluid, averages: Averages | None, scene: t.TwoFluidScene) -> dict[str, dict[str, Any]]:
    """axial.csv and, where there is a lateral direction, lateral.csv: averages, or the last state without them."""
    averaged = averages is not None and averages.weight.sum() > 0
    fields = averages.means() if averaged else _now(bed)  # type: ignore[union-attr]
    volume, centres = bed.grid.geometry.volume, bed.grid.centres
    s = fields["eps_s"]
    values = {"eps_s [1]": s, "u_solid [m/s]": fields["u_solid"][:, -1], "u_gas [m/s]": fields["u_gas"][:, -1],
              "theta [m2/s2]": fields["theta"], "p [Pa]": fields["p"]}  # fmt: skip
    weights = {"u_solid [m/s]": s, "theta [m2/s2]": s, "u_gas [m/s]": 1.0 - s}
    if averaged:
        values["theta_total [m2/s2]"] = fields["theta_total"]
        weights["theta_total [m2/s2]"] = s
    found = {}
    place, columns = along(centres[:, -1], volume, values, weights, min(BINS, _layers(centres[:, -1])))
    found["axial"] = {"height [m]": place, **columns}
    if bed.grid.dimension > 1:
        window = scene.output.window
        inside = np.full(len(volume), True)
        if window is not None:
            inside = (centres[:, -1] >= window.start) & (centres[:, -1] <= window.end)
        pick = {name: value[inside] for name, value in values.items()}
        lean = {name: value[inside] for name, value in weights.items()}
        x = centres[inside, 0]
        place, columns = along(x, volume[inside], pick, lean, min(WALL_BINS, _layers(x)))
        found["lateral"] = {"r [m]" if bed.grid.axisymmetric else "x [m]": place, **columns}
    return found


def _now(bed: TwoFluid) -> dict[str, np.ndarray]:
    return {name: getattr(bed, name) for name in ("eps_s", "u_gas", "u_solid", "theta", "p")}


def _layers(position: np.ndarray) -> int:
    """How many different positions cells have, to a thousandth of the extent."""
    span = max(float(np.ptp(position)), 1e-300)
    return len(np.unique(np.round((position - position.min()) / span, 3)))


def arguments(bed: TwoFluid, scene: t.TwoFluidScene) -> dict[str, np.ndarray | float]:
    """What closures were given in the last state, where there are particles."""
    there = bed.eps_s > SCANT
    if not there.any():
        there[:] = True
    s = bed.eps_s[there]
    m = bed.materials
    slip = np.linalg.norm(bed.u_gas - bed.u_solid, axis=1)[there]
    g0 = bed.rheology.g0[there]
    return {"eps_s": s, "eps": 1.0 - s, "Re": (1.0 - s) * m.rho_gas * slip * m.d_p / m.mu_gas, "d_p": m.d_p,
            "mu": m.mu_gas, "g0": g0, "e": scene.solid.restitution, "eps_max": m.eps_max}  # fmt: skip


def results(
    plan: Any, bed: TwoFluid, start: float, averages: Averages | None, rows: dict[str, np.ndarray]
) -> dict[str, Any]:
    """Named results; those of check cases only where the scene is such a case."""
    scene: t.TwoFluidScene = plan.scene
    last = row(bed)
    found: dict[str, Any] = {
        "time [s]": bed.time,
        "steps": bed.steps,
        "mass_drift_relative": balance(bed, start)["relative_residual"],
        "max_velocity": last[4],
        "theta_final": last[5],
        "eps_s_max": last[6],
        "pressure_drop [Pa]": last[1],
        "slip_velocity": _slip(bed),
    }
    weight = scene.two_fluid.gravity * last[2]
    if bed.grid.dimension > 1 and not bed.grid.axisymmetric:
        weight /= float(np.ptp(plan.mesh.skfem.p[0]))
    found["weight_of_solids"] = weight
    shear = _shear(scene, plan)
    if shear:
        found["theta_over_s2d2"] = last[5] / (shear * bed.materials.d_p) ** 2
    found |= _fronts(scene, bed)
    if averages is not None and averages.weight.sum() > 0:
        late = rows["t [s]"] >= averages.start
        found["pressure_drop_mean [Pa]"] = float(np.mean(rows["pressure_drop [Pa]"][late]))
        found["averaged [s]"] = float(averages.weight.sum())
        found["difference_of_halves"] = averages.drift()
        if late.sum() >= SPECTRUM:
            frequency, power = spectrum(rows["t [s]"][late], rows["pressure_drop [Pa]"][late])
            found["dominant_frequency [Hz]"] = float(frequency[np.argmax(power)])
    return found


def _slip(bed: TwoFluid) -> float:
    """Mean velocity of the gas past the particles in the middle fifth of the height [m/s]."""
    height = bed.grid.centres[:, -1]
    low, span = height.min(), np.ptp(height)
    middle = (np.abs(height - low - 0.5 * span) <= 0.1 * span) & (bed.eps_s > 1e-12)
    mass = (bed.eps_s * bed.grid.geometry.volume)[middle]
    past = (bed.u_gas - bed.u_solid)[middle, -1]
    return float(mass @ past / mass.sum()) if middle.any() else 0.0


def _shear(scene: t.TwoFluidScene, plan: Any) -> float:
    """Rate of shear between two walls that move [1/s], or of the start."""
    moving = [part.velocity[0] for part in scene.boundary.values() if isinstance(part, t.Wall) and part.velocity]
    if len(moving) == 2:
        return abs(moving[0] - moving[1]) / float(np.ptp(plan.mesh.skfem.p[-1]))
    return abs(scene.initial.shear)


def _fronts(scene: t.TwoFluidScene, bed: TwoFluid) -> dict[str, Any]:
    """Fronts on a line: of settling from a uniform start, or of a jump in the start that runs at c = sqrt(theta)."""
    if bed.grid.dimension > 1:
        return {}
    order = np.argsort(bed.grid.centres[:, 0])
    x, s = bed.grid.centres[order, 0], bed.eps_s[order]
    start = scene.initial
    if not start.layer and start.eps_s > 0 and scene.two_fluid.gravity > 0:
        densest = 0.5 * (start.eps_s + scene.solid.packing)
        return {"front_position_m": _crossing(x, s, 0.5 * start.eps_s, -1),
                "lower_front_position_m": _crossing(x, s, densest, 0)}  # fmt: skip
    if scene.two_fluid.granular_temperature == "frozen" and len(start.layer) == 1 and start.theta > 0:
        jump, c = start.layer[0].end, start.theta**0.5
        right = s[-1]
        way = c * bed.time
        # between the tail of the fan and the shock the state is uniform; its middle third is read
        between = (x > jump - 0.1 * way) & (x < jump + 0.3 * way)
        star = float(np.median(s[between])) if between.any() else float("nan")
        return {"eps_star": star, "shock_speed": (_crossing(x, s, 0.5 * (star + right), -1) - jump) / max(way, 1e-300)}
    return {}


def _crossing(x: np.ndarray, s: np.ndarray, level: float, which: int) -> float:
    """Where s falls through a level, the first or the last time."""
    falls = np.flatnonzero((s[:-1] >= level) & (s[1:] < level))
    if not len(falls):
        return float("nan")
    i = falls[which]
    return float(x[i] + (s[i] - level) / (s[i] - s[i + 1]) * (x[i + 1] - x[i]))
