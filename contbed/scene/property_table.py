"""Properties of solids as tables over temperature: pairs in the scene, or columns of a
CSV file.

    heat_capacity = { temperatures = ["20 degC", "600 degC"], values = [790, 1100] }
    conductivity = { file = "granite.csv", column = "k" }
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from itertools import pairwise
from typing import Annotated, Any, ClassVar, Self

import numpy as np
from pydantic import Discriminator, Field, Tag, ValidationError, model_validator

from contbed.errors import SceneError
from contbed.scene.inputs import why_unusable
from contbed.scene.quantities import (
    Density,
    HeatCapacity,
    PositiveConductivity,
    Table,
    Temperature,
    unit,
)
from contbed.scene.series import Changing, Quantity, how_written
from contbed.scene.tables import Polynomial
from contbed.scene.toml_lines import KeyPath, Origin


class PropertyTable(Table):
    """A property over temperature: linear between the temperatures, constant beyond.

    A loaded scene has the values of a file beside its name.
    """

    quantity: ClassVar[str]

    temperatures: tuple[Temperature, ...] = ()
    """in increasing order, two or more"""
    values: tuple[Any, ...] = ()
    """one for each temperature"""
    file: str | None = None
    """CSV file instead, path relative to the scene"""
    column: str | None = None
    """of the file; absent: the first column with the right kind of unit"""

    @model_validator(mode="after")
    def _usable(self) -> Self:
        T = self.temperatures
        if self.file is not None and not T:
            return self  # it cannot be read, which is a mistake of its own
        if len(T) < 2 or len(T) != len(self.values):
            raise ValueError(
                f"{len(T)} temperatures and {len(self.values)} values; give two or "
                "more temperatures, each with one value, or a file"
            )
        late = next((right for left, right in pairwise(T) if right <= left), None)
        if late is not None:
            raise ValueError(
                f"temperatures must increase, up to {late:g} K they do not"
            )
        return self


class HeatCapacityTable(PropertyTable):
    """A heat capacity over temperature."""

    quantity: ClassVar[str] = "J/kg/K"
    values: tuple[HeatCapacity, ...] = ()
    """one for each temperature"""


class ConductivityTable(PropertyTable):
    """A conductivity over temperature."""

    quantity: ClassVar[str] = "W/m/K"
    values: tuple[PositiveConductivity, ...] = ()
    """one for each temperature"""


class DensityTable(PropertyTable):
    """A density over temperature."""

    quantity: ClassVar[str] = "kg/m**3"
    values: tuple[Density, ...] = ()
    """one for each temperature"""


TABLES: Mapping[str, type[PropertyTable]] = {
    "density": DensityTable,
    "heat_capacity": HeatCapacityTable,
    "conductivity": ConductivityTable,
}

# a constant, a polynomial or a table over temperature
OfSolid = Annotated[
    Annotated[Quantity, Tag("number")]
    | Polynomial
    | Annotated[Changing, Tag("series")],
    Discriminator(how_written),
]
HeatCapacityOfSolid = OfSolid[HeatCapacity, HeatCapacityTable]
ConductivityOfSolid = OfSolid[PositiveConductivity, ConductivityTable]


class Melting(Table):
    """Latent heat of a phase change material, as an effective heat capacity."""

    latent_heat: Annotated[float, *unit("J/kg"), Field(gt=0)]
    """taken up between start and end, beside the heat capacity"""
    start: Temperature
    """all is solid below"""
    end: Temperature
    """all is liquid above"""

    @model_validator(mode="after")
    def _rises(self) -> Self:
        if self.end <= self.start:
            raise ValueError(
                f"end, {self.end:g} K, must lie above start, {self.start:g} K: give "
                "the range over which the material melts, 1 K or more"
            )
        return self


def constant_at(key: str, given: Any, T: float) -> float:
    """Return a property at one temperature [K]: a polynomial, or a table as it is
    written in a scene.

    Raises
    ------
    ValueError : it is neither
    """
    if isinstance(given, list | tuple):
        if not all(isinstance(a, int | float) for a in given):
            raise ValueError(
                "a list holds coefficients of 1, T, T^2, ..., numbers in SI"
            )
        try:
            return float(sum(a * T**n for n, a in enumerate(given)))
        except OverflowError as error:
            raise ValueError("a coefficient is too large") from error
    try:
        table = TABLES[key].model_validate(given)
    except ValidationError as invalid:
        first = invalid.errors(include_url=False)[0]
        raise ValueError(
            f"{'.'.join(map(str, first['loc'])) or 'the table'}: {first['msg']}"
        ) from None
    return float(np.interp(T, table.temperatures, table.values))


def range_of(*properties: Any) -> tuple[float, float]:
    """Return the temperatures [K] at which all tables among properties hold."""
    tables = [each for each in properties if isinstance(each, PropertyTable)]
    low = max((each.temperatures[0] for each in tables), default=0.0)
    return low, min((each.temperatures[-1] for each in tables), default=math.inf)


def read_files(
    values: Mapping[str, Any], origin: Origin
) -> Iterator[tuple[KeyPath, str]]:
    """Put the columns of files into the tables in [solids.NAME] that name them; yield
    those that cannot be used, and why.

    A resolved scene has its values beside the file, which may be missing then.
    """
    for path, table in _with_a_file(values):
        if not isinstance(table["file"], str):
            continue  # the schema says what is wrong
        given = {
            key: list(table[key]) for key in ("temperatures", "values") if key in table
        }
        if given and not (origin.base / table["file"]).is_file():
            continue
        reason = why_unusable((*path, "file"), table["file"], origin)
        if reason:
            yield (*path, "file"), reason
            continue
        try:
            read = _columns(TABLES[str(path[-1])], table, origin)
        except (SceneError, ValueError) as error:  # ValueError: no name of a file
            yield path, str(error)
            continue
        if given and given != read:
            yield path, "the file has other values: remove temperatures and values"
        table.update(read)


def files_of(values: Mapping[str, Any]) -> tuple[tuple[KeyPath, str], ...]:
    """Return key and name of the files that `read_files` reads."""
    return tuple(
        ((*path, "file"), table["file"])
        for path, table in _with_a_file(values)
        if isinstance(table["file"], str)
    )


def _with_a_file(values: Mapping[str, Any]) -> Iterator[tuple[KeyPath, dict[str, Any]]]:
    for path, solid in _tables_of(values, ("solids",)):
        for where, each in ((path, solid), *_tables_of(solid, (*path, "constituent"))):
            for key in TABLES:
                table = each.get(key)
                if isinstance(table, dict) and "file" in table:
                    yield (*where, key), table


def _tables_of(
    values: Mapping[str, Any], path: KeyPath
) -> Iterator[tuple[KeyPath, dict[str, Any]]]:
    """Yield the tables in a table, whose name ends the path."""
    found = values.get(str(path[-1]))
    for name, table in found.items() if isinstance(found, dict) else ():
        if isinstance(table, dict):
            yield (*path, name), table


def _columns(
    kind: type[PropertyTable], table: Mapping[str, Any], origin: Origin
) -> dict[str, list[float]]:
    """Return temperatures and values of a file.

    Raises
    ------
    SceneError : the file cannot be used
    """
    # with it the conversion of units
    from contbed.scene.data_table import read_table

    found = read_table(origin.base / table["file"])
    column = table.get("column") or found.name_in(kind.quantity)
    temperatures = found.column(found.name_in("K"), "K")
    return {
        "temperatures": temperatures.tolist(),
        "values": found.column(column, kind.quantity).tolist(),
    }
