"""Measured beds: the score of the models against them, and what the data of one bed
cannot say.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from scipy.optimize import least_squares

from contbed.loading import load
from contbed.many.validate import case, score
from contbed.many.validate.deviations import COVERAGE, Score
from contbed.many.validate.score import Validated
from contbed.materials.constants import fluid_of
from contbed.packed_bed.medium import solid_of
from contbed.runner import run
from studies import _gallery as gallery
from studies._gallery import Table, Tables

NOT_COMPARED = ("CPU [s]",)
STONE = "alonso_2022"
SHORT = ("alonso_2022", "beaulieu_2020", "pacheco_2002")  # beds with temperatures
ZERO_CELSIUS = 273.15  # K
STANDBY_HEIGHTS = (0.5, 1.0, 1.5, 2.0, 3.0, 4.0, 5.0, 5.5)  # m
# K, between which the stone is heated
COLD, HOT = 25.0 + ZERO_CELSIUS, 700.0 + ZERO_CELSIUS
# of the differences of the fit, relative: errors of the runs' time steps (1e-3) stay
# small beside them
STEP = 0.01


def compute(cases: tuple[str, ...] = ()) -> Tables:
    """Scores, points and influence of inputs of the measured beds, and the heat of
    the stone bed.
    """
    scores, points, influence = [], [], []
    for name in cases or SHORT:
        done = score.validate(case.read_case(name))
        scores += [_row(name, each, done) for each in done.compared.scores]
        points += [
            {
                "case": name,
                "t [s]": t,
                "position [m]": x,
                "measured [K]": m,
                "predicted [K]": p,
                "band [K]": b,
            }
            for t, x, m, p, b in zip(
                done.case.points.t,
                done.case.points.x,
                done.case.points.value,
                done.compared.predicted,
                done.compared.band,
                strict=True,
            )
        ]
        influence += [
            {"case": name, "input": key, "RMS change [K]": value}
            for key, value in done.compared.influence.items()
        ]
    tables = {"scores": Table.of(scores, ".4g"), "points": Table.of(points, ".6g")}
    return tables | {
        "influence": Table.of(influence, ".3g"),
        **_stone(),
        "standby": Table.of(_standby(), ".4g"),
    }


def reference(name: str) -> Table:
    """Measured points of one bed."""
    points = case.read_case(name).points
    return Table.from_columns(
        {"t [s]": points.t, "position [m]": points.x, "measured [K]": points.value}
    )


def _row(name: str, each: Score, done: Validated) -> dict[str, Any]:
    return {
        "case": name,
        "group": each.group,
        "points": str(each.points),
        "RMS [K]": each.rms,
        "bias [K]": each.bias,
        "data [K]": each.data,
        "band [K]": each.band,
        "verdict": "within" if each.within else "beyond",
        "CPU [s]": done.cpu if each.group == "all" else None,
    }


def heat_of_the_stone_bed(**changes: Any) -> tuple[float, float]:
    """Heat stored and heat supplied in the first hour [J/m2], from the measured
    temperatures and a scene's inputs.
    """
    stone = case.read_case(STONE)
    scene: Any = stone.scene(**changes)
    start, T_start = scene.initial.given("solid").samples(scene.origin.base, "T_solid")
    order = np.argsort(stone.points.x)
    x, T = stone.points.x[order], stone.points.value[order]
    z = np.linspace(0.0, scene.mesh.length, 2001)
    material, air = solid_of(scene.solid), fluid_of(scene.gas, scene.origin)
    gained = material.enthalpy(np.interp(z, x, T)) - material.enthalpy(
        np.interp(z, start, T_start)
    )
    stored = (
        (1.0 - scene.packed_bed.porosity)
        * float(material.density(COLD))
        * float(np.trapezoid(gained, z))
    )
    T_in = scene.boundary["right"].gas.temperature
    # what leaves has the lowest measured temperature, the mean of begin and end
    leaving = 0.5 * (float(air.enthalpy(T_start[0])) + float(air.enthalpy(T[0])))
    flux = scene.boundary["right"].gas.velocity * float(air.density(T_in))
    return stored, flux * float(np.max(stone.points.t)) * (
        float(air.enthalpy(T_in)) - leaving
    )


def _stone() -> Tables:
    """What would close the balance of the stone bed, by its deviations after 1 h,
    and what each then predicts.
    """
    stored, supplied = heat_of_the_stone_bed()
    stone = case.read_case(STONE)
    scene: Any = stone.scene()
    one, two = (
        _fit(stone, [scene.solid.heat_capacity]),
        _fit(stone, [scene.solid.heat_capacity] * 2),
    )
    beds: dict[str, dict[str, Any]] = {
        "as stated": {},
        "more air": {
            "boundary.right.gas.velocity": scene.boundary["right"].gas.velocity
            * stored
            / supplied
        },
        "lighter stone": {
            "solids.stone.density": scene.solid.density * supplied / stored
        },
        "heat capacity fitted": _stores(one.x),
        "heat capacity at 25 and 700 degC fitted": _stores(two.x),
    }
    rows, later = [], []
    for name, changes in beds.items():
        result = run(stone.scene(**changes))
        deviation = (
            score.at(stone, result, stone.points.t, stone.points.x) - stone.points.value
        )
        stored, supplied = heat_of_the_stone_bed(**changes)
        row = {
            "bed": name,
            "stored over supplied [1]": stored / supplied,
            "RMS [K]": np.sqrt(np.mean(deviation**2)),
        }
        rows.append(row | {"bias [K]": np.mean(deviation)})
        x, t = (
            stone.points.x,
            np.full(len(stone.points.x), max(stone.settings.report.times)),
        )
        found = score.at(stone, result, t, x) - ZERO_CELSIUS
        later.append(
            {
                "bed": name,
                **dict(
                    zip(
                        [f"T at {height:g} m [degC]" for height in x],
                        found,
                        strict=True,
                    )
                ),
            }
        )
    fits = []
    for name, fit in (("one", one), ("two", two)):
        error = np.sqrt(np.diag(np.linalg.inv(fit.jac.T @ fit.jac)))
        for T, value, spread in zip((COLD, HOT), fit.x, error, strict=False):
            at = "any" if name == "one" else f"{T - ZERO_CELSIUS:g}"
            fits.append(
                {
                    "at [degC]": at,
                    "heat capacity [J/kg/K]": value,
                    "standard error [J/kg/K]": spread,
                }
            )
    return {
        "stone": Table.of(rows, ".4g"),
        "stone_later": Table.of(later, ".4g"),
        "stone_fits": Table.of(fits, ".4g"),
    }


def _fit(stone: Any, start: list[float]) -> Any:
    """Least squares for the heat capacity, one or those at COLD and HOT, over the
    points' standard error.
    """

    def deviations(values: Any) -> Any:
        result = run(stone.scene(**_stores(values)))
        return (
            score.at(stone, result, stone.points.t, stone.points.x) - stone.points.value
        ) / stone.uncertainty

    return least_squares(deviations, start, x_scale=start, diff_step=STEP)


def _stores(values: Any) -> dict[str, Any]:
    """Change of a scene: one heat capacity [J/kg/K], or a straight line between
    those at COLD and HOT.
    """
    if len(values) == 1:
        return {"solids.stone.heat_capacity": float(values[0])}
    slope = (values[1] - values[0]) / (HOT - COLD)
    return {
        "solids.stone.heat_capacity": [float(values[0] - slope * COLD), float(slope)]
    }


def _standby() -> list[dict[str, Any]]:
    """Predicted temperatures of the salt at rest with losses [degC]; only the start
    was measured.
    """
    result = run(load(Path(__file__).parent / "standby" / "standby.toml"))
    x, t, T = (result.profiles[name] for name in ("x [m]", "t [s]", "T_solid [K]"))
    rows = []
    for moment in np.unique(t):
        now = t == moment
        found = np.interp(STANDBY_HEIGHTS, x[now], T[now]) - ZERO_CELSIUS
        names = [f"T at {height:g} m [degC]" for height in STANDBY_HEIGHTS]
        rows.append({"t [h]": moment / 3600.0, **dict(zip(names, found, strict=True))})
    return rows


def plot(tables: Tables) -> dict[str, Any]:
    """Measured and predicted temperatures of each bed with their uncertainty."""
    names = list(dict.fromkeys(tables["points"]["case"]))
    figure, axes = gallery.figure(1, len(names))
    for panel, name in zip(np.atleast_1d(axes), names, strict=True):
        one = case.read_case(name)
        rows = [row for row in tables["points"] if row["case"] == name]
        by_time = one.settings.each == "time"
        of, along = ("t [s]", "position [m]") if by_time else ("position [m]", "t [s]")
        groups = sorted({float(row[of]) for row in rows})
        for group, colour in zip(groups, gallery.PALETTE, strict=False):
            chosen = sorted(
                (row for row in rows if float(row[of]) == group),
                key=lambda row: float(row[along]),
            )
            x, measured, predicted, band = (
                np.array([float(row[key]) for row in chosen])
                for key in (along, "measured [K]", "predicted [K]", "band [K]")
            )
            text = f"{group:g} {'s' if by_time else 'm'}"
            spread = COVERAGE * one.uncertainty
            panel.errorbar(
                x, measured, spread, fmt="o", ms=2, lw=0.5, alpha=0.6, color=colour
            )
            panel.plot(x, predicted, color=colour, label=text)
            panel.fill_between(
                x,
                predicted - COVERAGE * band,
                predicted + COVERAGE * band,
                color=colour,
                alpha=0.2,
                lw=0,
            )
        panel.set(
            title=name,
            xlabel="position [m]" if by_time else "time [s]",
            ylabel="temperature [K]",
        )
        panel.legend()
    return {"measured_beds": figure}
