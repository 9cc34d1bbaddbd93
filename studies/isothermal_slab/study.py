"""Emittance of isothermal slabs over albedo and thickness, by every level and by
transport.
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

import contbed as cb
from contbed.closures.optics import SIGMA
from studies import _gallery as gallery
from studies._exact.radiation import P1, TWO_FLUX, isothermal_slab
from studies._exact.transport import slab_emittance
from studies._gallery import Table, Tables

HERE = Path(__file__).parent
DIFFUSION = {"two_flux": TWO_FLUX, "p1": P1}
ALBEDOS = (0.0, 0.3, 0.5, 0.7, 0.9, 0.99, 0.999)
THICKNESSES = (0.01, 0.03, 0.1, 0.3, 1.0, 3.0, 10.0, 30.0, 100.0)
LEVELS = {"two-flux": ("two_flux", 1), "P1": ("p1", 1), "4 + 4 ordinates": ("ordinates", 4),
          "8 + 8 ordinates": ("ordinates", 8)}  # fmt: skip
STYLES = {"two-flux": ":", "P1": "--", "8 + 8 ordinates": "-"}
SHOWN = (0.0, 0.5, 0.9, 0.99)
NOT_COMPARED = tuple(f"error of {name}" for name in LEVELS)


def variant(albedo: float, tau: float, level: str, ordinates: int = 8) -> cb.Scene:
    """The scene of albedo 0.5 and tau = 1 with other values."""
    beta = tau / 0.1
    changes = {
        "radiation.absorption": beta * (1.0 - albedo),
        "radiation.scattering": beta * albedo,
    }
    named = {"radiation.level": level, "radiation.ordinates": ordinates}
    return cb.load(HERE / "albedo_0.5_tau_1.toml", named | changes)


def parameters(scene: cb.Scene) -> tuple[float, float]:
    """Albedo and optical thickness of a scene."""
    table = scene.radiation
    beta = table.absorption + table.scattering
    return table.scattering / beta, beta * scene.mesh.length


def closed_form(scene: cb.Scene) -> float:
    """Emittance by the model of the scene's level: two-flux or P1."""
    albedo, tau = parameters(scene)
    return float(isothermal_slab(tau, DIFFUSION[scene.radiation.level], albedo))


def reference(scene: cb.Scene) -> float:
    """Emittance by transport."""
    albedo, tau = parameters(scene)
    return float(slab_emittance(tau, albedo))


def found(result: cb.Result) -> Any:
    """Emittance of both sides of the slab in a run."""
    scene = result.plan.scene
    power = SIGMA * scene.radiation.temperature**4
    return np.array(
        [-result.qoi[f"heat_{name}_W"] / power for name in ("left", "right")]
    )


def compute() -> Tables:
    """All slabs by all levels."""
    rows, against = [], 0.0
    for albedo in ALBEDOS:
        for tau in THICKNESSES:
            exact = float(slab_emittance(tau, albedo))
            row = [albedo, tau, exact]
            for level, ordinates in LEVELS.values():
                scene = variant(albedo, tau, level, ordinates)
                value = found(cb.run(scene))[1]
                row += [value, value / exact - 1]
                if level in DIFFUSION:
                    against = max(against, abs(value / closed_form(scene) - 1))
            rows.append(row)
    print(f"two-flux and P1 against closed forms: {against:.1e}")
    columns = {"albedo [1]": "g", "tau [1]": "g", "emittance exact [1]": ".10f"}
    for name in LEVELS:
        columns |= {f"{name} [1]": ".10f", f"error of {name}": ".1e"}
    return {"emittance": Table(columns, rows)}


def plot(tables: Tables) -> dict[str, Any]:
    """Emittance over thickness, and how far the models are from transport."""
    figure, (left, right) = gallery.figure(1, 2, size=(11.5, 4.4))
    for albedo, colour in zip(SHOWN, gallery.shades(len(SHOWN)), strict=True):
        rows = tables["emittance"].where({"albedo [1]": albedo})
        tau, exact = rows["tau [1]"], rows["emittance exact [1]"]
        for name, dashes in STYLES.items():
            values = rows[f"{name} [1]"]
            left.semilogx(tau, values, dashes, color=colour)
            right.semilogx(tau, 100 * (values / exact - 1), dashes, color=colour)
        left.semilogx(tau, exact, "o", color=colour)
        gallery.label_line(left, rf"$\omega$ = {albedo:g}", tau[-1], exact[-1], colour)
    left.plot([], [], "ko", label="transport")
    for name, dashes in STYLES.items():
        left.plot([], [], f"k{dashes}", label=name)
    left.legend(loc="upper left")
    left.set(
        xlabel=r"optical thickness $\tau$",
        ylabel=r"emittance $q/\sigma T^4$",
        ylim=(0, 1.1),
    )
    right.set(
        xlabel=r"optical thickness $\tau$", ylabel="difference from transport [%]"
    )
    return {"emittance": figure}
