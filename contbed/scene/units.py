"""Conversion of unit strings: "3 mm" becomes 0.003. pint is imported only when a
unit string occurs.
"""

from __future__ import annotations

import re
from functools import cache
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from pint import Unit, UnitRegistry

QUANTITIES = {
    "1": "plain number",
    "m": "length",
    "m**2": "permeability",
    "K": "temperature",
    "s": "time",
    "Pa": "pressure",
    "m/s": "velocity",
    "W/m/K": "conductivity",
    "W/m**2/K": "heat transfer coefficient",
    "W/m**2": "heat flux",
    "W/m**3": "heat source",
    "kg/m**3": "density",
    "J/kg/K": "heat capacity",
    "Pa*s": "viscosity",
}
_QUANTITY = re.compile(
    r"\s*([+-]?(?:\d+\.?\d*|\.\d+)(?:[eE][+-]?\d+)?)\s*(.*?)\s*", re.DOTALL
)
_DECIMAL_COMMA = re.compile(r"\s*[+-]?\d+,\d")
# What may stand in a unit; anything else never reaches pint's parser.
_LETTERS = r"A-Za-z%\u00b0\u00b5\u03bc\u00b2\u00b3\u2103"
_UNIT = re.compile(rf"[{_LETTERS}][{_LETTERS}0-9_ .*/^()+-]{{0,60}}")

# Powers of numbers and long exponents could keep the parser busy for hours.
_LARGE_POWER = re.compile(r"\d\s*(?:\*\*|\^)|(?<![.\d])\d{3}|\)\s*(?:\*\*|\^)")

_GAUGE = "; pressures are absolute: add that of the air and write {}"
_ABSOLUTE = "; pressures are absolute: write {}"
_FRACTION = re.compile(r"\s*(?:(\d+)\s+)?(\d+)\s*/\s*([1-9]\d*)(\s*[A-Za-z].*)")
# 1000 kg to some, 2000 lb to others
_TON = re.compile(r"(?<![A-Za-z_])(?:k|M|G|kilo|mega)?tons?(?![A-Za-z_])")
_HINTS = {
    "barg": _GAUGE.format("bar"),
    "psig": _GAUGE.format("psi"),
    "bara": _ABSOLUTE.format("bar"),
    "psia": _ABSOLUTE.format("psi"),
}


def to_si(text: str, unit: str) -> float:
    """Convert `text`, a quantity like "3 mm", to the SI unit `unit`; ValueError says
    what is wrong.

    >>> to_si("100 degC", "K")
    373.15
    >>> to_si("90 1/min", "1/s"), to_si("90/min", "1/s")
    (1.5, 1.5)
    >>> round(to_si("2 lbmol/h", "mol/s"), 6)
    0.251996
    """
    expected = f"expected a {QUANTITIES.get(unit, 'quantity')}"
    if unit != "1":
        expected += f" like '{unit}'"
    shown = text if len(text) <= 60 else text[:57] + "..."
    match = _QUANTITY.fullmatch(text)
    if not match or _DECIMAL_COMMA.match(text):
        hint = "; the decimal sign is a point" if _DECIMAL_COMMA.match(text) else ""
        raise ValueError(f"{expected}, found '{shown}'{hint}")
    number, name = float(match[1]), match[2]
    if not name:
        if unit == "1":
            return number
        raise ValueError(
            f"{expected}, found '{shown}' without a unit; write {match[1]} for SI, or "
            f"'{match[1]} {unit}'"
        )
    name = f"1{name}" if name.startswith("/") else name
    found = _parse(name) if _readable(name) else None
    if found is None:
        if fraction := _FRACTION.fullmatch(text):
            whole, over, under, rest = fraction.groups()
            decimal = int(whole or 0) + int(over) / int(under)
            raise ValueError(f"'{shown}' is a fraction; write {decimal:g}{rest}")
        hint = _HINTS.get(name, "")
        if _TON.search(name):
            hint = "; write t for 1000 kg, short_ton for 2000 lb"
        raise ValueError(f"unknown unit '{name[:60]}'{hint}; {expected}")
    registry = _registry()
    wanted = _parse("" if unit == "1" else unit)
    assert wanted is not None, "units of contbed's own"
    if found.dimensionality != wanted.dimensionality:
        celsius = (
            "; degrees Celsius are 'degC'" if unit == "K" and name in {"C", "c"} else ""
        )
        raise ValueError(f"{expected}, found '{shown}'{celsius}")
    try:
        return float(registry.Quantity(number, found).to(wanted).magnitude)
    except OverflowError:
        raise ValueError(f"'{shown}' is too large") from None


