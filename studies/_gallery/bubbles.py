"""The largest bubble in a bed: its size and what it holds."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.ndimage import label


def largest_bubble(
    porosity: NDArray[np.float64], above: float
) -> NDArray[np.bool_] | None:
    """Cells of the largest connected region whose porosity is `above` and that does not
    touch the freeboard.

    Parameters
    ----------
    porosity : by column and row, shape (columns, rows); the freeboard is at the last
        row
    """
    parts, number = label(porosity > above)
    free = set(np.unique(parts[:, -1])) - {0}
    sizes = [0 if k in free else int((parts == k).sum()) for k in range(1, number + 1)]
    if not sizes or max(sizes) == 0:
        return None
    inside: NDArray[np.bool_] = parts == 1 + int(np.argmax(sizes))
    return inside


def equivalent_diameter(inside: NDArray[np.bool_], cell_area: float) -> float:
    """Diameter of a circle of the same area [m]."""
    return float(np.sqrt(4.0 * inside.sum() * cell_area / np.pi))


def draw_bubbles(axes: Any, curves: list[tuple[Any, Any, Any, dict[str, Any]]]) -> None:
    """Diameter [cm] and temperature [K] over time in two panels, from (t,
    diameter [m], T, how) of each curve.
    """
    for t, diameter, T, how in curves:
        shown = diameter > 0.0
        axes[0].plot(t[shown], 1e2 * diameter[shown], **how)
        axes[1].plot(t[shown], T[shown], **how)
    axes[0].set(xlabel="time [s]", ylabel="diameter of the bubble [cm]")
    axes[1].set(xlabel="time [s]", ylabel="mean gas temperature in the bubble [K]")
