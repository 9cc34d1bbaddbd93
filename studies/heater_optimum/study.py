"""The shortest heater under three constraints, over the pressure drop that is
allowed, and what it leaves open.
"""

from __future__ import annotations

from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from studies import _gallery as gallery
from studies._gallery import Table, Tables

HERE = Path(__file__).parent
DESIGN = HERE / "design" / "shortest.toml"
ALLOWED = (330.0, 335.0, 340.0, 345.0, 350.0, 360.0)  # pressure drops [Pa]
INDICES = HERE / "sweeps" / "indices.toml"
KEPT = ("result", "parameter", "first order", "first order +-", "total", "total +-")
NOT_COMPARED = ("evaluations",)


def reference() -> float:
    """Temperature of the steam at its outlet that is asked for [K]."""
    return 970.0


def compute() -> Tables:
    """The optimum and the prices of its constraints for each pressure drop; Sobol
    indices of that with 340 Pa.
    """
    return {
        "optimum": Table.of([optimum(allowed) for allowed in ALLOWED], ".8g"),
        "indices": indices(),
    }


def indices() -> Table:
    """Share of the variance of each result that each uncertain key of the shortest
    heater causes.
    """
    from contbed.many.sweep.sweep import sweep
    from contbed.many.uncertainty.write import write

    with TemporaryDirectory() as folder:
        done = sweep(INDICES, folder, quiet=False)
        write(done.study, done.rows, Path(folder))
        found = Table.read(Path(folder) / "indices.csv")
    rows = [dict(zip(found.columns, row, strict=True)) for row in found.rows]
    return Table.of([{name: row[name] for name in KEPT} for row in rows])


def optimum(allowed: float) -> dict[str, Any]:
    """Row of the optimum with a pressure drop [Pa]."""
    from contbed.many.optimise.optimise import optimise

    text = DESIGN.read_text(encoding="utf-8").replace(
        "pressure_drop_Pa <= 340", f"pressure_drop_Pa <= {allowed:g}"
    )
    with TemporaryDirectory() as folder:
        file = Path(folder) / "design.toml"
        file.write_text(
            text.replace("../heater.toml", str(HERE / "heater.toml")), encoding="utf-8"
        )
        done = optimise(file, Path(folder) / "out")
    length, velocity, diameter = done.found.evaluation.point
    steam, silica, pressure = done.found.prices
    return {
        "allowed_Pa": allowed,
        "length_m": length,
        "velocity_solid_m_s": -velocity,
        "particle_diameter_m": diameter,
        "converged": int(done.found.status == "optimum"),
        "price_steam_m_K": steam,
        "price_silica_m_K": silica,
        "price_pressure_m_Pa": pressure,
        "evaluations": len(done.evaluations),
    }


def plot(tables: Tables) -> dict[str, Any]:
    """Shortest length over the pressure drop, with the slope that the price says,
    and the pebbles.
    """
    table = tables["optimum"]
    figure, (left, right) = gallery.figure(1, 2, size=(9, 3.6))
    allowed, length, price = (
        table[name] for name in ("allowed_Pa", "length_m", "price_pressure_m_Pa")
    )
    left.plot(allowed, 1e3 * length, "o", color=gallery.BLUE, label="optimum")
    for k, (at, value, slope) in enumerate(
        zip(allowed, 1e3 * length, 1e3 * price, strict=True)
    ):
        ends = at + np.array([-2.0, 2.0])
        label = "slope by its price" if k == 0 else None
        left.plot(
            ends, value + slope * (ends - at), "-", color=gallery.VERMILION, label=label
        )
    left.set(xlabel="pressure drop allowed [Pa]", ylabel="shortest length [mm]")
    left.legend()
    right.plot(allowed, 1e3 * table["particle_diameter_m"], "o-", color=gallery.BLUE)
    right.set(xlabel="pressure drop allowed [Pa]", ylabel="pebbles [mm]")
    return {"optimum": figure, "indices": plot_indices(tables["indices"])}


def plot_indices(table: Table) -> Any:
    """Total index of each key, for each result, with its half width at 90 %."""
    results, keys = (
        list(dict.fromkeys(table.values(name))) for name in ("result", "parameter")
    )
    figure, panels = gallery.figure(1, len(results), size=(9, 2.8), sharey=True)
    total, half = (
        np.array(table[name]).reshape(len(results), len(keys))
        for name in ("total", "total +-")
    )
    for k, (panel, name) in enumerate(zip(panels, results, strict=True)):
        panel.barh(
            range(len(keys)),
            total[k],
            xerr=half[k],
            color=gallery.BLUE,
            error_kw={"lw": 1.0},
        )
        panel.set(xlabel="total index", title=name)
    panels[0].set_yticks(range(len(keys)), keys)
    panels[0].invert_yaxis()
    return figure
