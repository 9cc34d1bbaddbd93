"""Profiles of the riser in the window of the measurements, contbed beside
twoPhaseEulerFoam.
"""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import contbed as cb
from studies import _gallery as gallery
from studies._gallery import Table, Tables

HERE = Path(__file__).parent
WIDTH = 0.152  # of the riser [m]
SCENES = ("ff_wenyu", "ff_syamlal", "dpt_wenyu", "dpt_syamlal", "dpt_wenyu_36.8")
PANELS = ("eps_s [1]", "u_solid [m/s]", "theta_total [m2/s2]")
PRINTED = ("steps", "mass_drift_relative", "eps_s_max", "difference_of_halves")
DRAGS = {"wenyu": gallery.BLUE, "syamlal": gallery.VERMILION}
FLOWS = {"ff": "fast fluidization", "dpt": "dilute transport"}
# in each flow one more profile of ours: on the fine grid of accuracy.py, and with the
# highest flux
MORE = {
    "ff": ("ff_wenyu_fine", gallery.GREEN, "contbed, wenyu, 30x700"),
    "dpt": ("dpt_wenyu_36.8", gallery.PURPLE, "contbed, wenyu, 36.8 kg/m2/s"),
}


def reference(tables: Tables, flow: str, drag: str) -> dict[str, Any]:
    """The peer's profile under our names; what its averages lack in the third
    direction counts as the lateral one.
    """
    found = tables[f"twoPhaseEulerFoam_{flow}_{drag}"]
    moved = (found["var_us_axial"] + 2.0 * found["var_us_lateral"]) / 3.0
    return {
        "x [m]": WIDTH * found["x_over_W"],
        "eps_s [1]": found["es_mean"],
        "u_solid [m/s]": found["us_mean"],
        "theta_total [m2/s2]": found["theta_mean"] + moved,
    }


def compute(cases: Sequence[str] = SCENES) -> Tables:
    """Lateral profiles of the scenes."""
    tables = {}
    for name in cases:
        with tempfile.TemporaryDirectory() as folder:
            seconds, result = gallery.cpu(
                lambda n=name, f=folder: cb.run(cb.load(HERE / f"{n}.toml"), Path(f)),
                samples=1,
            )
            tables[f"{name}_lateral"] = Table.read(Path(folder) / "lateral.csv")
        print(
            f"{name}: {seconds:.0f} s of CPU",
            *(f"{key} {result.qoi[key]:.2g}" for key in PRINTED),
            flush=True,
        )
    return tables


def plot(tables: Tables) -> dict[str, Any]:
    """Fraction, velocity and granular temperature across the riser."""
    figure, axes = gallery.figure(2, 3, size=(9, 5.2), sharex=True)
    for line, (flow, title) in zip(axes, FLOWS.items(), strict=True):
        curves: list[tuple[Any, str, str, str]] = []
        for drag, colour in DRAGS.items():
            curves.append(
                (tables[f"{flow}_{drag}_lateral"], "-", colour, f"contbed, {drag}")
            )
            curves.append(
                (
                    reference(tables, flow, drag),
                    "--",
                    colour,
                    f"twoPhaseEulerFoam, {drag}",
                )
            )
        scene, colour, label = MORE[flow]
        curves.append((tables[f"{scene}_lateral"], "-", colour, label))
        for panel, key in zip(line, PANELS, strict=True):
            for data, style, colour, label in curves:
                panel.plot(data["x [m]"], data[key], style, color=colour, label=label)
            panel.set(ylabel=key.replace("_", " "), title=title)
    for panel in axes[1]:
        panel.set_xlabel(gallery.label("x"))
    known = {curve.get_label(): curve for panel in axes[:, 0] for curve in panel.lines}
    figure.legend(known.values(), known.keys(), loc="outside lower center", ncols=3)
    return {"profiles": figure}
