"""Maps of cell values over a plane, and of nodal fields over the middle plane of a
box.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from contbed.arrays import Array
from contbed.fields import FIELDS
from contbed.output.nearest import Nearest
from contbed.output.plots import plain_ticks, styled_figure

HEIGHT = 3.6  # inches of a map, unless it lies
WIDE = 1.6  # ratio of width to height from which maps stand one below another
POINTS = 120  # of a plane through a box along its longer side
COLOURS = {"K": "inferno", "1": "cividis", "m/s": "viridis"}


def cell_maps(
    path: Path,
    corners: Array,
    values: Mapping[str, Array],
    axes: tuple[str, str],
    title: str = "",
) -> None:
    """Draw cell values over a plane, one map for each field.

    Parameters
    ----------
    path : PNG file
    corners : of the cells in the plane (cells, corners, 2) [m], in order around each
    values : (cells,) by the names of fields
    axes : names of the coordinates
    title : text above the picture
    """
    from matplotlib.collections import PolyCollection

    low, high = corners.min(axis=(0, 1)), corners.max(axis=(0, 1))
    for panel, figure, name in _panels(
        path, list(values), float((high - low)[0] / (high - low)[1]), axes, title
    ):
        cells = PolyCollection(
            list(corners),
            array=values[name],
            cmap=_colours(name),
            edgecolor="face",
            linewidth=0.1,
        )
        panel.add_collection(cells)
        panel.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal")
        figure.colorbar(cells, ax=panel, shrink=0.9)


def slice_maps(
    path: Path, points: Array, values: Mapping[str, Array], title: str = ""
) -> None:
    """Draw nodal fields over the plane through the middle of the shortest side of a
    box, one map for each.

    A value in the plane is that of the nearest nodes, weighted with the inverse of
    their distance; what is further from all nodes than these are from each other is
    left white.

    Parameters
    ----------
    path : PNG file
    points : nodes (3, size) [m]
    values : (size,) by the names of fields
    title : text above the picture
    """
    extent = np.ptp(points, axis=1)
    normal = int(np.argmin(extent))
    first, second = (k for k in range(3) if k != normal)
    middle = 0.5 * (points[normal].min() + points[normal].max())
    longest = max(extent[first], extent[second])
    x, y = (
        points[k].min()
        + extent[k]
        * (np.arange(n := max(8, int(POINTS * extent[k] / longest))) + 0.5)
        / n
        for k in (first, second)
    )
    wanted = np.empty((3, len(y), len(x)))
    wanted[first], wanted[second], wanted[normal] = x, y[:, None], middle
    nearest = Nearest.of(points.T, wanted.reshape(3, -1).T)
    names = ("xyz"[first], "xyz"[second])
    # typical distance of neighbouring nodes, from their number in the volume
    spacing = float(np.cbrt(extent.prod() / points.shape[1]))
    outside = (nearest.distance[:, 0] > 3.0 * spacing).reshape(len(y), len(x))
    text = f"{title}   {'xyz'[normal]} = {middle:.4g} m".strip()
    for panel, figure, name in _panels(
        path, list(values), float(extent[first] / extent[second]), names, text
    ):
        shown = np.where(outside, np.nan, nearest(values[name]).reshape(len(y), len(x)))
        box = (
            points[first].min(),
            points[first].max(),
            points[second].min(),
            points[second].max(),
        )
        image = panel.imshow(
            shown, origin="lower", extent=box, cmap=_colours(name), aspect="equal"
        )
        figure.colorbar(image, ax=panel, shrink=0.9)


def _panels(
    path: Path, names: list[str], ratio: float, axes: tuple[str, str], title: str
) -> Any:
    """Yield the axes of each map with their figure and the name of the field; the
    figure is saved at the end.
    """
    lying = ratio > WIDE
    rows, columns = (len(names), 1) if lying else (1, len(names))
    high = 8.0 / ratio + 0.5 if lying else HEIGHT
    width = 8.0 if lying else max(4.0, columns * (max(0.9, HEIGHT * ratio) + 1.3))
    with styled_figure(path, 0.7 + rows * high, title, width=width) as figure:
        panels = figure.subplots(
            rows, columns, squeeze=False, sharex=True, sharey=True
        ).ravel()
        for panel, name in zip(panels, names, strict=True):
            panel.set_title(FIELDS[name].label, fontsize=10)
            yield panel, figure, name
            panel.locator_params(axis="y", nbins=5)
            # numbers of a narrow map would collide
            panel.locator_params(axis="x", nbins=4 if ratio > 0.6 else 1)
            plain_ticks(panel)
        for panel in panels[-columns:]:
            panel.set_xlabel(FIELDS[axes[0]].label)
        for panel in panels[::columns]:
            panel.set_ylabel(FIELDS[axes[1]].label)


def _colours(name: str) -> str:
    return COLOURS.get(FIELDS[name].unit, "viridis")
