"""Results that several models of one reactor have, under one name for all of them.

A model reports a quantity under its own name, as a named result or as a column along
the bed. COMMON lists where each quantity may stand; the first that a run has counts.
NAME is a gas, which then has a row of its own, or in a column the solid phase.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.integrate import trapezoid

from contbed.arrays import Array

ALONG = ("x [m]", "y [m]", "z [m]", "r [m]", "height [m]")  # coordinates along the bed
TIME = "t [s]"
NAME = "NAME"


@dataclass(frozen=True)
class Common:
    """A quantity that several models report.

    results : its named results
    columns : columns along the bed, whose mean counts where there is no named result
    in_time : a mean over the time of a run
    """

    name: str
    unit: str
    meaning: str
    results: tuple[str, ...] = ()
    columns: tuple[str, ...] = ()
    in_time: bool = False


COMMON = (
    Common(
        "pressure_drop",
        "Pa",
        "pressure of the gas below the bed over that above it",
        ("pressure_drop_Pa", "pressure_drop_mean [Pa]", "pressure_drop [Pa]"),
    ),
    Common(
        "T_gas_out",
        "K",
        "temperature of the gas that leaves, in a bubbling bed of its emulsion",
        ("T_fluid_out_K", "T_emulsion_top_K"),
    ),
    Common(
        "T_gas_mean",
        "K",
        "mean temperature of the gas along the bed",
        ("T_fluid_mean_K", "T_gas_mean [K]"),
        ("T_fluid [K]", "T_emulsion [K]", "T_gas [K]"),
    ),
    Common(
        "T_solids_mean",
        "K",
        "mean temperature of the solids along the bed",
        ("T_solid_mean_K", "T_solid_mean [K]"),
        ("T_solid [K]", "T_NAME [K]"),
    ),
    Common(
        "heat_NAME",
        "W",
        "heat into the bed through a boundary, in the mean",
        ("heat_NAME_W",),
        in_time=True,
    ),
    Common("bed_height", "m", "height of the bed", ("bed_height_m", "height [m]")),
    Common(
        "x_NAME_out",
        "1",
        "mole fraction of a gas in what leaves",
        ("x_NAME_out", "x_NAME_wet"),
    ),
    Common("conversion_NAME", "1", "converted share of a gas", ("conversion_NAME",)),
)


@dataclass(frozen=True)
class Value:
    """What a run found for a common quantity; a mean over time since `since` [s], None
    for others.
    """

    value: float
    unit: str
    meaning: str
    since: float | None = None


def common_results(
    qoi: Mapping[str, Any],
    tables: Mapping[str, Mapping[str, Any]],
    solids: Sequence[str],
    units: Mapping[str, str] | None = None,
    since: float | None = None,
) -> dict[str, Value]:
    """Return the results of a run that other models may have too, by common name.

    Parameters
    ----------
    qoi : named results
    tables : columns by header, of "profiles" and of further tables
    solids : names of the solid phases
    units : of named results, where that of the quantity is another one
    since : start of means over time [s]; None for a steady run
    """
    found: dict[str, Value] = {}
    for quantity in COMMON:
        keys = _named(quantity, qoi)
        values = {name: float(qoi[key]) for name, key in keys.items()}
        for name, value in (values or _means(quantity, tables, solids)).items():
            unit = (units or {}).get(keys.get(name, ""), quantity.unit)
            start = since if quantity.in_time else None
            found[name] = Value(value, unit, quantity.meaning, start)
    return found


def _named(quantity: Common, qoi: Mapping[str, Any]) -> dict[str, str]:
    """Return the names of the results of a quantity by common name."""
    found: dict[str, str] = {}
    for pattern in quantity.results:
        form = re.compile(re.escape(pattern).replace(NAME, "(.+)"))
        for key, value in qoi.items():
            match = form.fullmatch(key)
            if match is None or not isinstance(value, int | float):
                continue
            name = quantity.name.replace(NAME, match.group(match.lastindex or 0))
            found.setdefault(name, key)
    return found


def _means(
    quantity: Common,
    tables: Mapping[str, Mapping[str, Any]],
    solids: Sequence[str],
) -> dict[str, float]:
    """Return the mean of the first column of a quantity that a table along the bed
    has.
    """
    headers = [
        column.replace(NAME, solid)
        for column in quantity.columns
        for solid in (solids if NAME in column else ("",))
    ]
    for table in tables.values():
        along = next((header for header in ALONG if header in table), None)
        for header in headers:
            if along is not None and header in table:
                last = _rows_at_the_end(table)
                x = np.asarray(table[along], dtype=float)[last]
                values = np.asarray(table[header], dtype=float)[last]
                return {quantity.name: _mean(x, values)}
    return {}


def _rows_at_the_end(table: Mapping[str, Any]) -> Any:
    """Return which rows of a table are those of its last time, all without times."""
    if TIME not in table:
        return slice(None)
    times = np.asarray(table[TIME], dtype=float)
    return times == times.max()


def _mean(x: Array, y: Array) -> float:
    """Return the mean of y over x; points without a value are left out."""
    known = np.isfinite(x) & np.isfinite(y)
    order = np.argsort(x[known], kind="stable")
    x, y = x[known][order], y[known][order]
    if x.size < 2 or x[-1] <= x[0]:
        return float(y.mean()) if y.size else float("nan")
    return float(trapezoid(y, x) / (x[-1] - x[0]))