@cache
def factor_and_offset(name: str, unit: str) -> tuple[float, float] | None:
    """Return (a, b) so that a value x in the unit `name` is a x + b in the SI unit
    `unit`.

    None if `name` is unknown or measures something else.

    >>> factor_and_offset("mm", "m")
    (0.001, 0.0)
    """
    if name == unit:
        return 1.0, 0.0
    try:
        zero = to_si(f"0 {name}" if name != "1" else "0", unit)
        thousand = to_si(f"1000 {name}" if name != "1" else "1000", unit)
    except ValueError:
        return None
    return (thousand - zero) / 1000.0, zero


@cache
def _registry() -> UnitRegistry[float]:
    from pint import UnitRegistry

    registry: UnitRegistry[float] = UnitRegistry()
    registry.define("pound_mole = 453.59237 * mole = lbmol")
    return registry


def _parse(name: str) -> Unit | None:
    """Return pint's unit of a name, or None; "kg/m3" and "W m-2" are read like
    "kg/m**3" and "W m**-2".
    """
    if _TON.search(name):
        return None
    for spelling in (name, re.sub(r"([A-Za-z])(-?\d)", r"\1**\2", name)):
        try:
            return _registry().parse_units(spelling)
        except Exception:
            continue
    return None


def _readable(name: str) -> bool:
    """Return whether the parser may read the name of a unit."""
    return bool(
        _UNIT.fullmatch(name.removeprefix("1/")) and not _LARGE_POWER.search(name)
    )


def is_unit(name: str) -> bool:
    """Return whether this is a unit of anything.

    >>> is_unit("lbmol/lb/s"), is_unit("foo/s"), is_unit("m**1000")
    (True, False, False)
    """
    return _readable(name) and _parse(name) is not None


def number_and_unit(text: str) -> tuple[float, str]:
    """Split a quantity with any unit, "49 kJ/mol"; ValueError says what is wrong.

    >>> number_and_unit("3erg/s")
    (3.0, 'erg/s')
    """
    match = _QUANTITY.fullmatch(text)
    name = "" if match is None else match[2]
    if not match or not _readable(name):
        raise ValueError(
            f"expected a number with a unit like '49 kJ/mol', found '{text[:60]}'"
        )
    return float(match[1]), name


def base_value(text: str) -> float:
    """Convert a quantity with any unit, "49 kJ/mol", to SI base units; ValueError says
    what is wrong.

    >>> base_value("2 1/ms")
    2000.0
    """
    number, name = number_and_unit(text)
    found = _parse(name)
    if found is None:
        raise ValueError(f"unknown unit '{name}'")
    return float(_registry().Quantity(number, found).to_base_units().magnitude)


def exponents(unit: str) -> dict[str, float]:
    """Return the exponents of the SI base units in a unit; empty for a plain number.

    >>> exponents("W/m")
    {'kilogram': 1.0, 'meter': 1.0, 'second': -3.0}
    """
    found = _parse("" if unit == "1" else unit)
    if found is None:
        raise ValueError(f"unknown unit '{unit}'")
    base = _registry().Quantity(1.0, found).to_base_units().units
    return {str(name): float(str(power)) for name, power in sorted(base._units.items())}


def counts_per_time(unit: str) -> bool:
    """Return whether a unit has a time or a power among its factors; that in an energy
    or a pressure is none of these.

    >>> [counts_per_time(unit) for unit in ("mol/kg/h", "W/m2", "mol/kg", "kJ/mol", "1/Pa")]
    [True, True, False, False, False]
    """
    found, registry = _parse(unit), _registry()
    if found is None:
        return False
    timely = [registry.parse_units(each).dimensionality for each in ("s", "Hz", "W")]
    return any(
        registry.parse_units(name).dimensionality in timely
        for name in found._units  # names of its factors
    )


def unit_with(powers: dict[str, float]) -> str:
    """Return a unit with these exponents of the base units, a short one where there is
    one.

    >>> unit_with({"kilogram": 1.0, "meter": 1.0, "second": -3.0}), unit_with({})
    ('W/m', '1')
    """
    if not powers:
        return "1"
    for name in (*QUANTITIES, "kg", "W", "J", "J/mol", "kg/s", "W/m", "J/kg", "m**3"):
        if exponents(name) == powers:
            return name
    registry = _registry()
    product = registry.Quantity(1.0, "")
    for base, power in powers.items():
        product = product * registry.Quantity(1.0, base) ** power
    return f"{product.units:~C}"
