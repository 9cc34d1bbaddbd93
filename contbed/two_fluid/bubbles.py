"""Bubbles of a fluidized bed: connected regions of gas in the rows of a run, their size,
and how fast they rise.

A region that touches the floor is still forming, one that touches the roof is the
freeboard, and one of fewer than SMALLEST cells is not resolved: none of them counts. Its
diameter is that of the circle of its area, in boxes and around an axis of the sphere of
its volume. A bubble of one row is that of the row before whose centre is nearest, not
farther than a diameter, and whose diameter differs by less than a factor of LIKE. Only
where a bubble at 0.71 sqrt(g d) (Davies and Taylor 1950, Proc. R. Soc. A 200, 375-390)
moves by less than its radius from row to row is it followed at all.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import pairwise
from typing import TYPE_CHECKING, Any

import numpy as np
from scipy.sparse import coo_array
from scipy.sparse.csgraph import connected_components
from scipy.spatial import cKDTree

from contbed.two_fluid.compiled import Array, Flags, Indices
from contbed.two_fluid.end_pressure import end_faces
from contbed.two_fluid.fv.connections import paired_facets
from contbed.two_fluid.plan import periodic_pairs
from contbed.two_fluid.vessel import Vessel

if TYPE_CHECKING:
    from contbed.two_fluid.plan import TwoFluidPlan
    from contbed.two_fluid.scene import TwoFluidScene

OPEN = 0.8  # porosity above which a cell is part of a bubble
SMALLEST = 4  # cells of a bubble
LIKE = 1.3  # largest ratio of the diameters of a bubble in two rows
RISE = 0.71  # speed of a bubble over sqrt(g d)
BINS = 10  # along the bed


class Bubbles:
    """Bubbles in the rows of a run.

    Attributes
    ----------
    found : time [s], volume, and centre [m] of each bubble in each row
    """

    def __init__(self, plan: TwoFluidPlan):
        self.grid = grid = plan.grid
        self.links = neighbours(plan)
        self.at_ends = np.concatenate([end_faces(grid, side) for side in (-1, 1)])
        self.at_ends = grid.geometry.left[grid.interior + self.at_ends]
        self.flat = grid.dimension == 2 and not grid.axisymmetric
        self.gravity = plan.scene.two_fluid.gravity
        self.found: list[list[float]] = []

    def add(self, time: float, eps_s: Array) -> None:
        """Look for the bubbles of a row at a time [s]."""
        volume, centres = self.grid.geometry.volume, self.grid.centres
        open_cells = eps_s < 1.0 - OPEN
        regions = open_regions(open_cells, self.links, self.at_ends, volume, centres)
        self.found += [[time, *region] for region in regions.tolist()]

    def findings(
        self, rows: int, height: float
    ) -> tuple[dict[str, float], dict[str, Array]]:
        """Return named results and, where there are bubbles, a table along the height,
        of a number of rows with a bed of a height [m].
        """
        grid = self.grid
        floor = float(grid.spans.min())
        edges = np.linspace(0.0, height, BINS + 1)
        within = np.diff(Vessel.of(grid).below(edges))
        inside = [each for each in self.found if each[-1] - floor < height]
        if not inside:
            return {"bubbles": 0.0}, {}
        time, volume, *centre = np.array(inside).T
        diameter = self.diameter(volume)
        rise = rises(time, diameter, np.array(centre).T, self.gravity)
        above = centre[-1] - floor
        which = np.minimum((above / height * BINS).astype(int), BINS - 1)
        count = np.bincount(which, minlength=BINS)
        share = np.bincount(which, volume, BINS) / (within * rows)
        followed = ~np.isnan(rise)
        steps = np.bincount(which, followed, BINS)
        with np.errstate(invalid="ignore"):
            table = {
                "height [m]": floor + (np.arange(BINS) + 0.5) * height / BINS,
                "d_b [m]": np.bincount(which, diameter, BINS) / count,
                "u_b [m/s]": np.bincount(which, np.nan_to_num(rise), BINS) / steps,
                "delta [1]": share,
            }
        found = {
            "bubbles": len(inside) / rows,
            "bubble_diameter_m": float(diameter.mean()),
            "bubble_diameter_max_m": float(diameter.max()),
            "bubble_share": float(volume.sum() / (within.sum() * rows)),
        }
        if followed.any():
            found["bubble_rise_m_s"] = float(rise[followed].mean())
        return found, table

    def judge(
        self, scene: TwoFluidScene, qoi: Mapping[str, Any], interval: float
    ) -> list[str]:
        """Return a warning where rows at an interval [s] are too far apart to follow
        the bubbles of the named results.
        """
        diameter = qoi.get("bubble_diameter_m")
        if diameter is None or "bubble_rise_m_s" in qoi:
            return []
        longest = float(longest_interval(diameter, self.gravity))
        if interval <= longest:
            return []
        text = (
            f"rows every {interval:.2g} s are too far apart to follow bubbles of "
            f"{diameter:.2g} m; set time.sample = {longest:.1g}"
        )
        return [f"{scene.origin.place(('time', 'sample'))}: {text}"]

    def diameter(self, volume: Array) -> Array:
        """Return the diameters (n,) [m] of bubbles of a volume."""
        if self.flat:
            return np.asarray(np.sqrt(4.0 * volume / np.pi))
        return np.asarray(np.cbrt(6.0 * volume / np.pi))


def longest_interval(diameter: Array, gravity: float) -> Array:
    """Return the longest time (n,) [s] between rows in which bubbles of a diameter [m]
    are followed.
    """
    return np.asarray(0.5 / RISE * np.sqrt(diameter / gravity))


def neighbours(plan: TwoFluidPlan) -> Indices:
    """Return pairs (2, n) of cells that share a face, also across periodic sides."""
    mesh, place = plan.mesh.skfem, np.argsort(plan.grid.cells)
    inner = mesh.f2t[:, mesh.f2t[1] >= 0]
    middles = mesh.p[:, mesh.facets].mean(axis=1).T
    sides = paired_facets(plan.mesh, periodic_pairs(plan.scene), middles)
    across = mesh.f2t[0][np.stack(sides)]
    return np.asarray(place[np.hstack((inner, across))])


def open_regions(
    open_cells: Flags, links: Indices, at_ends: Indices, volume: Array, centres: Array
) -> Array:
    """Return volume and centre (n, 1 + dim) of each connected region of open cells.

    Parameters
    ----------
    open_cells (nc,) : whether a cell belongs to a region
    links (2, n) : cells that share a face
    at_ends : cells whose regions do not count, nor do those of few cells
    volume (nc,), centres (nc, dim) : of the cells
    """
    joined = links[:, open_cells[links].all(axis=0)]
    pattern = coo_array(
        (np.ones(joined.shape[1]), tuple(joined)), shape=(len(volume), len(volume))
    )
    number, region = connected_components(pattern, directed=False)
    counts = np.bincount(region, open_cells, number) >= SMALLEST
    counts[region[at_ends]] = False
    size = np.bincount(region, volume, number)
    moments = [np.bincount(region, volume * x, number) / size for x in centres.T]
    return np.stack((size, *moments), axis=1)[counts]


def rises(time: Array, diameter: Array, centre: Array, gravity: float) -> Array:
    """Return the velocity (n,) [m/s] at which each bubble has risen since the row
    before; nan where it was not followed.

    Parameters
    ----------
    time [s], diameter [m] (n,), centre [m] (n, dim) : of bubbles, by increasing time
    gravity : [m/s2]
    """
    found = np.full(len(time), np.nan)
    for before, now in pairwise(np.unique(time)):
        old, new = np.flatnonzero(time == before), np.flatnonzero(time == now)
        distance, nearest = cKDTree(centre[old]).query(centre[new])
        old, d, interval = old[nearest], diameter[new], now - before
        ratio = d / diameter[old]
        same = (distance < d) & (np.maximum(ratio, 1.0 / ratio) < LIKE)
        same &= interval <= longest_interval(d, gravity)
        risen = (centre[new, -1] - centre[old, -1]) / interval
        found[new[same]] = risen[same]
    return found
