"""The bed with the real modulus of glass, 50 GPa, beside soft beads whose contacts
are corrected (Fig. 10).
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from studies import _gallery as gallery
from studies._gallery import Table, Tables
from studies.zhou_2009_htc import study

HERE = Path(__file__).parent
REAL = 5e10  # Pa
VELOCITIES = ("0.42", "1.4")  # m/s: packed and bubbling
CONDUCTIVITIES = ("0.84", "30")  # W/m/K


def reference() -> Table:
    """Coefficients of the soft beads, by mechanism."""
    return Table.read(HERE / "mechanisms.csv")


def compute(cases: Sequence[str] = VELOCITIES) -> Tables:
    """Coefficients by mechanism of stiff beads; contacts of 50 GPa are corrected by a
    factor of 1.

    Committed rows of other velocities are kept.
    """
    packing = study.settled(modulus=REAL)
    whole = study.mechanisms([study.one_velocity(packing, float(U)) for U in cases])
    found = Table.of([row for row in whole if row["case"] in study.COLOURS])
    return {"stiff": Table.read(HERE / "stiff.csv").updated(found, ["U [m/s]", "case"])}


def plot(tables: Tables) -> dict[str, Any]:
    """Conduction of soft beads by treatment, beside that of stiff ones."""
    figure, panels = gallery.figure(1, 2, size=(8.4, 3.8))
    soft, stiff = reference(), tables["stiff"]
    for axes, k in zip(panels, CONDUCTIVITIES, strict=True):
        for case, (style, text) in study.CORRECTIONS.items():
            axes.plot(
                *study.part(soft, case.replace("0.84", k), *study.CONDUCTION),
                style,
                label=text,
            )
        axes.plot(*study.part(stiff, k, *study.CONDUCTION), "k*", ms=12, label="50 GPa")
        axes.set(xlabel="$U$ [m/s]", title=f"$k_p$ = {k} W/m/K", ylim=(0, None))
    panels[0].set_ylabel("conduction [W/m$^2$/K]")
    panels[0].legend()
    return {"stiff": figure}
