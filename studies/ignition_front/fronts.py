"""Fronts of reaction and of heat through an oxygen carrier: cells that follow them
beside cells of one length.

With tau = b k t/N and xi = k x/F, both exact (bilinear rate, Bohart and Adams 1920,
doi:10.1021/ja01448a018):

    S/N = e^xi/(e^xi + e^tau - 1),    x_A = e^tau/(e^xi + e^tau - 1)

Heat moves with w = G c_p/C, so that T - T_0 is the integral of (-dH) k x_A S/(N C) over
the time along x - w t.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

import contbed as cb
from studies import _gallery as gallery
from studies._gallery import Table, Tables

HERE = Path(__file__).parent
NOT_COMPARED = ("CPU [s]", "steps", "energy")
# of `oxygen_carrier.toml` [mol/m2/s], [1], [mol/m3], [mol/m3/s]
F, B, N, K = 5.0, 4.0, 8000.0, 500.0
# [J/mol], [J/m3/K], speed of heat [m/s]
HEAT, C, W = 480e3, 250.0 * N, 5.0 * 110.0 / (250.0 * N)
T0 = 300.0  # [K]
UNIFORM = (60, 120, 240, 480)
DIGITS = (3, 4, 5)  # of solver.tolerance
X = np.linspace(0.0, 1.0, 2001)  # positions that are compared
# times of the integral, and the first after its start [s]
SAMPLES, EARLIEST = 4000, 1e-6
# of the profiles, at every other position
SHOWN = ("60 cells", "cells that follow, 1e-4")


def _whole(x: Any, t: Any) -> Any:
    """log(e^xi + e^tau - 1), which overflows as it stands."""
    return np.logaddexp(K * x / F, np.log(np.expm1(np.maximum(B * K * t / N, 1e-300))))


def reference(t: float, x: Any = X) -> tuple[Any, Any]:
    """Temperature [K] and share of S that is left at positions [m]."""
    T = []
    for z in x:
        start = max(0.0, t - z / W)  # when what is at z now entered, or the run began
        more = np.geomspace(EARLIEST, max(t - start, 2.0 * EARLIEST), SAMPLES)
        times = np.unique(
            np.concatenate(
                [np.linspace(start, t, SAMPLES), np.minimum(start + more, t)]
            )
        )
        places = np.maximum(z - W * (t - times), 0.0)
        rate = K * np.exp(
            B * K * times / N + K * places / F - 2.0 * _whole(places, times)
        )
        T.append(T0 + HEAT / C * np.trapezoid(rate, times))
    return np.array(T), np.exp(K * x / F - _whole(x, t))


def cases() -> dict[str, dict[str, Any]]:
    """Changes of the scene by name."""
    found: dict[str, dict[str, Any]] = {
        f"{n} cells": {"mesh.cells": n, "solver.adapt": 0} for n in UNIFORM
    }
    return found | {
        f"cells that follow, 1e-{n}": {"solver.tolerance": 10.0**-n} for n in DIGITS
    }


def compute() -> Tables:
    """Errors of temperatures and solids, steps and CPU."""
    rows, curves = [], {"x [m]": X[::2]}
    for name, changes in cases().items():
        scene = cb.load(
            HERE / "oxygen_carrier.toml", changes | {"output.positions": X.tolist()}
        )
        if not rows:
            T, left = reference(scene.time.end)
            curves["exact"] = T[::2]
        seconds, result = gallery.cpu(lambda scene=scene: cb.run(scene))
        found, qoi = result.profiles["T_fluid [K]"], result.qoi
        rows.append(
            [name, qoi.get("cells_most", qoi["cells"]), qoi.get("cells_changes", 0), max(found.max() - T.max(), 0.0),
             max(T0 - found.min(), 0.0), np.abs(found - T).mean(), np.abs(result.profiles["w_S [1]"] - left).max(),
             qoi.get("cells_error"), abs(result.balances["energy"]["relative_residual"]), qoi["time_steps"], seconds]
        )  # fmt: skip
        if name in SHOWN:
            curves[name] = found[::2]
    form = {
        "case": "",
        "cells": "d",
        "changes": "d",
        "over [K]": ".2f",
        "under [K]": ".2f",
        "mean error [K]": ".3f",
    }
    form |= {
        "error of S": ".1e",
        "cells_error": ".1e",
        "energy": ".0e",
        "steps": "d",
        "CPU [s]": ".1f",
    }
    return {
        "fronts": Table(form, rows),
        "fronts_profiles": Table.from_columns(curves, ".5g"),
    }


def plot(tables: Tables) -> dict[str, Any]:
    """Temperatures of cells of one length, of cells that follow and of the closed
    form; the top of both fronts.
    """
    figure, (whole, top) = gallery.figure(1, 2)
    table = tables["fronts_profiles"]
    for axes in (whole, top):
        for name, colour in zip(
            ("exact", *SHOWN),
            (gallery.BLACK, gallery.VERMILION, gallery.BLUE),
            strict=True,
        ):
            style = "--" if name == SHOWN[1] else "-"
            axes.plot(
                table["x [m]"], table[name], style, color=colour, label=name, lw=1.2
            )
        axes.set(xlabel="x [m]", ylabel="temperature [K]")
    whole.legend()
    top.set(xlim=(0.05, 0.2), ylim=(780.0, 900.0))
    return {"fronts": figure}
