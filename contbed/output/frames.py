"""A result as xarray and pandas, as a table of a notebook, and as a figure; the
libraries are imported when needed.
"""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Mapping
from html import escape
from importlib import import_module
from io import BytesIO
from typing import TYPE_CHECKING, Any

import numpy as np

from contbed import fields
from contbed.errors import ContbedError
from contbed.output.curves import Curve, draw, over_times
from contbed.output.summary import number_text
from contbed.output.tables import axis_of

if TYPE_CHECKING:
    import pandas
    import xarray

Result = Any  # a `contbed.result.Result`, which is above
DASHES = ("-", "--", ":", "-.")  # of columns of one unit at several times


def _library(name: str) -> Any:
    """Import a library of the extra `notebook`."""
    try:
        return import_module(name)
    except ImportError as error:
        raise ContbedError(
            f"{name} is not installed: pip install 'contbed[notebook]'"
        ) from error


def dataset(result: Result, table: str = "profiles") -> xarray.Dataset:
    """Return a table of a result as an xarray Dataset with units and meanings in
    `attrs`.

    Parameters
    ----------
    result : of a run
    table : "profiles", a further table of the result, or "fields" for the nodal fields

    Returns
    -------
    along the coordinate of the table, and over `t` where it has several times; fields along `node`

    Raises
    ------
    ContbedError : xarray is not installed, or the result has no such table
    """
    xr = _library("xarray")
    if table == "fields":
        fields_found: xarray.Dataset = _fields(result, xr)
        return fields_found
    found = columns_of(result, table)
    columns = {
        fields.name_of(name): np.asarray(column) for name, column in found.items()
    }
    units = {fields.name_of(name): fields.unit_in(name) for name in found}
    header, time = axis_of([found])
    axis = fields.name_of(str(header))
    dims: tuple[str, ...] = (axis,)
    shape: tuple[int, ...] = (-1,)
    coords = {axis: columns.pop(axis)}
    if time is not None:
        times = columns.pop("t")
        counts = np.unique(times, return_counts=True)
        # positions differ between the times: one row after the other
        if len(set(counts[1])) > 1:
            columns |= {axis: coords[axis], "t": times}
            coords, dims = {}, ("row",)
        else:
            coords = {"t": counts[0], axis: coords[axis][times == counts[0][0]]}
            dims, shape = ("t", axis), (len(counts[0]), -1)
    data = {
        name: (dims, column.reshape(shape) if len(dims) > 1 else column)
        for name, column in columns.items()
    }
    made: xarray.Dataset = xr.Dataset(
        data, coords, {"title": result.plan.scene.title, "status": result.status}
    )
    for name, variable in made.variables.items():
        variable.attrs |= _attributes(str(name), units.get(str(name), ""))
    return made


def frame(result: Result, table: str = "profiles") -> pandas.DataFrame:
    """Return a table of a result, or its named results as "results", as a pandas
    DataFrame; headers have units.

    Raises
    ------
    ContbedError : pandas is not installed, or the result has no such table
    """
    pd = _library("pandas")
    if table == "results":
        rows = [
            {"result": name, "value": value, "unit": unit, "meaning": meaning}
            for name, value, unit, meaning in named(result)
        ]
        results: pandas.DataFrame = pd.DataFrame(
            rows, columns=["result", "value", "unit", "meaning"]
        )
        return results.set_index("result")
    found: pandas.DataFrame = pd.DataFrame(
        {h: np.asarray(column) for h, column in columns_of(result, table).items()}
    )
    return found


def named(result: Result) -> list[tuple[str, Any, str, str]]:
    """Return the named results: name, value, unit, meaning."""
    found = []
    for key, value in result.qoi.items():
        entry = fields.result(key)
        unit = result.units.get(key) or fields.unit_of(key) or "1"
        found.append(
            (
                fields.name_of(key),
                value,
                "" if unit == "1" else unit,
                entry.description if entry else "",
            )
        )
    return found


def html(result: Result) -> str:
    """Return a result for a notebook: status, balances, warnings, named results and a
    small plot of its profiles.
    """
    rows = "".join(
        f"<tr><td><code>{escape(name)}</code></td><td>{escape(number_text(value, '.6g'))}</td><td>{escape(unit)}</td>"
        f"<td>{escape(meaning)}</td></tr>"
        for name, value, unit, meaning in named(result)
    )
    lines = [f"{escape(result.plan.scene.kind)}: {escape(result.status)}"]
    for name, balance in result.balances.items():
        lines.append(
            f"balance of {escape(name)} closes to {balance['relative_residual']:.2g}"
        )
    title = escape(result.plan.scene.title or "run of contbed")
    warnings = "".join(f"<li>{escape(text)}</li>" for text in result.warnings)
    head = "<tr><th>result</th><th>value</th><th>unit</th><th>meaning</th></tr>"
    listed = f"<ul>{warnings}</ul>" if warnings else ""
    text = f"<b>{title}</b><br>{'; '.join(lines)}{listed}"
    return f"{text}<table>{head}{rows}</table>{_small_plot(result)}"


