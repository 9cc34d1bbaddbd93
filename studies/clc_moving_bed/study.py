"""A moving-bed fuel reactor of chemical looping beside shooting, and beside the
equations of an open flowsheet code.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import contbed as cb
from studies import _gallery as gallery
from studies._gallery import Table, Tables
from studies.clc_moving_bed.shooting import AS_CODED, Bed

HERE = Path(__file__).parent
RESULTS = ("conversion_CH4", "conversion_Fe2O3", "pressure_drop_Pa", "T_solid_out_K")
# from the flowsheet code to the scene, one change after another
STEPS: tuple[tuple[str, dict[str, Any]], ...] = (
    ("as coded in the flowsheet", {}),
    ("Nu = 2 + 1.1 Re^0.6 Pr^(1/3)", {"nusselt_cubed": False}),
    ("conductivity of the mixture without a root", {"root_in_conductivity": False}),
    ("Ergun on u + u_s", {"linear_pressure": False, "slip": "sum"}),
    ("Ergun and Re on u + u_s eps/(1 - eps)", {"slip": "interstitial"}),
    ("indices of the conductivity of the mixture", {"transposed_conductivity": False}),
    ("products bring their enthalpy", {"products_without_enthalpy": False}),
)
HEADERS = dict.fromkeys(RESULTS, ".10g")


def reference(scene: Any) -> dict[str, float]:
    """Results of a scene by shooting."""
    return Bed.of(scene).solve()


def compute() -> Tables:
    """The scene beside its reference, and the steps from the flowsheet code to it."""
    scene = cb.load(HERE / "iron_oxide.toml")
    run, exact = cb.run(scene), reference(scene)
    rows: list[tuple[Any, ...]] = [
        ("this scene", *(run.qoi[key] for key in RESULTS)),
        ("shooting", *(exact[key] for key in RESULTS)),
    ]
    bed, switches = Bed.of(scene), dict(AS_CODED)
    steps = []
    for name, change in STEPS:
        switches |= change
        found = bed.changed(**switches).solve()
        steps.append((name, *(found[key] for key in RESULTS)))
    x, columns = run.profiles["x [m]"], run.profiles
    shown = ("T_fluid [K]", "T_solid [K]", "x_CH4 [1]", "x_CO2 [1]", "w_Fe2O3 [1]")
    profile = [
        tuple(values)
        for values in zip(x, *(columns[key] for key in shown), strict=True)
    ]
    return {
        "results": Table({"what": "", **HEADERS}, rows),
        "steps": Table({"what": "", **HEADERS}, steps),
        "bed": Table({"x [m]": ".6g", **dict.fromkeys(shown, ".8g")}, profile),
    }


def plot(tables: Tables) -> dict[str, Any]:
    """Temperatures in the lowest half metre and conversions along the bed."""
    figure, (left, right) = gallery.figure(1, 2, size=(9, 4))
    bed = tables["bed"]
    x = bed["x [m]"]
    left.plot(x, bed["T_fluid [K]"], "--", color=gallery.BLUE, label="gas")
    left.plot(x, bed["T_solid [K]"], color=gallery.VERMILION, label="solids")
    left.set(xlabel="x [m]", ylabel="T [K]", xlim=(0.0, 1.0), ylim=(1140.0, 1185.0))
    left.legend()
    right.plot(
        x,
        bed["x_CH4 [1]"],
        color=gallery.BLUE,
        label="CH$_4$, mole fraction of the gas",
    )
    right.plot(
        x,
        bed["x_CO2 [1]"],
        color=gallery.GREEN,
        label="CO$_2$, mole fraction of the gas",
    )
    right.plot(
        x,
        bed["w_Fe2O3 [1]"],
        color=gallery.VERMILION,
        label="Fe$_2$O$_3$, mass fraction of the solids",
    )
    right.set(xlabel="x [m]")
    right.legend(fontsize=8)
    return {"profiles": figure}
