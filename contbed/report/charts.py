"""Charts of a report as data for plotly: curves by unit, pictures of fields, and
costs.
"""

from __future__ import annotations

from base64 import b64encode
from collections.abc import Sequence
from typing import Any

import numpy as np

from contbed import fields as quantities
from contbed.arrays import Array
from contbed.fields import behind, labelled, name_of, unit_in
from contbed.output.colours import COLOURS
from contbed.output.tables import axis_of, evenly
from contbed.report.fields import Cloud, Pictures
from contbed.report.read import Run

Chart = dict[str, Any]

DASHES = ("solid", "dash", "dot", "dashdot")
LEVELS = 65534  # of values in a picture, whose error is a part in 65534 of their span
MAX_POINTS = 1000  # of a curve
MARGINS = 100  # height of axis and margins of a picture [pixels]
# width of a picture [pixels] in half of a page, without axes and scale of colours
PICTURE = 360


def packed(values: Array) -> Chart:
    """Return values as 16-bit numbers between the lowest and the highest, 65535
    where there is none, in base64.
    """
    finite = values[np.isfinite(values)]
    low, high = (
        (float(finite.min()), float(finite.max())) if finite.size else (0.0, 0.0)
    )
    scaled = np.full(values.shape, 65535, dtype="<u2")
    there = np.isfinite(values)
    scaled[there] = np.round(
        (values[there] - low) / (high - low or 1.0) * LEVELS
    ).astype("<u2")
    return {
        "low": low,
        "high": high,
        "shape": list(values.shape),
        "data": b64encode(scaled.tobytes()).decode("ascii"),
    }


def curves(runs: Sequence[Run]) -> list[Chart]:
    """Return one chart for each unit of each table, with the curves of all runs that
    have it.

    In a table of several times the chart has a slider: one frame for each time of the
    first run.
    """
    found: list[Chart] = []
    for table in dict.fromkeys(name for run in runs for name in run.tables):
        columns = dict.fromkeys(
            header for run in runs for header in run.tables.get(table, {})
        )
        axis, moving = axis_of(
            [run.tables[table] for run in runs if table in run.tables]
        )
        if axis is None:
            continue
        for unit in dict.fromkeys(
            unit_in(header) for header in columns if header not in (axis, moving)
        ):
            headers = [
                header
                for header in columns
                if unit_in(header) == unit and header not in (axis, moving)
            ]
            found.append(_chart(runs, table, axis, moving, headers, unit))
    return found


def _chart(
    runs: Sequence[Run],
    table: str,
    axis: str,
    moving: str | None,
    headers: list[str],
    unit: str,
) -> Chart:
    """Return the chart of the columns of one unit."""
    moves = [
        run
        for run in runs
        if moving in (columns := run.tables.get(table, {}))
        and set(headers) & set(columns)
    ]
    times = sorted({float(t) for run in moves for t in run.tables[table][moving or ""]})
    frames: list[list[Chart]] = []
    instants: list[float | None] = [*times] or [None]
    for time in instants:
        traces = []
        for k, run in enumerate(runs):
            columns = run.tables.get(table, {})
            if axis not in columns:
                continue
            here = _nearest(columns, moving, time)
            for n, header in enumerate(name for name in headers if name in columns):
                name = name_of(header)
                label = name if len(runs) == 1 else f"{run.name}: {name}"
                colour = COLOURS[(n if len(runs) == 1 else k) % len(COLOURS)]
                traces.append(
                    {
                        "type": "scatter",
                        "mode": "lines",
                        "name": label,
                        "x": _thinned(columns[axis][here]),
                        "y": _thinned(columns[header][here]),
                        "line": {
                            "color": colour,
                            "dash": DASHES[(0 if len(runs) == 1 else n) % len(DASHES)],
                        },
                    }
                )
        frames.append(traces)
    what = ", ".join(dict.fromkeys(map(name_of, headers[:4])))
    title = f"{what}{', ...' if len(headers) > 4 else ''}"
    chart: Chart = {
        "kind": "curves",
        "title": title if table == "profiles" else f"{table}: {title}",
        "data": frames[-1],
        "layout": {
            "xaxis": {"title": {"text": axis.replace(" [1]", "")}},
            "yaxis": {
                "title": {
                    "text": labelled(name_of(headers[0]), unit)
                    if len(headers) == 1
                    else behind(unit).strip()
                }
            },
        },
    }
    lines = [[[trace["x"], trace["y"]] for trace in traces] for traces in frames]
    if any(frame != lines[0] for frame in lines):
        chart["times"] = times
        chart["lines"] = lines
        values = np.concatenate(
            [
                np.asarray(trace["y"], dtype=float)
                for traces in frames
                for trace in traces
            ]
        )
        low, high = float(np.nanmin(values)), float(np.nanmax(values))
        margin = 0.05 * (high - low) or 0.05 * abs(high) or 1.0
        chart["layout"]["yaxis"]["range"] = [low - margin, high + margin]
    return chart


