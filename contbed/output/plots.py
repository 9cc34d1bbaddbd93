"""Plots of a run: profiles along the bed, their history, or maps of a plane bed."""

from __future__ import annotations

import itertools
import os
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from contbed.arrays import Array
from contbed.fem.elements import Space
from contbed.fields import FIELDS, name_of
from contbed.output.files import atomic
from contbed.output.vtu import at_nodes

if TYPE_CHECKING:
    import skfem


WIDTH = 8.0  # inches, 1600 pixels
DPI = 200
# of PNG: lines on white get no smaller by more, which takes three times as long
_COMPRESSION = 2
# Okabe and Ito's colours, distinct for any colour vision
_COLOURS = {"fluid": "#0072B2", "solid": "#D55E00", "other": "#009E73"}
_PAIRS = (("T_fluid", "T_solid"), ("theta_fluid", "theta_solid"))
_MAPS = {"K": "inferno", "1": "inferno", "m/s": "viridis", "Pa": "cividis"}
_CURVES = 7  # most times in one picture
# a bed longer than this many widths lies down, with its maps one below another
_LONG = 2.5
_FLAT = 12.0  # a map is never flatter than this
_STACKED = 0.6  # maps of a smaller ratio of height to width stand one below another
_LEVELS = 257  # shades
_NOISE = 1e-6  # relative range below which a field counts as constant
_TITLES = {"speed": "fluid speed", "p": "pressure"}
# triangles that a quadratic cell is drawn as; on fine meshes its corners are as good
_INNER = {3: [(0, 3, 5), (3, 1, 4), (5, 4, 2), (3, 4, 5)]}
_INNER[4] = [
    (a, b, 8)
    for a, b in zip((0, 4, 1, 5, 2, 6, 3, 7), (4, 1, 5, 2, 6, 3, 7, 0), strict=True)
]
_OUTER = {3: [(0, 1, 2)], 4: [(0, 1, 2), (0, 2, 3)]}
_FINE = 20_000  # cells
_STYLE: dict[Any, Any] = {
    "font.size": 11,
    "axes.titlesize": 11,
    "axes.labelsize": 12,
    "axes.linewidth": 0.6,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.formatter.useoffset": False,
    "axes.formatter.limits": (-3, 5),
    "axes.formatter.use_mathtext": True,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "lines.linewidth": 1.8,
    "legend.frameon": False,
    "figure.titlesize": 12,
    "image.cmap": "viridis",
}


@contextmanager
def styled_figure(
    path: Path | str,
    height: float,
    title: str,
    layout: Any = "constrained",
    width: float | None = None,
) -> Iterator[Any]:
    """Yield a figure in the common style, saved as PNG when the block ends."""
    matplotlib = _matplotlib()
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    with matplotlib.rc_context():
        matplotlib.rcdefaults()
        matplotlib.rcParams.update(_STYLE)
        figure = Figure(figsize=(width or WIDTH, height), dpi=DPI, layout=layout)
        FigureCanvasAgg(figure)
        if title:
            # a dollar in a title is a dollar, not the start of a formula
            figure.suptitle(title, parse_math=False, wrap=True)
        yield figure
        with atomic(path) as temporary:
            # placed by hand, a long tick label may reach beyond the figure, which then
            # grows with it
            figure.savefig(
                temporary,
                format="png",
                bbox_inches="tight" if layout == "none" else None,
                pil_kwargs={"compress_level": _COMPRESSION},
            )


def _matplotlib() -> Any:
    """Import matplotlib; ignore a backend in MPLBACKEND that does not exist, because
    only files are written.
    """
    if "matplotlib" in sys.modules:
        return sys.modules["matplotlib"]
    named = os.environ.pop("MPLBACKEND", None)
    try:
        import matplotlib
    finally:
        if named is not None:
            os.environ["MPLBACKEND"] = named
    if named is not None:
        with suppress(ValueError):
            matplotlib.rcParams["backend"] = named
    return matplotlib


def plain_ticks(axes: Any) -> None:
    """Write the numbers at the ticks as text; as formulas, which a power of ten
    needs, each takes 5 ms to set.
    """
    from matplotlib.ticker import ScalarFormatter

    class Plain(ScalarFormatter):
        def __call__(self, x: float, pos: int | None = None) -> str:
            formula = super().__call__(x, pos)
            return formula.removeprefix("$\\mathdefault{").removesuffix("}$")

    axes.xaxis.set_major_formatter(Plain())
    axes.yaxis.set_major_formatter(Plain())


def _chosen(names: list[str]) -> list[tuple[str, ...]]:
    """Return the fields to plot in groups that share an axis: temperatures, else all
    others one by one.
    """
    groups = [tuple(name for name in pair if name in names) for pair in _PAIRS]
    return next(([group] for group in groups if group), [(name,) for name in names])


def _phase(name: str) -> str:
    return next(
        (phase for phase in ("fluid", "solid") if name.endswith(phase)), "other"
    )


