"""Expansion and pressure drop of Taghipour's bed, contbed beside OpenFOAM's twoPhaseEulerFoam.

    python study.py [peer]     all scenes of this folder; "peer" runs OpenFOAM too (25 minutes)
    python study.py frames     only the frames of bed_0.46.toml

Writes results.csv: what gas and walls carry of the weight and what is missing (of the peer the pressure at its inlet,
see budget.py), heights over that at rest by the lateral mean of eps_s and by the centre of the particles, drift of the
inventory.
"""

from __future__ import annotations

import csv
import sys
import tempfile
import time
from pathlib import Path

import numpy as np
from scipy.integrate import trapezoid

import contbed as cb

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE.parent / "two_fluid_speed"))
import openfoam  # noqa: E402

REST, FROM = 0.4, 2.0  # height at rest [m], start of the averages [s]
COLUMNS = ("program", "case", "cells", "walls", "pressure_over_weight", "walls_over_weight", "missing",
           "H_0.3", "H_0.2", "H_centre", "mass_drift", "cpu_s")  # fmt: skip
PEERS = {
    "noslip 0.46": openfoam.Case("bed", 56, 200, 6.0, 0.46, "SyamlalOBrien", average_from=FROM),
    "slip 0.46": openfoam.Case("bed", 56, 200, 6.0, 0.46, "SyamlalOBrien", average_from=FROM, walls="slip"),
    "noslip 0.46 upwind": openfoam.Case("bed", 56, 200, 6.0, 0.46, "SyamlalOBrien", average_from=FROM, upwind=True),
    "noslip 0.38": openfoam.Case("bed", 56, 200, 6.0, 0.38, "SyamlalOBrien", average_from=FROM),
}


def heights(z: np.ndarray, eps_s: np.ndarray) -> list[float]:
    """Where the mean over the width falls below 0.3 and 0.2, and twice the centre of the particles, over REST."""
    tops = [float(z[np.flatnonzero(eps_s < level)[0]]) for level in (0.3, 0.2)]
    return [value / REST for value in (*tops, 2.0 * float(z @ eps_s / eps_s.sum()))]


def own(path: Path) -> list:
    scene = cb.load(path)
    start = time.process_time()
    result = cb.run(scene)
    cpu = time.process_time() - start
    axial = result.tables["axial"]
    shares = [result.qoi[f"weight_{name}"] for name in ("pressure", "walls", "missing")]
    cells = "x".join(str(n) for n in scene.mesh.cells)
    return [
        "contbed",
        path.stem,
        cells,
        scene.boundary["left"].solid,
        *shares,
        *heights(axial["height [m]"], axial["eps_s [1]"]),
        result.qoi["mass_drift_relative"],
        cpu,
    ]


def peer(name: str, case: openfoam.Case) -> list:
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
        "",
        "",
        *heights(z, eps_s),
        found["mass_drift_relative"],
        found["cpu_s"],
    ]


def frames() -> None:
    """Solid fraction of one run, second by second, in bed_0.46_frames.png."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    plan = cb.plan(cb.load(HERE / "bed_0.46.toml"))
    bed, _ = plan.bed()
    figure, axes = plt.subplots(1, 6, figsize=(9, 4.6), layout="constrained", sharey=True)
    nx, nz = plan.scene.mesh.cells
    x, z = (np.unique(values.round(9)) for values in bed.model.grid.centres.T)
    for second, panel in enumerate(axes, start=1):
        bed.advance(float(second))
        place = np.lexsort(bed.model.grid.centres.T.round(9))
        eps_s = bed.state.eps_s[place].reshape(nz, nx)
        shades = panel.pcolormesh(100 * x, 100 * z, eps_s, vmin=0.0, vmax=0.63, cmap="cividis")
        panel.set(aspect="equal", title=f"{second} s", xlabel="x [cm]", ylim=(0, 85))
    axes[0].set_ylabel("height [cm]")
    figure.colorbar(shades, ax=axes, label="eps_s [1]", shrink=0.7)
    figure.savefig(HERE / "bed_0.46_frames.png", dpi=110)


def main(with_peer: bool) -> None:
    rows = [own(path) for path in sorted(HERE.glob("*.toml"))]
    if with_peer:
        rows += [peer(name, case) for name, case in PEERS.items()]
    with open(HERE / "results.csv", "w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(COLUMNS)
        writer.writerows([f"{value:.4g}" if isinstance(value, float) else value for value in row] for row in rows)


if __name__ == "__main__":
    if "frames" in sys.argv[1:]:
        frames()
    else:
        main("peer" in sys.argv[1:])
