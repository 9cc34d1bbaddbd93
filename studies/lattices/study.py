"""Contact conduction of cubic lattices beside the exact sum over contacts."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import contbed as cb
from studies import _gallery as gallery
from studies._gallery import Table, Tables

HERE = Path(__file__).parent
CONTACTS = {"sc": 6, "bcc": 8, "fcc": 12}
COLUMNS = {
    "scene": "",
    "contacts": "d",
    "k_eff R/(k_p r_c) [1]": ".15g",
    "exact [1]": ".15g",
}


def reference() -> dict[str, float]:
    """k_eff R/(k_p r_c) of each lattice."""
    return {"sc": 1.0, "bcc": 3.0**0.5, "fcc": 8.0**0.5}


def compute() -> Tables:
    """The three lattices."""
    exact = reference()
    rows = [
        (
            name,
            contacts,
            cb.run(cb.load(HERE / f"{name}.toml")).qoi["k_eff_over_contact_scale"],
            exact[name],
        )
        for name, contacts in CONTACTS.items()
    ]
    return {"results": Table(COLUMNS, rows)}


def plot(tables: Tables) -> dict[str, Any]:
    """Conductivity over the number of contacts."""
    table, (_, contacts, found, exact) = tables["results"], COLUMNS
    figure, axes = gallery.figure()
    axes.plot(
        table[contacts],
        table[exact],
        "o",
        markersize=9,
        mfc="white",
        color=gallery.VERMILION,
        label="exact",
    )
    axes.plot(table[contacts], table[found], "o", color=gallery.BLUE, label="contbed")
    axes.set(
        xlabel="contacts of a sphere",
        ylabel=r"$k_\mathrm{eff} R/(k_p r_c)$",
        ylim=(0, 3),
        xticks=(6, 8, 12),
    )
    axes.legend(loc="lower right")
    return {"lattices": figure}