def _group_label(group: tuple[str, ...]) -> str:
    """Return the axis label of fields that share an axis."""
    symbols = ", ".join(f"${FIELDS[name].symbol}$" for name in group)
    unit = FIELDS[group[0]].unit
    return symbols if unit == "1" else f"{symbols} [{unit}]"


def profile_plot(
    path: Path | str,
    columns: Mapping[str, Array],
    coordinate_header: str,
    title: str = "",
) -> None:
    """Plot steady profiles along the bed: temperatures of both phases, or the other
    columns where there are none.

    Parameters
    ----------
    path : PNG file
    columns : values by header, as in profiles.csv
    coordinate_header : which of them is the coordinate
    title : text above the picture
    """
    values = {name_of(header): np.asarray(column) for header, column in columns.items()}
    coordinate = name_of(coordinate_header)
    x = values.pop(coordinate)
    groups = _chosen(list(values))
    with styled_figure(
        path, 4.7 if len(groups) == 1 else 1.2 + 2.3 * len(groups), title
    ) as figure:
        panels = figure.subplots(len(groups), 1, sharex=True, squeeze=False)[:, 0]
        for axes, group in zip(panels, groups, strict=True):
            for name in group:
                # the fluid is dashed so that the solid shows through where both are
                # equal
                dashes = (
                    (0, (4, 2))
                    if _phase(name) == "fluid" and len(group) > 1
                    else "solid"
                )
                axes.plot(
                    x,
                    values[name],
                    color=_COLOURS[_phase(name)],
                    linestyle=dashes,
                    label=_phase(name),
                    zorder=3 if _phase(name) == "fluid" else 2,
                )
            low, high = _limits([values[name] for name in group])
            axes.set_ylim(low - 0.05 * (high - low), high + 0.05 * (high - low))
            axes.set_ylabel(_group_label(group))
            axes.margins(x=0)
            plain_ticks(axes)
            if len(group) > 1:
                axes.legend()
        panels[-1].set_xlabel(FIELDS[coordinate].label)


def transient_plot(
    path: Path | str,
    columns: Mapping[str, Array],
    coordinate_header: str,
    title: str = "",
) -> None:
    """Plot profiles at several times, dark to light, each with its time.

    Parameters are those of `profile_plot`; the columns include "t [s]".
    """
    from matplotlib import colormaps

    values = {name_of(header): np.asarray(column) for header, column in columns.items()}
    coordinate = name_of(coordinate_header)
    x, t = values.pop(coordinate), values.pop("t")
    names = [name for group in _chosen(list(values)) for name in group]
    times = np.unique(t)
    times = times[
        np.unique(np.linspace(0, len(times) - 1, _CURVES).round().astype(int))
    ]
    colours = colormaps["viridis"](np.linspace(0.0, 0.85, len(times)))
    with styled_figure(path, 4.6, title) as figure:
        panels = figure.subplots(
            1,
            len(names),
            sharex=True,
            sharey=len({FIELDS[name].unit for name in names}) == 1,
            squeeze=False,
        )[0]
        for axes, name in zip(panels, names, strict=True):
            curves = [(x[t == time], values[name][t == time]) for time in times]
            for (along, value), colour in zip(curves, colours, strict=True):
                axes.plot(along, value, color=colour)
            axes.margins(x=0)
            axes.set(xlabel=FIELDS[coordinate].label, ylabel=FIELDS[name].label)
            axes.yaxis.set_tick_params(labelleft=True)
            plain_ticks(axes)
            figure.draw_without_rendering()
            for time, colour, spot in zip(
                times, colours, _free_spots(axes, curves), strict=True
            ):
                axes.annotate(
                    f"{time:.4g} s",
                    spot,
                    color=colour,
                    fontsize=9,
                    ha="center",
                    va="center",
                    bbox={
                        "boxstyle": "round,pad=0.1",
                        "facecolor": "white",
                        "linewidth": 0,
                    },
                )


