"""What a run records on its way, and continues after a restart: rows over time,
averages, files of particles.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from contbed.arrays import Array
from contbed.cfd_dem.coupling import Bed
from contbed.cfd_dem.heat_transfer import Average
from contbed.cfd_dem.levels import Levels
from contbed.cfd_dem.probes import Probes
from contbed.cfd_dem.tubes import TubeAverage
from contbed.dem.particle_files import write_particles
from contbed.dem.statistics import surface
from contbed.fields import header

# columns of profiles.csv
ISOTHERMAL = ("t", "pressure_drop", "height", "height_max", "coordination")
WITH_HEAT = (*ISOTHERMAL, "T_fluid", "T_solid")


@dataclass
class History:
    """Rows of profiles.csv, averages, probed points, and the times [s] at which files
    of particles were written.

    `given` heat [J] of each tube at the last row, 0 before the first.
    """

    average: Average
    probes: Probes
    levels: Levels
    tubes: tuple[TubeAverage, ...] = ()
    rows: list[list[float]] = field(default_factory=list)
    file_times: list[float] = field(default_factory=list)
    given: Array = field(init=False)

    def __post_init__(self) -> None:
        self.given = np.zeros(len(self.tubes))

    def take(self, bed: Bed) -> None:
        """Take the bed as it is now into the averages."""
        self.average(bed)
        self.levels(bed.simulation)
        for tube in self.tubes:
            tube(bed.simulation, bed.gas, bed.motion)

    def record(self, bed: Bed) -> None:
        """Add a row for the bed as it is now."""
        simulation = bed.simulation
        contacts = 2.0 * len(simulation.contacts()) / len(simulation.position)
        x = simulation.position
        row = [
            bed.time,
            bed.gas.pressure_drop,
            surface(x, simulation.radius),
            float(x[:, 2].max()),
            contacts,
        ]
        if bed.T is not None:
            held = bed.gas.mass.sum()
            solids = float(np.average(bed.T, weights=bed.capacity))
            row += [float(bed.gas.mass @ bed.gas.T / held), solids]
        self.rows.append(row + self._heat_of_tubes(bed) + self.probes.row(bed.gas))

    def _heat_of_tubes(self, bed: Bed) -> list[float]:
        """Mean heat from each tube since the last row [W]."""
        since = self.rows[-1][0] if self.rows else 0.0
        mean = (bed.from_tubes - self.given) / (bed.time - since)
        self.given = bed.from_tubes.copy()
        return [
            float(heat)
            for tube, heat in zip(bed.tubes, mean, strict=True)
            if tube.tube.T is not None
        ]

    @property
    def heating(self) -> list[str]:
        """Names of the tubes that heat the bed."""
        return [
            average.heat.tube.name
            for average in self.tubes
            if average.heat.tube.T is not None
        ]

    @property
    def columns(self) -> dict[str, Array]:
        """Columns of profiles.csv by header; none before the first row."""
        if not self.rows:
            return {}
        more = [
            *(f"{name} {header('heat_tube')}" for name in self.heating),
            *self.probes.columns,
        ]
        names = (
            WITH_HEAT if len(self.rows[0]) == len(WITH_HEAT) + len(more) else ISOTHERMAL
        )
        headers = [*(header(name) for name in names), *more]
        return dict(zip(headers, np.array(self.rows).T.copy(), strict=True))

    def write_particles(self, folder: Path, bed: Bed) -> None:
        """Write the particles as they are now, once for each time, and the list of
        all files in the folder.
        """
        from contbed.output.vtu import write_series

        if bed.time not in self.file_times:
            simulation = bed.simulation
            columns = {
                "radius": simulation.radius,
                "velocity": simulation.velocity,
                "force": bed.force,
            }
            if bed.T is not None:
                columns["T_solid"] = bed.T
            write_particles(
                folder / _name(len(self.file_times)), simulation.position, columns
            )
            self.file_times.append(bed.time)
        # a restart into another folder leaves the earlier files where they are
        files = [
            (time, _name(k))
            for k, time in enumerate(self.file_times)
            if (folder / _name(k)).is_file()
        ]
        write_series(folder / "particles.pvd", files)

    def state(self) -> dict[str, Array]:
        """Return all of it as arrays for a checkpoint."""
        kept = self.average.state() | self.levels.state() | {"given": self.given}
        for tube in self.tubes:
            kept |= tube.state()
        return kept | {
            "rows": np.array(self.rows),
            "file_times": np.array(self.file_times),
        }

    def restore(self, state: Mapping[str, Array]) -> None:
        """Continue from the arrays of `state`."""
        self.average.restore(state)
        self.levels.restore(state)
        self.given = np.array(state["given"])
        for tube in self.tubes:
            tube.restore(state)
        self.rows, self.file_times = (
            state["rows"].tolist(),
            state["file_times"].tolist(),
        )


def _name(number: int) -> str:
    return f"particles_{number:04d}.vtu"
