"""What enters a reacting bed as a function of time: flows, and the composition of the
gas.

composition = { times = ["0 s", "10 min"], values = ["N2:1", "N2:0.9, CO2:0.1"],
form = "step" }
composition = { file = "feed.csv" }      with columns t [min], N2 [1], CO2 [%], mole fractions of each species
"""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any, ClassVar

import numpy as np

from contbed.arrays import Array
from contbed.errors import SceneError
from contbed.materials.composition import mole_fractions
from contbed.scene.quantities import unit
from contbed.scene.series import OrSeries, Samples, Series

SUM = 2e-3  # by which fractions with three digits may miss one
MassFlux = Annotated[float, *unit("kg/m**2/s")]
MolarFlux = Annotated[float, *unit("mol/m**2/s")]
Speed = Annotated[float, *unit("m/s")]


class MassFluxSeries(Series):
    """A mass flux that changes with time; steps may reverse it."""

    quantity: ClassVar[str] = "kg/m**2/s"
    values: tuple[MassFlux, ...] = ()
    """one for each time"""


class MolarFluxSeries(Series):
    """A molar flux that changes with time; steps may reverse it."""

    quantity: ClassVar[str] = "mol/m**2/s"
    values: tuple[MolarFlux, ...] = ()
    """one for each time"""


class SpeedSeries(Series):
    """A superficial velocity that changes with time; steps may reverse it."""

    quantity: ClassVar[str] = "m/s"
    values: tuple[Speed, ...] = ()
    """one for each time"""


class CompositionSeries(Series):
    """Mole fractions of the gas that enters as functions of time."""

    values: tuple[str, ...] = ()
    """one for each time, "N2:0.9, CO2:0.1"
    """
    column: None = None
    """has no meaning: a file has a column for each species"""

    def fractions(self, base: Path) -> tuple[tuple[str, ...], Array, Array, list[str]]:
        """Return species, times (n,), mole fractions (n, species) and the begin of
        messages about each time.

        Raises
        ------
        SceneError : the file or a composition cannot be used
        """
        if self.file is None:
            parts = [mole_fractions(text) for text in self.values]
            names = tuple(dict.fromkeys(name for part in parts for name in part))
            table = np.array(
                [[part.get(name, 0.0) for name in names] for part in parts]
            )
            return names, np.array(self.times), table, [""] * len(parts)
        # with it the conversion of units
        from contbed.scene.data_table import read_table
        from contbed.scene.units import factor_and_offset

        read = read_table(base / self.file)
        times = read.column(read.name_in("s"), "s")
        names = tuple(
            name
            for name, given in zip(read.names, read.units, strict=True)
            if factor_and_offset(given or "1", "1") is not None
        )
        if not names:
            raise SceneError(
                f"{read.path.name}: no column with mole fractions, such as 'CO2 [1]'"
            )
        table = np.column_stack([read.column(name, "1") for name in names])
        for line, row in zip(read.lines, table, strict=True):
            if row.min() < 0.0 or abs(row.sum() - 1.0) > SUM:
                raise read.error(
                    line,
                    "mole fractions must be 0 or more and sum to 1; they sum to "
                    f"{row.sum():.6g}",
                )
        return (
            names,
            times,
            table / table.sum(axis=1)[:, None],
            [f"{read.path.name}:{line}: " for line in read.lines],
        )

    def samples(self, base: Path) -> Samples:
        """Return times and mole fractions (times, species); see `fractions`."""
        names, times, table, where = self.fractions(base)
        return replace(self.checked(times, table, where), species=names)


def constant(value: Any) -> float:
    """Return a value of a scene whose series have been replaced by the values of a
    time.
    """
    assert not isinstance(value, Series)
    return float(value)


MassFluxOrSeries = OrSeries[MassFlux, MassFluxSeries]
MolarFluxOrSeries = OrSeries[MolarFlux, MolarFluxSeries]
SpeedOrSeries = OrSeries[Speed, SpeedSeries]
CompositionOrSeries = OrSeries[str, CompositionSeries]
