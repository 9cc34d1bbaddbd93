"""Steam reforming in a tube by the rates of Xu and Froment: a wall by coefficient and by flux, and an adiabatic bed."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any

import contbed as cb
from studies import _gallery as gallery
from studies._gallery import Table, Tables

HERE = Path(__file__).parent
CASES = ("tube_U300", "tube_flux70", "adiabatic")
SHOWN = ("conversion_CH4", "T_fluid_out_K", "p_out_Pa", "x_CH4_dry", "Q_over_K_reforming")
COLOURS = {"tube_U300": gallery.BLUE, "tube_flux70": gallery.VERMILION, "adiabatic": gallery.GREEN}
OWN_K = {"reactions.reforming.equilibrium_factor": 1.0, "reactions.total.equilibrium_factor": 1.0}


def reference(case: str) -> dict[str, float]:
    """Numbers of the reference, two integrators that agree to 9e-11."""
    with (HERE / "reference.csv").open(encoding="utf-8") as file:
        return next(
            {k: float(v) for k, v in row.items() if k != "case"} for row in csv.DictReader(file) if row["case"] == case
        )


def compute() -> Tables:
    """Each case beside its reference, and with the equilibrium of the thermodynamics in use."""
    rows, profiles = [], []
    for case in CASES:
        run, exact = cb.run(cb.load(HERE / f"{case}.toml")), reference(case)
        own = cb.run(cb.load(HERE / f"{case}.toml", OWN_K))
        rows.append((case, "this scene", *(run.qoi[key] for key in SHOWN)))
        rows.append((case, "reference", *(exact[key] for key in SHOWN)))
        rows.append((case, "K of gri30", *(own.qoi[key] for key in SHOWN)))
        columns = run.profiles
        rest = (columns["T_fluid [K]"], columns["x_CH4 [1]"], columns["x_H2 [1]"], columns["p_gas [Pa]"])
        profiles += [(case, *values) for values in zip(columns["x [m]"], *rest, strict=True)]
    headers = dict.fromkeys(("x [m]", "T [K]", "x_CH4 [1]", "x_H2 [1]", "p [Pa]"), ".8g")
    return {
        "results": Table({"case": "", "what": "", **dict.fromkeys(SHOWN, ".10g")}, rows),
        "tubes": Table({"case": "", **headers}, profiles),
    }


def plot(tables: Tables) -> dict[str, Any]:
    """Temperature and methane along the beds."""
    figure, (left, right) = gallery.figure(1, 2, size=(9, 4))
    table = tables["tubes"]
    for case in CASES:
        here = [k for k, row in enumerate(table.rows) if row[0] == case]
        x, T, methane = (table[name][here] for name in ("x [m]", "T [K]", "x_CH4 [1]"))
        left.plot(x, T, color=COLOURS[case], label=case)
        right.plot(x, methane, color=COLOURS[case], label=case)
    left.set(xlabel="x [m]", ylabel="T [K]")
    right.set(xlabel="x [m]", ylabel="CH$_4$, mole fraction")
    left.legend(fontsize=8)
    return {"profiles": figure}
