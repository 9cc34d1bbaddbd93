"""Expansion and pressure drop of Taghipour's bed, contbed beside OpenFOAM's
twoPhaseEulerFoam.

What gas and walls carry of the weight and what is missing (of the peer the pressure at
its inlet, see budget.py), heights over that at rest by the lateral mean of eps_s and by
the centre of the particles, drift of the inventory.
"""

from __future__ import annotations

import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from scipy.integrate import trapezoid

import contbed as cb
from studies import _gallery as gallery
from studies._gallery import Table, Tables, openfoam

HERE = Path(__file__).parent
REST, FROM = 0.4, 2.0  # height at rest [m], start of the averages [s]
COLUMNS = ("program", "case", "cells", "walls", "pressure_over_weight", "walls_over_weight", "missing",
           "H_0.3", "H_0.2", "H_centre", "mass_drift", "cpu_s")  # fmt: skip
# of the weight: by the gas, on the walls, by nothing
SHARES = ("pressure", "walls", "missing")
NOT_COMPARED = ("walls_over_weight", "missing", "mass_drift", "cpu_s")
SCENES = ("bed_0.38", "bed_0.46", "bed_0.46_fine", "bed_0.46_slip")
FRAMES = "bed_0.46"  # scene that is drawn second by second
PEERS = {
    "noslip 0.46": openfoam.Case(
        "bed", 56, 200, 6.0, 0.46, "SyamlalOBrien", average_from=FROM
    ),
    "slip 0.46": openfoam.Case(
        "bed", 56, 200, 6.0, 0.46, "SyamlalOBrien", average_from=FROM, walls="slip"
    ),
    "noslip 0.46 upwind": openfoam.Case(
        "bed", 56, 200, 6.0, 0.46, "SyamlalOBrien", average_from=FROM, upwind=True
    ),
    "noslip 0.38": openfoam.Case(
        "bed", 56, 200, 6.0, 0.38, "SyamlalOBrien", average_from=FROM
    ),
}


def heights(z: np.ndarray, eps_s: np.ndarray) -> list[float]:
    """Where the mean over the width falls below 0.3 and 0.2, and twice the centre of
    the particles, over REST.
    """
    tops = [float(z[np.flatnonzero(eps_s < level)[0]]) for level in (0.3, 0.2)]
    return [value / REST for value in (*tops, 2.0 * float(z @ eps_s / eps_s.sum()))]


def own(name: str) -> list[Any]:
    """One row of contbed."""
    scene = cb.load(HERE / f"{name}.toml")
    cpu, result = gallery.cpu(lambda: cb.run(scene), samples=1)
    axial = result.tables["axial"]
    shares = [result.qoi[f"weight_{name}"] for name in SHARES]
    cells = "x".join(str(n) for n in scene.mesh.cells)
    return [
        "contbed",
        name,
        cells,
        scene.boundary["left"].solid.wall,
        *shares,
        *heights(axial["height [m]"], axial["eps_s [1]"]),
        result.qoi["mass_drift_relative"],
        cpu,
    ]


def reference(name: str) -> list[Any]:
    """One row of the peer."""
    case = PEERS[name]
    with tempfile.TemporaryDirectory() as folder:
        found = openfoam.run(case, Path(folder))
        eps_s = openfoam.field(case, Path(folder), "alpha.particlesMean").mean(axis=1)
        t, p = openfoam.series(Path(folder), "inlet", "surfaceFieldValue")[:, :2].T
    late = t > FROM
    weight = 2500.0 * 9.81 * openfoam.BED_FRACTION * openfoam.BED_HEIGHT
    share = float(trapezoid(p[late] - 1e5, t[late]) / np.ptp(t[late])) / weight
    z = (np.arange(case.ny) + 0.5) / case.ny
    return [
        "twoPhaseEulerFoam",
        name,
        f"{case.nx}x{case.ny}",
        case.walls,
        share,
        None,
        None,
        *heights(z, eps_s),
        found["mass_drift_relative"],
        found["cpu_s"],
    ]


def frames() -> Table:
    """eps_s of every cell, second by second."""
    plan = cb.plan(cb.load(HERE / f"{FRAMES}.toml"))
    bed, _ = plan.bed()
    nx, nz = plan.scene.mesh.cells
    columns = {"x [m]": np.tile(np.unique(bed.model.grid.centres[:, 0].round(9)), nz)}
    columns["z [m]"] = np.repeat(np.unique(bed.model.grid.centres[:, 1].round(9)), nx)
    place = np.lexsort(bed.model.grid.centres.T.round(9))
    for second in range(1, 7):
        bed.advance(float(second))
        columns[f"eps_s at {second} s [1]"] = bed.state.eps_s[place].round(3)
    return Table.from_columns(columns, ".4g")


def compute(cases: Sequence[str] = (*SCENES, *PEERS)) -> Tables:
    """Scenes and cases of the peer; its committed rows are kept where it is not
    installed.
    """
    new = [
        own(name) if name in SCENES else reference(name)
        for name in cases
        if name in SCENES or openfoam.available()
    ]
    rows = Table(dict.fromkeys(COLUMNS, ".4g"), new)
    tables = {
        "results": Table.read(HERE / "results.csv").updated(rows, ["program", "case"])
    }
    return tables | ({"frames": frames()} if FRAMES in cases else {})


def plot(tables: Tables) -> dict[str, Any]:
    """Solid fraction of one run, second by second."""
    if "frames" not in tables:
        return {}
    table = tables["frames"]
    x, z = (np.unique(table[name]) for name in ("x [m]", "z [m]"))
    figure, axes = gallery.figure(1, 6, size=(9, 4.6), sharey=True)
    for second, panel in enumerate(axes, start=1):
        eps_s = table[f"eps_s at {second} s [1]"].reshape(len(z), len(x))
        shades = panel.pcolormesh(
            100 * x, 100 * z, eps_s, vmin=0.0, vmax=0.63, cmap="cividis"
        )
        panel.set(aspect="equal", title=f"{second} s", xlabel="x [cm]", ylim=(0, 85))
    axes[0].set_ylabel("height [cm]")
    figure.colorbar(shades, ax=axes, label="eps_s [1]", shrink=0.7)
    return {"bed_0.46_frames": figure}
