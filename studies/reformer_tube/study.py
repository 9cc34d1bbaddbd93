"""Steam reforming in a tube by the rates of Xu and Froment: a wall by coefficient
and by flux, and an adiabatic bed.
"""

from __future__ import annotations

import csv
from pathlib import Path
from typing import Any

import numpy as np

import contbed as cb
from studies import _gallery as gallery
from studies._gallery import Table, Tables

HERE = Path(__file__).parent
CASES = ("tube_U300", "tube_flux70", "adiabatic")
SHOWN = (
    "conversion_CH4",
    "T_fluid_out_K",
    "p_out_Pa",
    "x_CH4_dry",
    "Q_over_K_reforming",
)
SECTION = (
    "x [m]",
    "T_fluid [K]",
    "T_fluid_axis [K]",
    "T_fluid_wall [K]",
    "x_CH4 [1]",
    "conversion_CH4",
    "dT_section_max_K",
)
COLOURS = {
    "tube_U300": gallery.BLUE,
    "tube_flux70": gallery.VERMILION,
    "adiabatic": gallery.GREEN,
}
OWN_K = {
    "reactions.reforming.equilibrium_factor": 1.0,
    "reactions.total.equilibrium_factor": 1.0,
}
# effective diffusivities [m2/s]: those in steam at 900 K and 25.7 bar, 7e-6 of CH4,
# times porosity over tortuosity, 1/6
DIFFUSIVITY = {"CH4": 1.1e-6, "H2O": 1.2e-6, "H2": 3.5e-6, "CO": 1.1e-6, "CO2": 0.8e-6}
RATES = ("reforming", "shift", "total")
OWN_RATES = {f"reactions.{name}.factor": 1.0 for name in RATES}
FIXED, RESOLVED = "effectiveness fixed", "pellets resolved"
INSIDE = {
    RESOLVED: OWN_RATES
    | {"solids.catalyst.inside": {"mass": "interior", "diffusivity": DIFFUSIVITY}},
    "effectiveness by Thiele": OWN_RATES
    | {"solids.catalyst.inside.mass": "effectiveness"}
    | {f"reactions.{name}.diffusivity": DIFFUSIVITY["CH4"] for name in RATES},
}
ACROSS = {
    "packed_bed.section.dispersion": "vdi",
    "packed_bed.section.dispersion_mass": {
        "name": "mass_dispersion_peclet",
        "Pe_p": 10.0,
    },
    # twice as many change conversions by 5e-8, differences across the tube by 0.13 K
    "mesh.cells": 20,
}
RINGS = ((4, FIXED), (8, FIXED), (8, RESOLVED))


def reference(case: str) -> dict[str, float]:
    """Numbers of the reference, two integrators that agree to 9e-11."""
    with (HERE / "reference.csv").open(encoding="utf-8") as file:
        return next(
            {k: float(v) for k, v in row.items() if k != "case"}
            for row in csv.DictReader(file)
            if row["case"] == case
        )


def compute() -> Tables:
    """Each case beside its reference, with the equilibrium of the thermodynamics in
    use, and with pellets.
    """
    rows, profiles, pellets, section = [], [], [], []
    for case in CASES:
        run, exact = cb.run(cb.load(HERE / f"{case}.toml")), reference(case)
        own = cb.run(cb.load(HERE / f"{case}.toml", OWN_K))
        rows.append((case, "this scene", *(run.qoi[key] for key in SHOWN)))
        rows.append((case, "reference", *(exact[key] for key in SHOWN)))
        rows.append((case, "K of gri30", *(own.qoi[key] for key in SHOWN)))
        for what, changes in INSIDE.items():
            inside = cb.run(cb.load(HERE / f"{case}.toml", changes))
            rows.append((case, what, *(inside.qoi[key] for key in SHOWN)))
            pellets += [(case, what, x, T) for x, T in _thinned(inside.profiles)]
        if "tube" in case:
            section += _across(case)
        columns = run.profiles
        rest = (
            columns["T_fluid [K]"],
            columns["x_CH4 [1]"],
            columns["x_H2 [1]"],
            columns["p_gas [Pa]"],
        )
        profiles += [
            (case, *values) for values in zip(columns["x [m]"], *rest, strict=True)
        ]
    headers = dict.fromkeys(
        ("x [m]", "T [K]", "x_CH4 [1]", "x_H2 [1]", "p [Pa]"), ".8g"
    )
    return {
        "results": Table(
            {"case": "", "what": "", **dict.fromkeys(SHOWN, ".10g")}, rows
        ),
        "tubes": Table({"case": "", **headers}, profiles),
        "pellets": Table(
            {"case": "", "inside": "", "x [m]": ".6g", "x_CH4 [1]": ".6g"}, pellets
        ),
        "section": Table(
            {"case": "", "rings": "", "inside": "", **dict.fromkeys(SECTION, ".6g")},
            section,
        ),
    }


