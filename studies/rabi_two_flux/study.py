"""Char, limestone and inert in a hot bed: eq. 34 of Rabi and de Souza-Santos beside
the full two-flux and P1.
"""

from __future__ import annotations

import tomllib
from types import SimpleNamespace
from typing import Any

import numpy as np

from studies import _gallery as gallery
from studies._gallery import Table, Tables
from studies.rabi_two_flux.bed import (
    GASES,
    HERE,
    NAMES,
    SOLIDS,
    Bed,
    open_balance,
    solved,
)

LEVELS = {
    "closure": ("eq. 34", ":", gallery.PURPLE),
    "two_flux": ("two-flux", "--", gallery.ORANGE),
    "p1": ("P1", "-", gallery.BLACK),
}
COLOURS = dict(
    zip(SOLIDS, (gallery.VERMILION, gallery.GREEN, gallery.BLUE), strict=True)
)
# factor on the dispersion of the solids -> line width
MIXING = {1.0: 1.8, 0.1: 1.4, 0.01: 1.0, 0.001: 0.7}
PLACES = {"bottom": 0.0, "10 mm": 0.01, "middle": 0.3, "top": 0.6}  # height [m]


def reference() -> dict[str, Any]:
    """P1 by collocation: temperatures [K] and heat by radiation [W]."""
    values: dict[str, Any] = tomllib.loads(
        (HERE / "data" / "bed.toml").read_text(encoding="ascii")
    )["reference"]["p1"]
    return values


def compute() -> Tables:
    """Profiles at every level, totals, and what less mixing does to the difference
    of eq. 34 and P1.
    """
    beds = {level: Bed(level) for level in LEVELS}
    found = {level: bed.results(bed.solve()) for level, bed in beds.items()}
    for level, one in found.items():
        print(f"{level:9} open balance of radiation {open_balance(level, one):.1e}")
    columns = {"z [m]": found["p1"].z}
    for level, one in found.items():
        columns |= {
            f"{name} by {level} [K]": getattr(one, name) for name in (*SOLIDS, *GASES)
        }
        columns[f"q by {level} [W/m2]"] = beds[level].flux(one)
    near = found["p1"].z < 6.5e-3
    fluxes = {name: values[near] for name, values in columns.items() if name[0] in "zq"}
    return {
        "bed": Table.from_columns(
            {name: values[::12] for name, values in columns.items()}, ".8g"
        ),
        "bed_totals": totals(found),
        "fluxes": Table.from_columns(fluxes, ".5g"),
        "mixing": mixing(),
        "causes": causes(),
    }


def totals(found: dict[str, SimpleNamespace]) -> Table:
    """Temperatures [K] and heat flows [kW] of each level."""
    rows: list[list[Any]] = []

    def row(name: str, value: Any) -> None:
        rows.append([name, *(value(found[level]) for level in LEVELS)])

    row("distributor [K]", lambda one: one.T_d)
    for place, at in PLACES.items():
        for name in NAMES:
            row(
                f"{name} at {place} [K]",
                lambda one, n=name, at=at: np.interp(at, one.z, getattr(one, f"T_{n}")),
            )
    row("emulsion gas at top [K]", lambda one: one.T_emulsion[-1])
    row("bubble gas at top [K]", lambda one: one.T_bubble[-1])
    for name in ("tubes", "wall", "distributor", "top"):
        row(f"radiation to {name} [kW]", lambda one, n=name: one.heat.get(n, 0.0) / 1e3)
    return Table(
        {
            "quantity": "",
            **dict.fromkeys((name for name, *_ in LEVELS.values()), ".2f"),
        },
        rows,
    )


def pair(**options: Any) -> tuple[SimpleNamespace, SimpleNamespace]:
    """Eq. 34 and P1 of the same bed."""
    return solved("closure", **options), solved("p1", **options)


def mixing() -> Table:
    """Inert by eq. 34 minus P1 [K] over the height, by the factor on the dispersion."""
    columns: dict[str, Any] = {}
    for factor in MIXING:
        paper, full = pair(mixing=factor)
        columns["z [m]"] = full.z[::4]
        columns[f"{factor:g} [K]"] = (paper.T_inert - full.T_inert)[::4]
    return Table.from_columns(columns, ".5g")


def causes() -> Table:
    """Eq. 34 minus P1 [K] in the middle and at the distributor, with all radiation
    and without that of the ends.
    """
    rows = []
    for ends, text in ((True, "ends, tubes and walls"), (False, "tubes and walls")):
        paper, full = pair(ends=ends)
        T = [np.interp(0.3, one.z, one.T_inert) for one in (paper, full)]
        rows.append((text, T[0] - T[1], paper.T_d - full.T_d))
    return Table(
        {
            "radiation to": "",
            "inert in the middle [K]": ".3f",
            "distributor [K]": ".3f",
        },
        rows,
    )


def plot(tables: Tables) -> dict[str, Any]:
    """Temperatures over the height, how far eq. 34 is from P1 there, and the
    radiative flux.
    """
    figure, (height, apart, flux) = gallery.figure(1, 3, size=(13.5, 4.4))
    bed, fluxes, changes = tables["bed"], tables["fluxes"], tables["mixing"]
    z = bed["z [m]"]
    for level, (text, dashes, colour) in LEVELS.items():
        for name in SOLIDS:
            height.plot(
                z,
                bed[f"{name} by {level} [K]"],
                dashes,
                color=COLOURS[name],
                linewidth=1.3,
            )
        q = fluxes[f"q by {level} [W/m2]"]
        flux.plot(1e3 * fluxes["z [m]"], q / 1e3, dashes, color=colour, label=text)
        height.plot([], [], f"k{dashes}", label=text)
    height.set(xlabel="height [m]", ylabel="temperature [K]", xlim=(0, z[-1]))
    height.legend(loc="upper right")
    for name, text in (("T_char", "char"), ("T_inert", "inert, limestone")):
        gallery.label_line(
            height,
            text,
            0.15,
            np.interp(0.15, z, bed[f"{name} by closure [K]"]),
            COLOURS[name],
            (0, 8),
        )
    for factor, width in MIXING.items():
        z, change = changes["z [m]"], changes[f"{factor:g} [K]"]
        apart.plot(z, change, color=COLOURS["T_inert"], linewidth=width)
        shift = (-30, 8 if factor == 1 else -9)
        gallery.label_line(
            apart,
            f"dispersion x {factor:g}",
            0.3,
            np.interp(0.3, z, change),
            COLOURS["T_inert"],
            shift,
        )
    apart.set(
        xlabel="height [m]",
        ylabel="inert: eq. 34 minus P1 [K]",
        xlim=(0, z[-1]),
        ylim=(-4, None),
    )
    flux.set(
        xlabel="height [mm]",
        ylabel="radiative flux upwards [kW/m$^2$]",
        xlim=(0, 6),
        ylim=(-145, 5),
    )
    flux.set_title("at the distributor")
    flux.legend(loc="lower right")
    return {"bed": figure}
