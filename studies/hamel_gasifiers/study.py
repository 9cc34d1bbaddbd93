"""Element and energy closure, gas and carbon conversion of published gasifiers, with
what is not published as bands.

Five cases unless `cases` names others of the 23 with complete inputs.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import contbed as cb
from contbed.errors import ContbedError
from contbed.loading import from_dict
from studies import _gallery as gallery
from studies._gallery import Table, Tables

HERE = Path(__file__).parent
# oxygen ratio recomputed from the flows is off the tabulated one by 12 to 24 %
OMITTED = ("VTTP10", "VTTP15", "WSV-F")
SIZES = {"VTTP": 0.15, "VTTA": 0.158, "WSV": 0.4}  # diameter of the bed [m]
BASE = {"height": 0.8, "char": 2e-3, "hold": 0.3, "loss": 10.0}
BANDS = {
    "height": (0.5, 1.2),  # of the fluidized bed [m]: stands for the inventory
    "char": (1e-3, 4e-3),  # diameter of fresh char [m]
    # share of char in the particles if none of it reacted: sets its residence time
    "hold": (0.1, 0.6),
    "loss": (0.0, 30.0),  # through the walls [W/m2/K]
}
CHOSEN = ("VTTA-A", "WSV-D", "VTTP5", "VTTP14", "VTTP1")  # every plant and fuel
BANDED = ("VTTA-A",)
DENSITY = 500.0  # of char [kg/m3]
NORMAL = 101325.0 / 8.314462618 / 273.15  # [mol/Nm3]
WANTED = ("T_emulsion_top_K", "x_CO_dry", "x_CO2_dry", "x_H2_dry", "x_CH4_dry", "x_C6H6_dry", "x_N2_dry", "x_H2O_wet",
          "carbon_conversion", "cold_gas_efficiency", "oxygen_ratio", "char_volume_fraction")  # fmt: skip
PANELS = (
    ("x_CO_dry", "CO [%, dry]", 100.0), ("x_CO2_dry", "CO2 [%, dry]", 100.0), ("x_H2_dry", "H2 [%, dry]", 100.0),
    ("x_CH4_dry", "CH4 [%, dry]", 100.0), ("carbon_conversion", "carbon conversion [%]", 100.0),
    ("T_emulsion_top_K", "gas above the bed [K]", 1.0),
)  # fmt: skip
ELEMENTS = ("C", "H", "O", "N", "S", "energy")
NOT_COMPARED = (*(f"open_{name}" for name in ELEMENTS), "cpu_s")


def reference() -> dict[str, dict[str, str]]:
    """Tabulated rows with fuel, air and steam, by name."""
    rows = {row["case"]: row for row in Table.read(HERE / "cases.csv")}
    return {
        name: row
        for name, row in rows.items()
        if row["primary_air_Nm3_h"] and name not in OMITTED
    }


def scene(
    row: dict[str, str], height: float, char: float, hold: float, loss: float
) -> dict[str, Any]:
    """The tables of a case. All air enters at the bottom: where the secondary air
    enters is not tabulated.
    """
    number = {
        name: float(value or 0.0)
        for name, value in row.items()
        if name not in ("case", "plant", "fuel", "recycle", "note")
    }
    D = next(size for plant, size in SIZES.items() if row["case"].startswith(plant))
    air = (
        (number["primary_air_Nm3_h"] + number["secondary_air_Nm3_h"]) * NORMAL / 3600.0
    )
    steam = number["steam_kg_h"] / 3600.0 / 0.018015
    moles = {"O2": 0.21 * air, "N2": 0.79 * air, "H2O": steam}
    total = sum(moles.values())
    dry = {name: number[f"{name}_dry"] for name in "CHONS"}
    whole = sum(dry.values()) + number["ash_dry"]
    section = 0.25 * 3.14159265 * D**2
    carbon = (
        number["feed_kg_h"]
        / 3600.0
        * (1.0 - number["moisture_wt"] / 100.0)
        * (1.0 - number["ash_dry"] / whole)
    )
    carbon *= 1.0 - number["VM_daf"] / 100.0
    # half of the bed are bubbles
    drain = hold * section * height * 0.55 * 0.5 * DENSITY / carbon
    flow = 0.031998 * moles["O2"] + 0.028014 * moles["N2"] + 0.018015 * moles["H2O"]
    return {
        "title": f"{row['case']}, {row['plant']}, {row['fuel']}",
        "bubbling_bed": {
            "height": height,
            "section": section,
            "solids_fraction": 0.55,
            "bubbles": {"gas_exchange": "gas_exchange_sit_grace"},
            "walls": {
                "perimeter": 3.14159265 * D,
                "coefficient": loss,
                "temperature": 300.0,
            },
            "drain": {"time": drain},
        },
        "gas": {
            "composition": ", ".join(
                f"{name}:{n / total:.9f}" for name, n in moles.items() if n > 0
            ),
            "pressure": 1e6 * number["p_MPa"],
        },
        "boundary": {"bottom": {"gas": {"mass_flow": flow, "temperature": 550.0}}},
        "solids": {
            "char": {
                "volume_share": 0.05,
                "diameter": char,
                "density": 600.0,
                "heat_capacity": 1500.0,
                "gas_coefficient": 200.0,
                "mixing_conductivity": 2e3,
                "exchange": {"sand": 5e4},
                "feed": {
                    "mass_flow": number["feed_kg_h"] / 3600.0,
                    "temperature": 300.0,
                    "height": 0.3 * height,
                    "width": 0.1 * height,
                },
                "fuel": {
                    "moisture": number["moisture_wt"] / 100.0,
                    "ash": number["ash_dry"] / whole,
                    "volatile_matter": number["VM_daf"] / 100.0,
                    "char_density": DENSITY,
                    "ultimate": {name: share / whole for name, share in dry.items()},
                },
            },
            "sand": {
                "volume_share": 0.95,
                "diameter": 4e-4,
                "density": 2600.0,
                "heat_capacity": 1000.0,
                "gas_coefficient": 400.0,
                "mixing_conductivity": 3e4,
            },
        },
        "reactions": {
            "drying": {"time": 10.0},
            "devolatilisation": {"time": 20.0},
            "char_combustion": {},
            "char_steam": {},
            "char_CO2": {},
            "char_H2": {},
            "CO_oxidation": {},
            "H2_oxidation": {},
            "CH4_oxidation": {},
            "tar_oxidation": {},
            "H2S_oxidation": {},
            "water_gas_shift": {},
        },
        "mesh": {"cells": 12},
        "solver": {"degree": 2},
        "initial": {"temperature": 1150.0},
        "output": {"plots": False, "fields": False},
    }


def run(row: dict[str, str], **changes: float) -> dict[str, Any]:
    """Named results of a case, or why there are none."""
    start = gallery.user_time()
    values = BASE | changes
    out: dict[str, Any] = {"case": row["case"], "fuel": row["fuel"], **values}
    out["lambda_tabulated"] = float(row["lambda_O2"])
    try:
        result = cb.run(from_dict(scene(row, **values)))
    except ContbedError as error:
        return out | {"status": str(error).splitlines()[0][:80]}
    out |= {"status": "ok"} | {name: result.qoi.get(name, 0.0) for name in WANTED}
    out |= {
        f"open_{name}": abs(result.balances[name]["relative_residual"])
        for name in ELEMENTS
        if name in result.balances
    }
    return out | {"cpu_s": gallery.user_time() - start}


def compute(cases: Sequence[str] = CHOSEN) -> Tables:
    """Cases as they stand, then what the missing inputs do; the committed rows of
    others are kept.
    """
    rows = reference()
    wanted: list[tuple[str, dict[str, float]]] = [(name, {}) for name in cases]
    wanted += [
        (name, {key: value})
        for name in BANDED
        for key, band in BANDS.items()
        for value in band
    ]
    found = []
    for name, changes in wanted:
        found.append(run(rows[name], **changes))
        print(name, changes, found[-1]["status"], flush=True)
    new = Table.of(found, ".6g")
    return {"results": Table.read(HERE / "results.csv").updated(new, ["case", *BASE])}


def plot(tables: Tables) -> dict[str, Any]:
    """Gas, temperature and conversion of each case; vertical lines span what the
    missing inputs do.
    """
    done = tables["results"].where({"status": "ok"})
    order = done.values("case")
    figure, panels = gallery.figure(2, 3, size=(9.0, 6.5))
    for axes, (name, label, scale) in zip(panels.ravel(), PANELS, strict=True):
        for place, case in enumerate(order):
            values = scale * done.where({"case": case})[name]
            axes.plot(
                [place, place],
                [values.min(), values.max()],
                color=gallery.SKY,
                linewidth=6,
                alpha=0.6,
            )
            axes.plot(place, values[0], "o", color=gallery.BLUE)
        axes.set(title=label, xticks=range(len(order)))
        axes.set_xticklabels(order, rotation=60, fontsize=8)
    return {"gasifiers": figure}