def _nearest(columns: dict[str, Array], moving: str | None, time: float | None) -> Any:
    """Return the rows of the last time that is not after `time`, the first one
    before that.
    """
    if moving is None or time is None or moving not in columns:
        return slice(None)
    times = np.unique(columns[moving])
    reached = times[times <= time * (1.0 + 1e-12)]
    return columns[moving] == (reached[-1] if reached.size else times[0])


def _thinned(values: Array) -> list[float | None]:
    """Return a curve of at most `MAX_POINTS` points, its ends included."""
    return _short(values[evenly(len(values), MAX_POINTS)])


def _short(values: Array) -> list[float | None]:
    """Return numbers of six digits; None for what is none, which JSON lacks."""
    return [float(f"{value:.6g}") if np.isfinite(value) else None for value in values]


def picture(run: Run, item: Pictures | Cloud, several: bool) -> Chart:
    """Return the chart of a field over a plane, or of particles from the side, with
    a slider over the times.
    """
    entry = quantities.field(item.field.strip("|"))
    unit = "" if entry is None or entry.unit == "1" else f" [{entry.unit}]"
    title = f"{run.name}: {item.field}{unit}" if several else f"{item.field}{unit}"
    text = f"{title} ({item.remark})" if item.remark else title
    if isinstance(item, Cloud):
        return _cloud(item, text, unit)
    trace = {
        "type": "heatmap",
        "x": _short(item.x),
        "y": _short(item.y),
        "colorscale": "Viridis",
        "colorbar": {"title": {"text": unit.strip(" []")}},
        "hovertemplate": f"{item.axes[0]} = %{{x:.4g}} m<br>{item.axes[1]} = "
        f"%{{y:.4g}} m<br>%{{z:.5g}}<extra></extra>",
    }
    steady = bool((np.nan_to_num(item.frames) == np.nan_to_num(item.frames[:1])).all())
    return {
        "kind": "field",
        "title": text,
        "data": [trace],
        "layout": _plane(item.axes),
        "height": _height(float(np.ptp(item.y)) / float(np.ptp(item.x))),
        "times": [] if steady else list(item.times),
        "frames": packed(item.frames[-1:] if steady else item.frames),
    }


def _cloud(item: Cloud, title: str, unit: str) -> Chart:
    """Return the chart of particles, drawn in their size as far as the width of the
    page allows.
    """
    (left, right), (bottom, top) = item.box()
    ratio = (top - bottom) / (right - left)
    height = _height(ratio)
    # pixels/m
    scale = min(PICTURE / (right - left), (height - MARGINS) / (top - bottom))
    points = [[x, z, value, 2 * scale * radius] for x, z, radius, value in item.frames]
    values = np.concatenate([frame[2] for frame in points])
    x, z, value, size = (_short(part) for part in points[-1])
    marker = {
        "color": value,
        "cmin": float(values.min()),
        "cmax": float(values.max()),
        "size": size,
    }
    marker |= {
        "colorscale": "Viridis",
        "colorbar": {"title": {"text": unit.strip(" []")}},
        "opacity": 1.0,
    }
    trace = {"type": "scattergl", "mode": "markers", "x": x, "y": z, "marker": marker}
    layout = _plane(("x", "z"))
    layout["xaxis"] |= {"range": [left, right]}
    layout["yaxis"] |= {"range": [bottom, top]}
    chart: Chart = {
        "kind": "cloud",
        "title": title,
        "data": [trace],
        "layout": layout,
        "height": height,
    }
    if len(item.times) > 1:
        chart |= {
            "times": list(item.times),
            "points": [[_short(part) for part in frame] for frame in points],
        }
    return chart


def _height(ratio: float) -> int:
    """Return the height [pixels] of a picture whose height over width is `ratio`."""
    return int(min(max(PICTURE * ratio, 110.0), 520.0)) + MARGINS


def _plane(axes: tuple[str, str]) -> Chart:
    return {
        "xaxis": {"title": {"text": f"{axes[0]} [m]"}, "constrain": "domain"},
        "yaxis": {
            "title": {"text": f"{axes[1]} [m]"},
            "scaleanchor": "x",
            "constrain": "domain",
        },
    }


def cost(runs: Sequence[Run]) -> Chart:
    """Return the wall time by phase as bars."""
    data = []
    for k, run in enumerate(runs):
        timings = {
            phase: value
            for phase, value in run.summary.get("timings", {}).items()
            if phase != "total"
        }
        data.append(
            {
                "type": "bar",
                "orientation": "h",
                "name": run.name,
                "y": list(timings),
                "x": [float(f"{value:.3g}") for value in timings.values()],
                "marker": {"color": COLOURS[k % len(COLOURS)]},
            }
        )
    layout = {
        "xaxis": {"title": {"text": "wall time [s]"}},
        "yaxis": {"autorange": "reversed", "automargin": True},
    }
    return {
        "kind": "bars",
        "title": "Wall time by phase",
        "data": data,
        "layout": layout,
    }
