"""A shaft furnace on hydrogen: pellets with three interfaces sink through the gas, short of heat and with enough."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import contbed as cb
from studies import _gallery as gallery
from studies._gallery import Table, Tables

HERE = Path(__file__).parent
GAS = 87.500978  # mole flux of the gas of the plant's case [mol/m2/s]
CASES = {"h2_5m": GAS, "h2_5m_gas_x2": 2.0 * GAS}
SHOWN = ("metallization", "reduction", "T_solid_out_K", "T_fluid_out_K", "x_H2_out", "p_out_Pa")
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
COLOURS = {"h2_5m": gallery.BLUE, "h2_5m_gas_x2": gallery.VERMILION}


def reference(case: str) -> tuple[float, ...]:
    """Results by upwind cells, extrapolated."""
    return UPWIND[case]


def compute() -> Tables:
    """Both cases beside upwind cells, and profiles."""
    rows, profiles = [], []
    for case, gas in CASES.items():
        run = cb.run(cb.load(HERE / "h2_5m.toml", {"flow.molar_flux": gas}))
        rows.append((case, "this scene", *(run.qoi[key] for key in SHOWN)))
        rows.append((case, "upwind cells, extrapolated", *reference(case)))
        rows.append((case, "last step of extrapolation", *LAST_STEP[case]))
        columns = run.profiles
        rest = (columns[key] for key in ("T_fluid [K]", "T_solid [K]", "x_H2 [1]", "w_Fe [1]", "w_FeO [1]"))
        profiles += [(case, *values) for values in zip(columns["x [m]"], *rest, strict=True)]
    headers = ("x [m]", "T_fluid [K]", "T_solid [K]", "x_H2 [1]", "w_Fe [1]", "w_FeO [1]")
    return {
        "results": Table({"case": "", "what": "", **dict.fromkeys(SHOWN, ".8g")}, rows),
        "shaft": Table({"case": "", **dict.fromkeys(headers, ".6g")}, profiles),
    }


def plot(tables: Tables) -> dict[str, Any]:
    """Temperature of the pellets, hydrogen and iron over the height."""
    figure, panels = gallery.figure(1, 3, size=(11, 4))
    table = tables["shaft"]
    for case in CASES:
        here = [k for k, row in enumerate(table.rows) if row[0] == case]
        x = table["x [m]"][here]
        for axes, name in zip(panels, ("T_solid [K]", "x_H2 [1]", "w_Fe [1]"), strict=True):
            axes.plot(table[name][here], x, color=COLOURS[case], label=case)
            axes.set(xlabel=name, ylabel="height [m]")
    panels[0].legend(fontsize=8)
    return {"profiles": figure}