def _free_spots(
    axes: Any, curves: list[tuple[Array, Array]]
) -> list[tuple[float, float]]:
    """Return a point on each curve for its label, far from other curves, other
    labels and the frame.
    """
    unit = axes.transData + axes.transAxes.inverted()
    even = [
        np.interp(np.linspace(0, 1, 200), np.linspace(0, 1, len(x)), np.arange(len(x)))
        for x, _ in curves
    ]
    points = [
        unit.transform(
            np.column_stack(
                [np.interp(k, np.arange(len(x)), x), np.interp(k, np.arange(len(x)), y)]
            )
        )
        for k, (x, y) in zip(even, curves, strict=True)
    ]
    spots: list[Array] = []
    for i, own in enumerate(points):
        inside = own[(np.abs(own[:, 0] - 0.5) < 0.42)]
        others = np.vstack(
            [*(p for j, p in enumerate(points) if j != i), *spots, [[2.0, 2.0]]]
        )
        room = np.linalg.norm(inside[:, None] - others, axis=2).min(axis=1)
        if spots:
            # a label is wider than high
            apart = np.abs(inside[:, None] - np.array(spots)) / (0.14, 0.06)
            room = np.where(apart.max(axis=2).min(axis=1) < 1, room - 1, room)
        spots.append(inside[room.argmax()])
    return [
        tuple(point)
        for point in axes.transData.inverted().transform(
            axes.transAxes.transform(np.array(spots))
        )
    ]


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
    groups = _chosen([name for name in maps if name != "speed"])
    names = [name for group in groups for name in group] + ["speed"] * ("speed" in maps)
    pattern = (_INNER if mesh.nelements < _FINE else _OUTER)[
        quadratic.element.nvertices
    ]
    triangles = np.vstack([quadratic.dofs[list(three)].T for three in pattern])
    # temperatures of both phases share a scale
    same = groups[0] if groups else ("speed",)

    points, labels = quadratic.points, ("r", "z") if axisymmetric else ("x", "y")
    extent = np.ptp(points, axis=1)
    upright = extent[1] > extent[0]
    lying = max(extent) > _LONG * min(extent)
    if lying and upright:
        points, labels, extent = points[::-1], labels[::-1], extent[::-1]
    stretch = max(1.0, extent[0] / (_FLAT * extent[1]))
    ratio = stretch * extent[1] / extent[0]
    rows, across = (len(names), 1) if ratio < _STACKED else (1, len(names))
    # inches: a map, and the cell it shares with its title, ticks and colour bar
    wide = (WIDTH - 0.8) / across - 0.9
    high = wide * ratio
    size = 0.8 + across * (wide + 0.9), 0.85 + rows * (high + 0.45)
    note = (
        f"   (${FIELDS[labels[1]].symbol}$ drawn {stretch:.2g} times larger)"
        if stretch > 1
        else ""
    )
    with styled_figure(path, size[1], title, layout="none") as figure:
        for k, name in enumerate(names):
            row, column = divmod(k, across)
            left = 0.8 + column * (wide + 0.9)
            bottom = 0.6 + (rows - 1 - row) * (high + 0.45)
            axes, beside = (
                figure.add_axes(
                    (x / size[0], bottom / size[1], width / size[0], high / size[1])
                )
                for x, width in ((left, wide), (left + wide + 0.1, 0.13))
            )
            levels = np.linspace(
                *_limits(
                    [maps[other] for other in (same if name in same else (name,))]
                ),
                _LEVELS,
            )
            colours = axes.tricontourf(
                *points, triangles, maps[name], levels, cmap=_MAPS[FIELDS[name].unit]
            )
            bar = figure.colorbar(colours, cax=beside)
            for axis, inches in (
                (axes.xaxis, wide),
                (axes.yaxis, high),
                (beside.yaxis, high),
            ):
                axis.set_major_locator(
                    MaxNLocator(int(np.clip(2 * inches, 2, 6)), steps=[1, 2, 5, 10])
                )
            axes.spines[:].set_visible(False)
            bar.outline.set_visible(False)
            axes.set_title(
                f"{_TITLES.get(name, _phase(name))}  {FIELDS[name].label}", loc="left"
            )
            axes.tick_params(labelbottom=row == rows - 1, labelleft=column == 0)
            axes.set_xlabel(FIELDS[labels[0]].label + note if row == rows - 1 else "")
            axes.set_ylabel(FIELDS[labels[1]].label if column == 0 else "")


def _limits(values: list[Array]) -> tuple[float, float]:
    """Return the range of values, widened for a field that is constant except for
    solver noise.
    """
    low, high = min(float(v.min()) for v in values), max(float(v.max()) for v in values)
    if high - low <= _NOISE * max(abs(low), abs(high)):
        spread = 0.05 * abs(low) or 1.0
        return low - spread, high + spread
    return low, high


def error_plot(
    path: Path | str,
    curves: Mapping[str, Any],
    x_label: str,
    y_label: str,
    title: str = "",
) -> None:
    """Plot errors on logarithmic axes, one line for each (x, error) in `curves`;
    only positive values.
    """
    with styled_figure(path, 5.0, title) as figure:
        axes = figure.subplots()
        for (label, (x, error)), marker in zip(
            curves.items(), itertools.cycle("osD^vPX<>"), strict=False
        ):
            x, error = np.asarray(x, dtype=float), np.asarray(error, dtype=float)
            shown = error > 0
            axes.loglog(
                x[shown],
                error[shown],
                marker=marker,
                markersize=5,
                linewidth=1.2,
                label=label,
            )
        axes.set_xlabel(x_label)
        axes.set_ylabel(y_label)
        axes.grid(which="major", linewidth=0.3)
        if len(curves) > 1:
            figure.legend(loc="outside lower center", ncols=3, fontsize=9)


def plot_profiles_and_fields(result: Any, folder: Path) -> None:
    """Write profiles.png, over time for a transient, and fields.png of a plane mesh,
    into `folder`.
    """
    scene, mesh, columns = result.plan.scene, result.plan.mesh, result.profiles
    draw = transient_plot if "t [s]" in columns else profile_plot
    draw(folder / "profiles.png", columns, next(iter(columns)), scene.title)
    if result.nodal and mesh.skfem.dim() == 2:
        field_plot(
            folder / "fields.png",
            mesh.skfem,
            result.nodal,
            mesh.axisymmetric,
            scene.title,
        )