def _small_plot(result: Result) -> str:
    """Return a plot of the temperatures of the profiles, else of their first columns,
    as an image in HTML; nothing without profiles.
    """
    axes = {"t", "x", "y", "z", "r"}
    names = [fields.name_of(header) for header in result.profiles]
    shown = [name for name in names if name not in axes]
    temperatures = [name for name in shown if name.startswith("T_")]
    if not shown:
        return ""
    made, picture = figure(result, *(temperatures or shown[:2])), BytesIO()
    made.savefig(picture, format="png", dpi=60)
    data = b64encode(picture.getvalue()).decode("ascii")
    return f'<img alt="profiles" src="data:image/png;base64,{data}">'


def figure(result: Result, *names: str, table: str = "profiles") -> Any:
    """Return a matplotlib figure of columns of a table along its coordinate, one panel
    for each unit.

    Parameters
    ----------
    result : of a run
    names : of columns without their unit, "T_fluid"; all if none are given
    table : which table

    Raises
    ------
    ContbedError : the result has no such table or column
    """
    import matplotlib
    from matplotlib.figure import Figure

    columns = columns_of(result, table)
    headers = {fields.name_of(header): header for header in columns}
    axis, time = axis_of([columns])
    wanted = names or tuple(
        name for name, header in headers.items() if header not in (axis, time)
    )
    if unknown := [name for name in wanted if name not in headers]:
        raise ContbedError(
            f"{table} has no column {unknown[0]!r}; it has {', '.join(headers)}"
        )
    x = np.asarray(columns[str(axis)])
    panels: dict[str, list[Curve]] = {}
    for name in wanted:
        unit, values = fields.unit_in(headers[name]), np.asarray(columns[headers[name]])
        here = [other for other in wanted if fields.unit_in(headers[other]) == unit]
        shown = name if len(here) == 1 else ""
        label = fields.labelled(shown, unit).strip()
        curves = [Curve(None if shown else name, x, values)]
        if time is not None:
            dash = DASHES[here.index(name) % len(DASHES)]
            t = np.asarray(columns[time])
            curves = list(over_times(x, values, t, name, linestyle=dash))
        panels.setdefault(label, []).extend(curves)
    with matplotlib.rc_context(
        {"axes.spines.top": False, "axes.spines.right": False, "legend.frameon": False}
    ):
        made = Figure(figsize=(7.0, 1.0 + 2.2 * len(panels)), layout="constrained")
        draw(made, panels, str(axis))
        made.suptitle(result.plan.scene.title, parse_math=False, wrap=True)
    return made


def columns_of(result: Result, table: str) -> Mapping[str, Any]:
    """Return the columns of a table by header.

    Raises
    ------
    ContbedError : the result has no such table
    """
    tables: dict[str, Mapping[str, Any]] = {
        "profiles": result.profiles,
        **result.tables,
    }
    if not tables.get(table):
        known = ", ".join(name for name, columns in tables.items() if columns) or "none"
        raise ContbedError(f"the result has no table {table!r}; it has: {known}")
    return tables[table]


def _fields(result: Result, xarray: Any) -> Any:
    """Return the nodal fields of the last time, each on the nodes of its own space."""
    if not result.nodal:
        raise ContbedError("the result has no fields")
    data, coords = {}, {}
    for name, (space, values) in result.nodal.items():
        points = np.asarray(space.points)
        dim = f"node_{points.shape[1]}"
        for k, point in enumerate(points):
            coords[f"{'xyz'[k]}_{points.shape[1]}"] = (dim, point)
        values = np.asarray(values)
        data[name] = (
            (("component", dim), values) if values.ndim > 1 else ((dim,), values)
        )
    made = xarray.Dataset(
        data, coords, {"title": result.plan.scene.title, "status": result.status}
    )
    for name, variable in made.variables.items():
        entry = fields.field(
            str(name).partition("_")[0] if str(name) in coords else str(name)
        )
        variable.attrs |= (
            {}
            if entry is None
            else {"units": entry.unit, "long_name": entry.description}
        )
    return made


def _attributes(name: str, unit: str) -> dict[str, str]:
    entry = fields.field(name)
    unit = unit or (entry.unit if entry else "")
    return ({"units": unit} if unit else {}) | (
        {"long_name": entry.description} if entry else {}
    )
