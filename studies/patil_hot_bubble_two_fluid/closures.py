"""Which closure makes the hot bubble smaller than beside particles: one changed at a
time.
"""

from __future__ import annotations

from typing import Any

import numpy as np

import contbed as cb
from studies import _gallery as gallery
from studies._gallery import Table, Tables
from studies._gallery.raw import raw
from studies.patil_hot_bubble_two_fluid import study

HERE, HALF, WHOLE = study.HERE, "half_3mm_900", "3mm_900"
BY_CHIALVO = {
    "solids.beads.sliding_friction": 0.1,
    "closures.effective_restitution": "chialvo_sundaresan",
}
BY_JENKINS = BY_CHIALVO | {"closures.effective_restitution": "jenkins_zhang"}
RUNS: dict[str, dict[str, Any]] = {
    "as the study": {},
    "no friction": {
        "closures.friction_pressure": "none",
        "closures.friction_viscosity": "none",
    },
    "friction from 0.62": {"solids.beads.friction.start": 0.62},
    "no friction viscosity": {"closures.friction_viscosity": "none"},
    "drag by Syamlal and O'Brien": {"closures.drag": "drag_syamlal_obrien"},
    "drag by Di Felice": {"closures.drag": "drag_di_felice"},
    "drag by Beetstra": {"closures.drag": "drag_beetstra"},
    "restitution 0.9": {"solids.beads.restitution": 0.9},
    "restitution 0.8": {"solids.beads.restitution": 0.8},
    "friction of particles (Chialvo, Sundaresan)": BY_CHIALVO,
    "friction of particles (Jenkins, Zhang)": BY_JENKINS,
    "restitution 0.859 in all": {"solids.beads.restitution": 0.859},
    "granular temperature frozen at 1e-5 m2/s2": {
        "two_fluid.granular_temperature": "frozen",
        "initial.solids.beads.granular_temperature": 1e-5,
    },
    "no stress of the particles": {
        "closures.granular_viscosity": "none",
        "closures.friction_viscosity": "none",
    },
    "paper's width": {},
    "paper's width, friction of particles (Chialvo, Sundaresan)": BY_CHIALVO,
}


def compute() -> Tables:
    """Diameter at the end of injection and later, and over that of the bubble beside
    particles.
    """
    rows = []
    for number, (name, changes) in enumerate(RUNS.items()):
        folder, case = (
            f"closures_{number}",
            WHOLE if name.startswith("paper's") else HALF,
        )
        cb.run(study.scene(case, changes), raw(HERE.name) / folder)
        found = Table(dict.fromkeys(study.COLUMNS, ".6g"), study.series(folder))
        stop, _, late, *_ = study.moments(case, found)
        particles = reference(case)
        rows.append((name, stop, stop / particles[0], late, late / particles[1]))
        print(name, f"{stop:.4f} {late:.4f}", flush=True)
    columns = {"run": ""}
    for when in ("at the end of injection", "later"):
        columns |= {f"diameter {when} [m]": ".4g", f"over particles {when}": ".3g"}
    return {"closures": Table(columns, rows)}


def reference(case: str) -> tuple[float, float]:
    """Diameters of the bubble beside particles [m], at the end of injection and
    later.
    """
    stop, _, late, *_ = study.moments(case, study.reference().where({"case": case}))
    return stop, late


def plot(tables: Tables) -> dict[str, Any]:
    """Diameters over those beside particles."""
    found = tables["closures"]
    figure, axes = gallery.figure(1, 1, size=(7.5, 4.2))
    place = np.arange(len(found.rows))[::-1]
    for name, mark, colour in (
        ("at the end of injection", "o", gallery.BLUE),
        ("later", "s", gallery.VERMILION),
    ):
        axes.plot(
            found[f"over particles {name}"], place, mark, color=colour, label=name
        )
    axes.axvline(1.0, color="0.5", lw=0.8)
    axes.set(
        xlabel="diameter over that beside particles",
        yticks=place,
        yticklabels=list(RUNS),
    )
    axes.legend(fontsize=8, ncols=2, loc="lower right", bbox_to_anchor=(1.0, 1.0))
    return {"closures": figure}
