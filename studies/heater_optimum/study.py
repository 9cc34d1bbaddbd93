"""The shortest heater under three constraints, over the pressure drop that is allowed."""

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
NOT_COMPARED = ("evaluations",)


def reference() -> float:
    """Temperature of the steam at its outlet that is asked for [K]."""
    return 970.0


def compute() -> Tables:
    """The optimum and the prices of its constraints for each pressure drop."""
    return {"optimum": Table.of([optimum(allowed) for allowed in ALLOWED], ".8g")}


def optimum(allowed: float) -> dict[str, Any]:
    """Row of the optimum with a pressure drop [Pa]."""
    from contbed.design.optimise import optimise

    text = DESIGN.read_text(encoding="utf-8").replace("pressure_drop_Pa <= 340", f"pressure_drop_Pa <= {allowed:g}")
    with TemporaryDirectory() as folder:
        file = Path(folder) / "design.toml"
        file.write_text(text.replace("../heater.toml", str(HERE / "heater.toml")), encoding="utf-8")
        done = optimise(file, Path(folder) / "out")
    length, velocity, diameter = done.found.evaluation.point
    steam, silica, pressure = done.found.prices
    return {
        "allowed_Pa": allowed,
        "length_m": length,
        "velocity_solid_m_s": velocity,
        "particle_diameter_m": diameter,
        "converged": int(done.found.status == "optimum"),
        "price_steam_m_K": steam,
        "price_silica_m_K": silica,
        "price_pressure_m_Pa": pressure,
        "evaluations": len(done.evaluations),
    }


def plot(tables: Tables) -> dict[str, Any]:
    """Shortest length over the pressure drop, with the slope that the price says, and the pebbles."""
    table = tables["optimum"]
    figure, (left, right) = gallery.figure(1, 2, size=(9, 3.6))
    allowed, length, price = (table[name] for name in ("allowed_Pa", "length_m", "price_pressure_m_Pa"))
    left.plot(allowed, 1e3 * length, "o", color=gallery.BLUE, label="optimum")
    for k, (at, value, slope) in enumerate(zip(allowed, 1e3 * length, 1e3 * price, strict=True)):
        ends = at + np.array([-2.0, 2.0])
        label = "slope by its price" if k == 0 else None
        left.plot(ends, value + slope * (ends - at), "-", color=gallery.VERMILION, label=label)
    left.set(xlabel="pressure drop allowed [Pa]", ylabel="shortest length [mm]")
    left.legend()
    right.plot(allowed, 1e3 * table["particle_diameter_m"], "o-", color=gallery.BLUE)
    right.set(xlabel="pressure drop allowed [Pa]", ylabel="pebbles [mm]")
    return {"optimum": figure}