def _across(case: str) -> list[tuple[Any, ...]]:
    """Return the tube resolved across the flow: mean, axis and wall along it, by
    rings and inside of pellets.
    """
    rows = []
    for rings, inside in RINGS:
        changes = ACROSS | {"packed_bed.section.rings": rings} | INSIDE.get(inside, {})
        run = cb.run(cb.load(HERE / f"{case}.toml", changes))
        x = np.linspace(0.0, run.profiles["x [m]"][-1], 61)
        found = [
            np.interp(x, run.profiles["x [m]"], run.profiles[name])
            for name in (*SECTION[1:4], "x_CH4 [1]")
        ]
        out = run.qoi["conversion_CH4"], run.qoi["dT_section_max_K"]
        rows += [
            (case, rings, inside, *values, *out)
            for values in zip(x, *found, strict=True)
        ]
    return rows


def _thinned(columns: Any) -> Any:
    """Positions and mole fractions of methane, at 40 positions."""
    x, methane = columns["x [m]"], columns["x_CH4 [1]"]
    at = np.linspace(0.0, x[-1], 41)
    return zip(at, np.interp(at, x, methane), strict=True)


def plot(tables: Tables) -> dict[str, Any]:
    """Temperature and methane along the beds."""
    figure, (left, right) = gallery.figure(1, 2, size=(9, 4))
    table = tables["tubes"]
    for case in CASES:
        here = [k for k, row in enumerate(table.rows) if row[0] == case]
        x, T, methane = (table[name][here] for name in ("x [m]", "T [K]", "x_CH4 [1]"))
        left.plot(x, T, color=COLOURS[case], label=case)
        right.plot(x, methane, color=COLOURS[case], label=case)
    pellets = tables["pellets"]
    for case in CASES:
        for what, style in zip(INSIDE, ("--", ":"), strict=True):
            here = (pellets["case"] == case) & (pellets["inside"] == what)
            label = what if case == CASES[0] else None
            right.plot(
                pellets["x [m]"][here],
                pellets["x_CH4 [1]"][here],
                style,
                color=COLOURS[case],
                label=label,
            )
    right.legend(fontsize=8)
    section = tables["section"]
    for case in CASES[:2]:
        here = (
            (section["case"] == case)
            & (section["rings"] == 8)
            & (section["inside"] == FIXED)
        )
        for name, style in (
            ("T_fluid [K]", "--"),
            ("T_fluid_axis [K]", ":"),
            ("T_fluid_wall [K]", "-."),
        ):
            label = (
                {"--": "2-D mean", ":": "2-D axis", "-.": "2-D wall"}[style]
                if case == CASES[0]
                else None
            )
            left.plot(
                section["x [m]"][here],
                section[name][here],
                style,
                color=COLOURS[case],
                label=label,
                lw=1.0,
            )
    left.set(xlabel="x [m]", ylabel="T [K]")
    right.set(xlabel="x [m]", ylabel="CH$_4$, mole fraction")
    left.legend(fontsize=8)
    return {"profiles": figure}
