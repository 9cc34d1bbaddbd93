"""What carries the bed in OpenFOAM's twoPhaseEulerFoam: its vertical momentum balance
over the vessel.

Three runs of 22 s on 28x100 cells. All over the weight of the particles, averaged from
2 s on, from states every 0.02 s: the pressure drop of the gas, the pressure of the
particles on the floor, the walls' shear, and what is missing to weight and gain of
momentum. The solver has no pressure of the particles: it pushes them by p'(eps_s) grad
eps_s, with the mean of p' at a face. `made` is what these forces sum to beyond the
pressure on the floor.
"""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from studies import _gallery as gallery
from studies._gallery import Table, Tables, openfoam
from studies.taghipour_bed.study import FROM, heights

END, EVERY = 22.0, 0.02  # [s]
RHO, GAS, G, PACKED, LOOSE, RESTITUTION = 2500.0, 1.2, 9.81, 0.63, 0.5, 0.9
SHARES = ("pressure", "particles", "walls", "missing", "made")
COLUMNS = (
    "case",
    *SHARES,
    "H_0.3",
    "H_0.2",
    "H_centre",
    "dense_25",
    "dense_50",
    "dense_75",
)
CASES = {
    name: openfoam.Case(
        "bed",
        28,
        100,
        END,
        0.46,
        "SyamlalOBrien",
        walls=walls,
        on_faces=on_faces,
        write_every=EVERY,
    )
    for name, walls, on_faces in (
        ("no slip", "noslip", False),
        ("slip", "slip", False),
        ("on faces", "noslip", True),
    )
}


def pressure(s: np.ndarray, theta: np.ndarray) -> np.ndarray:
    """Of the particles [Pa] by the solver's laws: its g0 stays as it is at LOOSE,
    its friction has a gap of 0.05.
    """
    g0 = 1.0 / (1.0 - np.cbrt(np.minimum(s, LOOSE) / PACKED))
    friction = (
        0.05 * np.maximum(s - LOOSE, 0.0) ** 2 / np.maximum(PACKED - s, 0.05) ** 5
    )
    return RHO * s * theta * (1.0 + 2.0 * (1.0 + RESTITUTION) * s * g0) + friction


def slope(s: np.ndarray, theta: np.ndarray) -> np.ndarray:
    """The solver's p'(eps_s) [Pa]; that of friction is not the slope of its pressure
    within the gap.
    """
    root = np.cbrt(np.clip(s, 1e-3, LOOSE) / PACKED)
    g0, slope_g0 = (
        1.0 / (1.0 - np.cbrt(np.minimum(s, LOOSE) / PACKED)),
        1.0 / (3.0 * PACKED) / (root - root**2) ** 2,
    )
    over = np.maximum(s - LOOSE, 0.0)
    friction = (
        0.05
        * (2.0 * over * (PACKED - s) + 5.0 * over**2)
        / np.maximum(PACKED - s, 0.05) ** 6
    )
    return (
        RHO * theta * (1.0 + s * (1.0 + RESTITUTION) * (4.0 * g0 + 2.0 * slope_g0 * s))
        + friction
    )


def balance(case: openfoam.Case, folder: Path) -> list[float]:
    """The numbers of one run, in the order of COLUMNS."""
    width, height = case.size
    dx, dz = width / case.nx, height / case.ny
    first = round(FROM / EVERY)
    states, rows, momentum = [], [], []
    for at in range(first, len(openfoam.times(folder))):
        s, theta, nu, u = (
            openfoam.field(case, folder, f"{name}.particles", at)
            for name in ("alpha", "Theta", "nut", "U")
        )
        w, p = u[..., 1], pressure(s, theta)
        rubbed = (
            0.0
            if case.walls == "slip"
            else 2.0 * RHO * dz / dx / width * np.sum((nu * w)[:, [0, -1]])
        )
        gas = openfoam.field(case, folder, "p", at)
        drop = np.mean(1.5 * gas[0] - 0.5 * gas[1]) - 1e5
        floor = p[0].mean() - np.mean(8.0 / 3.0 * RHO * nu[0] * w[0] / dz)
        pushed = (
            -np.sum(
                0.5 * (slope(s, theta)[1:] + slope(s, theta)[:-1]) * np.diff(s, axis=0)
            )
            / case.nx
        )
        rows.append(
            (
                drop,
                floor,
                -rubbed,
                G * dz * (RHO * s + GAS * (1.0 - s)).sum() / case.nx,
                pushed - p[0].mean(),
            )
        )
        momentum.append(RHO * dz * (s * w).sum() / case.nx)
        states.append(s)
    drop, floor, walls, weight, made = np.mean(rows, axis=0)
    gain = (momentum[-1] - momentum[0]) / (EVERY * (len(momentum) - 1))
    fractions = np.array(states)
    dense = np.quantile(fractions[fractions > 0.3], (0.25, 0.5, 0.75))
    shares = (
        np.array((drop, floor, walls, weight + gain - drop - floor - walls, made))
        / weight
    )
    z = (np.arange(case.ny) + 0.5) * dz
    return [*shares, *heights(z, fractions.mean(axis=(0, 2))), *dense]


def reference(name: str) -> list[float]:
    """The balance of one case of the peer."""
    with tempfile.TemporaryDirectory() as folder:
        openfoam.run(CASES[name], Path(folder))
        return balance(CASES[name], Path(folder))


def compute() -> Tables:
    """The three cases."""
    return {
        "budget": Table(
            dict.fromkeys(COLUMNS, ".4g"), [(name, *reference(name)) for name in CASES]
        )
    }


def plot(tables: Tables) -> dict[str, Any]:
    """What carries the weight in each case."""
    figure, axes = gallery.figure(size=(7, 3))
    table = tables["budget"]
    start = np.zeros(len(table))
    for name, colour in zip(SHARES[:4], gallery.PALETTE, strict=False):
        axes.barh(table["case"], table[name], left=start, color=colour, label=name)
        start = start + table[name]
    axes.set(xlabel="share of the weight", xlim=(0.8, 1.02))
    axes.legend(ncols=4, loc="lower center", bbox_to_anchor=(0.5, 1.0))
    return {"budget": figure}
