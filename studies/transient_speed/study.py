"""Transient packed bed: error against CPU beside the method of lines with LSODA from
scipy.
"""

from __future__ import annotations

from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from scipy.integrate import odeint

import contbed as cb
from studies import _gallery as gallery
from studies._gallery import Table, Tables

HERE = Path(__file__).parent
NOT_COMPARED = ("CPU [s]", "steps")
TOLERANCES = (3e-3, 1e-3, 3e-4, 1e-4, 3e-5, 1e-5)
# cells and tolerance
LINES = ((60, 3e-3), (80, 1e-3), (120, 3e-4), (160, 1e-4), (240, 3e-5), (400, 1e-5))
POSITIONS = np.linspace(0.0, 1.0, 101)[1:-1]
REPEATS = 7


def compute() -> Tables:
    """Largest error of theta of the fluid at the output times, and CPU, of both
    programs in turn.
    """
    exact, rows = reference(), []
    for k, tolerance in enumerate(TOLERANCES):
        scene = _scene(tolerance)
        cells, accuracy = LINES[k]
        both = {
            "contbed": partial(cb.run, scene),
            "LSODA": partial(lines, cells, accuracy),
        }
        ours, theirs = gallery.in_turn(both, REPEATS).values()
        result = ours.result
        found = result.profiles["T_fluid [K]"].reshape(len(exact), -1)
        rows += [
            (
                "contbed",
                tolerance,
                result.plan.mesh.skfem.nelements,
                _error(found, exact),
                ours.seconds,
            ),
            ("LSODA", accuracy, cells, _error(theirs.result, exact), theirs.seconds),
        ]
    columns = {
        "program": "",
        "tolerance [1]": ".1e",
        "cells": "d",
        "error [1]": ".3e",
        "CPU [s]": ".4f",
    }
    return {"results": Table(columns, rows)}


def _scene(tolerance: float, **more: Any) -> Any:
    settings = {
        "time.tolerance": tolerance,
        "output.positions": POSITIONS.tolist(),
        "output.fields": False,
        **more,
    }
    return cb.load(HERE / "bed.toml", settings)


def _error(found: Any, exact: Any) -> float:
    return float(np.abs(found - exact).max()) / 300.0


def reference() -> Any:
    """Fluid temperatures [K] at the output times (rows) and POSITIONS, on 2000 cells
    with a tolerance of 1e-6.
    """
    result = cb.run(_scene(1e-6, **{"mesh.cells": 2000}))
    return result.profiles["T_fluid [K]"].reshape(-1, len(POSITIONS))


def lines(cells: int, tolerance: float) -> Any:
    """The same bed by central finite volumes and LSODA with a banded Jacobian;
    temperatures as `reference` has them.
    """
    scene: Any = _scene(1e-4)
    fluid, solid, eps, d = (
        scene.gas,
        scene.solid,
        scene.packed_bed.porosity,
        scene.diameter,
    )
    u, dx = scene.boundary["left"].gas.velocity, scene.mesh.length / cells
    reynolds = fluid.density * u * d / fluid.viscosity
    prandtl = fluid.viscosity * fluid.heat_capacity / fluid.conductivity
    exchange = (
        (2.0 + 1.1 * reynolds**0.6 * prandtl ** (1 / 3))
        * fluid.conductivity
        / d
        * 6.0
        * (1.0 - eps)
        / d
    )
    flux = fluid.density * fluid.heat_capacity * u
    content = np.array(
        [
            eps * fluid.density * fluid.heat_capacity,
            (1.0 - eps) * solid.density * solid.heat_capacity,
        ]
    )
    k = np.array([eps * fluid.conductivity, (1.0 - eps) * solid.conductivity])

    def rates(y: Any, t: float) -> Any:
        T = y.reshape(-1, 2)
        through = np.zeros((cells + 1, 2))
        through[1:-1] = -k * np.diff(T, axis=0) / dx
        through[1:-1, 0] += 0.5 * flux * (T[1:, 0] + T[:-1, 0])
        through[0, 0], through[-1, 0] = flux * 600.0, flux * T[-1, 0]
        out = -np.diff(through, axis=0) / dx
        gain = exchange * (T[:, 1] - T[:, 0])
        out[:, 0] += gain
        out[:, 1] -= gain
        return (out / content).ravel()

    times = [0.0, *scene.time.times, scene.time.end]
    found = odeint(
        rates,
        np.full(2 * cells, 300.0),
        times,
        rtol=tolerance,
        atol=300.0 * tolerance,
        ml=2,
        mu=2,
        mxstep=100_000,
    )
    centres = (np.arange(cells) + 0.5) * dx
    return np.array([np.interp(POSITIONS, centres, row[::2]) for row in found[1:]])


def plot(tables: Tables) -> dict[str, Any]:
    """Error over CPU of both."""
    figure, axes = gallery.figure()
    for name, colour in (("contbed", gallery.BLUE), ("LSODA", gallery.VERMILION)):
        rows = [row for row in tables["results"] if row["program"] == name]
        cpu, error = (
            [float(row[key]) for row in rows] for key in ("CPU [s]", "error [1]")
        )
        axes.loglog(cpu, error, "o-", color=colour, label=name)
    axes.set(xlabel="CPU [s]", ylabel="largest error of theta")
    axes.legend()
    return {"results": figure}
