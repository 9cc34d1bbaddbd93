"""Temperatures and pressures that no bed has: all that a scene gives, in whatever
model, are looked at in one place.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import cache
from itertools import chain
from pathlib import Path
from typing import Annotated, Any, get_args, get_origin

from pydantic.fields import FieldInfo

from contbed.scene.checking import Mistakes
from contbed.scene.quantities import Table
from contbed.scene.series import ProfileFile, TemperatureSeries
from contbed.scene.toml_lines import KeyPath
from contbed.scene.values import tables

# data of gases end here, and no solid of a bed is left: tungsten melts at 3695 K
HOTTEST = 3700.0
# nitrogen boils at 77.4 K; a number of degC read as kelvin often lies below
COLDEST = 77.0
# vacuum dryers and fluidized beds in vacuum have 1 kPa, low-density polyethylene 3e8 Pa;
# a number of bar or MPa read as Pa lies below
LOWEST, HIGHEST = 1e3, 5e8
# differences of temperature, and ranges of data
_NO_STATES = ("T_range", "tolerance", "step", "interval", "activation")


def states_are_of_a_bed(parts: Mapping[str, Any], base: Path) -> Mistakes:
    """Look for temperatures and pressures that point to a wrong unit or a wrong number;
    files lie in the folder `base`.
    """
    for path, value in numbers_of("Pa", parts, ()):
        if path[0] == "boundary":  # over that of the surroundings
            continue
        if value < LOWEST:
            text = f"below {LOWEST:g} Pa a gas is too thin for a bed"
        elif value > HIGHEST:
            text = f"above {HIGHEST:g} Pa no vessel holds a bed"
        else:
            continue
        yield path, f"{value:.6g} Pa: {text}; is the unit right?"
    for path, value in chain(numbers_of("K", parts, ()), _of_files(parts, base)):
        if value > HOTTEST:
            text = f"above {HOTTEST:g} K no solid of a bed is left"
        elif value < COLDEST:
            text = f"below {COLDEST:g} K air is liquid"
        else:
            continue
        yield path, f"{value:.6g} K: {text}; is the unit right?"


def numbers_of(unit: str, part: Any, path: KeyPath) -> Iterator[tuple[KeyPath, float]]:
    """Yield all temperatures, "K", or pressures, "Pa", below a table with their paths."""
    for where, table in tables(part, path):
        for name in _keys_in(unit, type(table)):
            value = getattr(table, name)
            for number in value if isinstance(value, tuple) else (value,):
                if isinstance(number, int | float):
                    yield (*where, name), float(number)


def _of_files(parts: Any, base: Path) -> Iterator[tuple[KeyPath, float]]:
    """Yield the lowest and highest temperature [K] of each file, which the checks have
    read.
    """
    for path, part in tables(parts):
        if isinstance(part, ProfileFile):
            _, values = part.samples(base, "")
        elif isinstance(part, TemperatureSeries) and part.file is not None:
            values = part.samples(base).values
        else:
            continue
        for number in sorted({float(values.min()), float(values.max())}):
            yield (*path, "file"), number


@cache
def _keys_in(unit: str, model: type[Table]) -> tuple[str, ...]:
    """Return the keys of a table that are temperatures, or pressures of a fluid."""
    fields = model.model_fields.items()
    if unit == "Pa":
        return tuple(name for name, _ in fields if name == "pressure")
    return tuple(
        name
        for name, field in fields
        if not any(word in name for word in _NO_STATES)
        and (_in_kelvin(field.metadata, field) or _any_in_kelvin(field.annotation))
    )


def _in_kelvin(metadata: Any, field: Any = None) -> bool:
    entries = [*metadata, field]
    extras = [
        entry.json_schema_extra for entry in entries if isinstance(entry, FieldInfo)
    ]
    return any(isinstance(each, dict) and each.get("unit") == "K" for each in extras)


def _any_in_kelvin(annotation: Any) -> bool:
    """Return whether any alternative of a type is a temperature."""
    if get_origin(annotation) is Annotated and _in_kelvin(annotation.__metadata__):
        return True
    return any(_any_in_kelvin(each) for each in get_args(annotation))
