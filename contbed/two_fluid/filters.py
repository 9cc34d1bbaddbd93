"""Filters of the closures for cells that do not resolve clusters: their size beside
that of the cells and of the fits.

The size of a filter is F v_t^2/g with F the argument `filter_froude` of the closure,
v_t the terminal velocity.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np

from contbed.closures import filtered
from contbed.two_fluid.closures import (
    FILTER_CELLS,
    FROM_CELLS,
    KINDS,
    bound,
    terminal_velocity,
)

if TYPE_CHECKING:
    from contbed.scene.toml_lines import KeyPath
    from contbed.two_fluid import scene as t
    from contbed.two_fluid.fv.grid import Grid

# cells across a filter: fewer have no filtered scales, more resolve what the closure
# adds
FEWEST, MOST = 1.0, 4.0


def chosen(scene: t.TwoFluidScene) -> dict[str, tuple[str, float]]:
    """Name of the closure and size of its filter over v_t^2/g [-] by key
    of [closures]; empty where none has one.
    """
    closures, found = bound(scene), {}
    for key, kind in KINDS.items():
        closure = closures[kind] if kind in FROM_CELLS else None
        if closure is not None and "filter_froude" in closure.parameters:
            found[key] = closure.name, float(closure.parameters["filter_froude"])
    return found


def unit(scene: t.TwoFluidScene) -> float:
    """Length v_t^2/g [m] that clusters scale with."""
    return (
        terminal_velocity(scene.two_fluid.gravity, scene.fluid, scene.solid) ** 2
        / scene.two_fluid.gravity
    )


def cell_size(grid: Grid) -> float:
    """Size of a cell [m], the median: its length, the root of its area or the cube
    root of its volume.
    """
    volume = grid.geometry.volume
    if grid.axisymmetric:
        volume = volume / (2.0 * np.pi * grid.centres[:, 0])
    return float(np.median(volume) ** (1.0 / grid.dimension))


def described(scene: t.TwoFluidScene, grid: Grid) -> list[tuple[str, str]]:
    """Return a line of the plan for each closure with a filter: its size, and the
    fits it lies between.
    """
    found = []
    for key, (name, F) in chosen(scene).items():
        size = F * unit(scene)
        text = f"{size:.3g} m, {size / cell_size(grid):.3g} cells wide, {F:.3g} v_t^2/g"
        what = KINDS[key].replace("_", " ")
        found.append(
            (
                f"filter of the {what}",
                text + (_fits(F) if name == "drag_milioli" else ""),
            )
        )
    return found


def _fits(F: float) -> str:
    smaller, larger = filtered.fits_milioli(F)
    if larger == filtered.UNFILTERED:
        return f"; no drag is filtered up to {larger:.4g}"
    return (
        f"; between the fits to {smaller:.4g} and {larger:.4g}"
        if smaller < larger
        else f"; the fit to {smaller:.4g}"
    )


def results(scene: t.TwoFluidScene) -> dict[str, float]:
    """Named results: the widest filter over v_t^2/g and in metres; none without
    filtered closures.
    """
    sizes = [F for _, F in chosen(scene).values()]
    return (
        {"filter_froude": max(sizes), "filter_size [m]": max(sizes) * unit(scene)}
        if sizes
        else {}
    )


def unlike_the_cells(
    scene: t.TwoFluidScene, grid: Grid
) -> Iterator[tuple[KeyPath, str]]:
    """Look for filters that do not belong to the cells: a few cells wide, or the
    closure adds what cells resolve.
    """
    for key, (_, F) in chosen(scene).items():
        cells = F * unit(scene) / cell_size(grid)
        if not FEWEST <= cells <= MOST:
            meant = FILTER_CELLS * cell_size(grid) / unit(scene)
            text = (
                f"its filter is {cells:.3g} cells wide; {FILTER_CELLS:g} are meant, "
                f"filter_froude = {meant:.4g}"
            )
            yield ("closures", key), text
