"""A shaft furnace on hydrogen: pellets with three interfaces sink through the gas,
short of heat and with enough.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import contbed as cb
from studies import _gallery as gallery
from studies._gallery import Table, Tables

HERE = Path(__file__).parent
GAS = 87.500978  # mole flux of the gas of the plant's case [mol/m2/s]
CASES = {"h2_5m": GAS, "h2_5m_gas_x2": 2.0 * GAS}
SHOWN = (
    "metallization",
    "reduction",
    "T_solid_out_K",
    "T_fluid_out_K",
    "x_H2_out",
    "p_out_Pa",
)
SWEPT = (
    "metallization",
    "reduction",
    "T_fluid_out_K",
    "x_H2_out",
    "x_CO_out",
    "pressure_drop_Pa",
)
# upwind cells of first order, extrapolated from 320, 640 and 1280 cells
UPWIND = {
    "h2_5m": (0.45105652, 0.60893857, 1198.4719, 513.93552, 0.7221938, 179808.32),
    "h2_5m_gas_x2": (0.99999892, 0.99999923, 1215.15, 815.45964, 0.76510562, 170228.28),
}
# from 640 to 1280 cells
LAST_STEP = {
    "h2_5m": (4.0e-3, 3.5e-3, 2.0, 0.37, 1.4e-3, 15.0),
    "h2_5m_gas_x2": (2e-8, 2e-8, 3e-7, 2e-6, 3e-9, 19.0),
}
# of natural_gas.toml: [K], [1], [mm]
PLANT = {"temperature": 1220.15, "H2/CO": 1.526375, "diameter": 15.0}
REDUCING = 0.489526511 + 0.320711862  # mole fraction of H2 and CO together in its gas
REST = "H2O:0.042557156, CO2:0.024, N2:0.017379642, CH4:0.105824828"
SWEEP = {
    "temperature": (1073.15, 1123.15, 1173.15, 1220.15, 1273.15),
    "H2/CO": (0.5, 1.0, 1.526375, 3.0, 6.0),
    "diameter": (8.0, 11.5, 15.0, 18.0),
}
# what plants run at and reach, as trade literature states it for Midrex and HYL shafts
RANGES = {
    "temperature": (1123.15, 1223.15),
    "H2/CO": (1.5, 1.8),
    "diameter": (6.0, 18.0),
}
REACHED = (0.92, 0.95)
COLOURS = {"h2_5m": gallery.BLUE, "h2_5m_gas_x2": gallery.VERMILION}


def reference(case: str) -> tuple[float, ...]:
    """Results by upwind cells, extrapolated."""
    return UPWIND[case]


def changed(key: str, value: float) -> cb.Scene:
    """The shaft on natural gas with another temperature of the gas [K], H2/CO or
    diameter of the pellets [mm].
    """
    changes: dict[str, Any] = {"boundary.left.gas.temperature": value}
    if key == "H2/CO":
        hydrogen = REDUCING * value / (1.0 + value)
        changes = {
            "gas.composition": f"H2:{hydrogen:.12g}, CO:{REDUCING - hydrogen:.12g}, "
            f"{REST}"
        }
    elif key == "diameter":
        changes = {"solids.pellets.diameter": 1e-3 * value}
    return cb.load(HERE / "natural_gas.toml", changes)


def sweep() -> Table:
    """Metallization and gas of the shaft on natural gas over three of its
    conditions, one at a time.
    """
    rows, plant = [], cb.run(cb.load(HERE / "natural_gas.toml"))
    for key, values in SWEEP.items():
        for value in values:
            q = (plant if value == PLANT[key] else cb.run(changed(key, value))).qoi
            rows.append([key, value, *(q[name] for name in SWEPT)])
    return Table({"varied": "", "value": ".6g", **dict.fromkeys(SWEPT, ".6g")}, rows)


def compute() -> Tables:
    """Both cases beside upwind cells, profiles, and the sweep."""
    rows, profiles = [], []
    for case, gas in CASES.items():
        run = cb.run(
            cb.load(HERE / "h2_5m.toml", {"boundary.left.gas.molar_flux": gas})
        )
        rows.append((case, "this scene", *(run.qoi[key] for key in SHOWN)))
        rows.append((case, "upwind cells, extrapolated", *reference(case)))
        rows.append((case, "last step of extrapolation", *LAST_STEP[case]))
        columns = run.profiles
        rest = (
            columns[key]
            for key in (
                "T_fluid [K]",
                "T_solid [K]",
                "x_H2 [1]",
                "w_Fe [1]",
                "w_FeO [1]",
            )
        )
        profiles += [
            (case, *values) for values in zip(columns["x [m]"], *rest, strict=True)
        ]
    headers = (
        "x [m]",
        "T_fluid [K]",
        "T_solid [K]",
        "x_H2 [1]",
        "w_Fe [1]",
        "w_FeO [1]",
    )
    return {
        "results": Table({"case": "", "what": "", **dict.fromkeys(SHOWN, ".8g")}, rows),
        "shaft": Table({"case": "", **dict.fromkeys(headers, ".6g")}, profiles),
        "sweep": sweep(),
    }


def plot(tables: Tables) -> dict[str, Any]:
    """Temperature of the pellets, hydrogen and iron over the height."""
    figure, panels = gallery.figure(1, 3, size=(11, 4))
    table = tables["shaft"]
    for case in CASES:
        here = [k for k, row in enumerate(table.rows) if row[0] == case]
        x = table["x [m]"][here]
        for axes, name in zip(
            panels, ("T_solid [K]", "x_H2 [1]", "w_Fe [1]"), strict=True
        ):
            axes.plot(table[name][here], x, color=COLOURS[case], label=case)
            axes.set(xlabel=name, ylabel="height [m]")
    panels[0].legend(fontsize=8)
    return {"profiles": figure, "sweep": _sweep_figure(tables["sweep"])}


def _sweep_figure(table: Table) -> Any:
    """Metallization over each condition; lines of what plants reach and run at."""
    figure, panels = gallery.figure(1, 3, size=(11, 3.6))
    names = {
        "temperature": "temperature of the gas [K]",
        "H2/CO": "H$_2$/CO",
        "diameter": "diameter of the pellets [mm]",
    }
    for axes, (key, label) in zip(panels, names.items(), strict=True):
        here = table["varied"] == key
        axes.axvspan(*RANGES[key], color=gallery.GREY, alpha=0.2, linewidth=0)
        axes.axhspan(*REACHED, color=gallery.GREEN, alpha=0.2, linewidth=0)
        axes.plot(
            table["value"][here],
            table["metallization"][here],
            "o-",
            color=gallery.VERMILION,
        )
        axes.axvline(PLANT[key], color=gallery.GREY, linewidth=0.8)
        axes.set(xlabel=label, ylabel="metallization", ylim=(0.4, 1.0))
    return figure
