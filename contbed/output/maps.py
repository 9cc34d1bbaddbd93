"""Maps of a plane bed, of cell values over a plane, and of nodal fields over the
middle plane of a box.
"""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from contbed.arrays import Array
from contbed.fem.elements import Space
from contbed.fields import FIELDS
from contbed.output.curves import groups_of, profile_plot, transient_plot
from contbed.output.nearest import Nearest
from contbed.output.plots import WIDTH, shown_range, styled_figure
from contbed.output.vtu import TRIANGLES, at_nodes

if TYPE_CHECKING:
    import skfem

HIGHEST = 7.0  # inches of a map
WIDE = 1.6  # ratio of width to height from which maps stand one below another
FLAT = 12.0  # a map is never flatter than this
LONG = 2.5  # widths of a plane bed from which it lies down
LEVELS = 257  # shades
POINTS = 120  # of a plane through a box along its longer side
COLOURS = {"K": "inferno", "1": "cividis", "m/s": "viridis", "Pa": "cividis"}
# cells of second order by the number of their corners
QUADRATIC = {3: "triangle6", 4: "quad9"}


def field_plot(
    path: Path | str,
    mesh: skfem.Mesh,
    nodal: Mapping[str, tuple[Space, Array]],
    axisymmetric: bool = False,
    title: str = "",
) -> None:
    """Plot colour maps over a plane or axisymmetric bed: both temperatures and the
    speed, where present.

    Parameters
    ----------
    path : PNG file
    mesh : 2-D mesh of all spaces
    nodal : space and values, (size,) or (2, size), of each field
    axisymmetric : the coordinates are (r, z)
    title : text above the picture
    """
    from matplotlib.ticker import MaxNLocator

    if mesh.dim() != 2:
        raise ValueError(f"{path}: maps need a 2-D mesh, not {mesh.dim()}-D")
    quadratic = Space(mesh, 2)
    maps = {
        name: at_nodes(space, values, quadratic)
        for name, (space, values) in nodal.items()
    }
    if "u" in maps:
        maps["speed"] = np.linalg.norm(np.atleast_2d(maps.pop("u")), axis=0)
    groups = groups_of([name for name in maps if name != "speed"])
    names = [name for group in groups for name in group] + ["speed"] * ("speed" in maps)
    # temperatures of both phases share a scale
    same = groups[0] if groups else ("speed",)
    corners = TRIANGLES[QUADRATIC[quadratic.element.nvertices]]
    triangles = np.vstack([quadratic.dofs[list(three)].T for three in corners])
    points, labels = quadratic.points, ("r", "z") if axisymmetric else ("x", "y")
    extent = np.ptp(points, axis=1)
    if extent[1] > LONG * extent[0]:
        points, labels, extent = points[::-1], labels[::-1], extent[::-1]
    ratio = float(extent[0] / extent[1])
    if ratio > FLAT:
        title += f"   ({labels[1]} drawn {ratio / FLAT:.2g} times larger)"
    for panel, figure, name in _panels(path, names, ratio, labels, title):
        alike = same if name in same else (name,)
        levels = np.linspace(*shown_range([maps[each] for each in alike]), LEVELS)
        colours = panel.tricontourf(
            *points, triangles, maps[name], levels, cmap=_colours(name)
        )
        panel.set_aspect("equal" if ratio <= FLAT else "auto")
        figure.colorbar(colours, ax=panel, shrink=0.9, ticks=MaxNLocator(5))


def plot_profiles_and_fields(result: Any, folder: Path) -> None:
    """Write profiles.png, over time for a transient, and fields.png of a plane mesh,
    into `folder`.
    """
    scene, mesh, columns = result.plan.scene, result.plan.mesh, result.profiles
    plot = transient_plot if "t [s]" in columns else profile_plot
    plot(folder / "profiles.png", columns, next(iter(columns)), scene.title)
    if result.nodal and mesh.skfem.dim() == 2:
        file, axisymmetric = folder / "fields.png", mesh.axisymmetric
        field_plot(file, mesh.skfem, result.nodal, axisymmetric, scene.title)


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
    path: Path | str,
    names: list[str],
    ratio: float,
    axes: tuple[str, str],
    title: str,
) -> Any:
    """Yield the axes of each map with their figure and the name of the field; the
    figure is saved at the end.
    """
    rows, columns = (len(names), 1) if ratio > WIDE else (1, len(names))
    wide = WIDTH / columns - 1.3
    high = min(max(wide / ratio, wide / FLAT), HIGHEST) + 0.5
    with styled_figure(path, 0.7 + rows * high, title) as figure:
        panels = figure.subplots(
            rows, columns, squeeze=False, sharex=True, sharey=True
        ).ravel()
        for panel, name in zip(panels, names, strict=True):
            panel.set_title(FIELDS[name].label, fontsize=10)
            yield panel, figure, name
            panel.locator_params(axis="y", nbins=5)
            # numbers of a narrow map would collide
            panel.locator_params(axis="x", nbins=4 if ratio > 0.6 else 1)
        for panel in panels[-columns:]:
            panel.set_xlabel(FIELDS[axes[0]].label)
        for panel in panels[::columns]:
            panel.set_ylabel(FIELDS[axes[1]].label)


def _colours(name: str) -> str:
    return COLOURS.get(FIELDS[name].unit, "viridis")
