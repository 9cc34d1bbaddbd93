"""Two sweeps over the moving-bed heater: a map of its design, and what uncertain values leave open.

python studies/moving_bed_design/study.py
"""

from __future__ import annotations

import shutil
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from contbed.output.tables import read_table
from contbed.sweep.sweep import sweep

HERE = Path(__file__).parent
SILICA_IN = 973.15
WITHIN = 10.0


def main() -> None:
    """Run both sweeps, keep their tables and pictures, print what the README says."""
    for name in ("map", "uncertainty"):
        with TemporaryDirectory() as out:
            sweep(HERE / "sweeps" / f"{name}.toml", out, quiet=False)
            shutil.copy(Path(out) / "sweep.png", HERE / f"{name}.png")
            columns(Path(out) / "table.csv", HERE / f"{name}.csv")
    table = read_table(HERE / "map.csv")
    for d in np.unique(table["bed.particle_diameter [m]"]):
        close = (table["bed.particle_diameter [m]"] == d) & (SILICA_IN - table["T_fluid_out [K]"] < WITHIN)
        slowest = np.abs(table["flow.velocity_solid [m/s]"][close]).min(initial=np.inf)
        print(f"{1e3 * d:5.1f} mm: within {WITHIN:g} K from {1e3 * slowest:.2f} mm/s")
    table = read_table(HERE / "uncertainty.csv")
    steam, silica, hot = (table[n] for n in ("T_fluid_out [K]", "T_solid_out [K]", "boundary.top.solid.fixed [K]"))
    print(
        f"steam {steam.mean():.1f} K, deviation {steam.std(ddof=1):.1f} K, correlation with the silica's inlet "
        f"{np.corrcoef(steam, hot)[0, 1]:.3f}"
    )
    print(f"below the silica's inlet: mean {(hot - steam).mean():.1f} K, largest {(hot - steam).max():.1f} K")
    velocity = table["flow.velocity_solid [m/s]"]
    print(
        f"silica leaves at {silica.mean():.0f} K, deviation {silica.std(ddof=1):.0f} K, correlation with its "
        f"velocity {np.corrcoef(silica, velocity)[0, 1]:.3f}"
    )


def columns(source: Path, target: Path) -> None:
    """Copy the columns of numbers: parameters and results, without the names of the runs."""
    lines = [line.split(",")[:-3] for line in source.read_text(encoding="utf-8").splitlines()]
    target.write_text("".join(",".join(line) + "\n" for line in lines), encoding="utf-8")


if __name__ == "__main__":
    main()
