"""What a packing is like: porosity of the core and of the whole bed, coordination."""

from __future__ import annotations

import numpy as np

from contbed.arrays import Array
from contbed.compiled.functions import entry
from contbed.dem.simulation import Contacts
from contbed.dem.walls import Domain

MARGIN = 2.0  # diameters from every wall and below the top that the core leaves out
VOXELS = 4e6
FINEST = 40.0  # voxels to a diameter at most


def porosity(
    position: Array, radius: Array, domain: Domain, cylinder: float | None
) -> dict[str, float]:
    """Find `porosity_core`, two diameters off walls, floor and top or NaN, and
    `porosity_box` up to the top.

    The top is the mean height of the upper ends of the highest spheres, one for each
    square of a diameter. The core is counted on voxels, at an error of about 1e-4; the
    box is exact.
    """
    top = surface(position, radius)
    lower, upper = _bounds(domain, top)
    area = (
        np.pi * cylinder**2
        if cylinder is not None
        else float(np.prod(upper[:2] - lower[:2]))
    )
    solid = float((4.0 / 3.0 * np.pi * radius**3).sum())
    off = MARGIN * 2.0 * float(radius.max())
    margin = np.where(domain.periodic, 0.0, off)
    inner = None if cylinder is None else cylinder - off
    low, high = lower + margin, upper - margin
    if not (high > low).all() or (inner is not None and inner <= 0.0):
        return {
            "porosity_core": float("nan"),
            "porosity_box": 1.0 - solid / (area * top),
        }
    width = max(
        2.0 * float(radius.min()) / FINEST,
        float(np.prod(high - low) / VOXELS) ** (1.0 / 3.0),
    )
    lengths = np.where(domain.periodic, upper - lower, np.inf)
    share = solid_share(
        position, radius, low, high, width, lengths, -1.0 if inner is None else inner
    )
    return {"porosity_core": 1.0 - share, "porosity_box": 1.0 - solid / (area * top)}


def surface(position: Array, radius: Array) -> float:
    """Find the mean height [m] of the bed: upper end of the highest sphere over
    every square of one mean diameter.
    """
    d = 2.0 * float(radius.mean())
    column = np.floor(position[:, :2] / d).astype(np.int64)
    column -= column.min(axis=0)
    ends = np.full(tuple(column.max(axis=0) + 1), -np.inf)
    np.maximum.at(ends, (column[:, 0], column[:, 1]), position[:, 2] + radius)
    return float(ends[np.isfinite(ends)].mean())


def coordination(
    position: Array,
    radius: Array,
    contacts: Contacts,
    domain: Domain,
    cylinder: float | None,
) -> dict[str, float]:
    """Count touching neighbours: mean `coordination` of all spheres,
    `coordination_core` of those in the core.
    """
    number = np.bincount(contacts.i, minlength=len(position)) + np.bincount(
        contacts.j, minlength=len(position)
    )
    lower, upper = _bounds(domain, surface(position, radius))
    margin = np.where(domain.periodic, -np.inf, MARGIN * 2.0 * radius.max())
    core = ((position > lower + margin) & (position < upper - margin)).all(axis=1)
    if cylinder is not None:
        core &= (
            np.hypot(position[:, 0], position[:, 1])
            < cylinder - MARGIN * 2.0 * radius.max()
        )
    return {
        "coordination": float(number.mean()),
        "coordination_core": float(number[core].mean()) if core.any() else float("nan"),
    }


@entry(cache=True)
def solid_share(
    x: Array,
    radius: Array,
    low: Array,
    high: Array,
    width: float,
    lengths: Array,
    inner: float,
) -> float:
    """Find the share of a block that spheres cover, on voxels of about `width` [m];
    `lengths` of periodic sides or inf.

    With `inner` > 0 only the voxels within that distance of the z axis count.
    """
    count = np.empty(3, np.int64)
    size = np.empty(3)
    for axis in range(3):
        count[axis] = max(1, int(np.ceil((high[axis] - low[axis]) / width)))
        size[axis] = (high[axis] - low[axis]) / count[axis]
    solid = np.zeros((count[0], count[1], count[2]), np.bool_)
    centre = np.empty(3)
    first, last = np.empty(3, np.int64), np.empty(3, np.int64)
    for i in range(len(x)):
        for image in range(9):
            side = (image % 3 - 1, image // 3 - 1, 0)
            near = True
            for axis in range(3):
                if side[axis] != 0 and lengths[axis] == np.inf:
                    near = False
                    break
                centre[axis] = x[i, axis] + (
                    side[axis] * lengths[axis] if side[axis] != 0 else 0.0
                )
                first[axis] = max(
                    0,
                    int(np.floor((centre[axis] - radius[i] - low[axis]) / size[axis])),
                )
                last[axis] = min(
                    count[axis],
                    int(np.floor((centre[axis] + radius[i] - low[axis]) / size[axis]))
                    + 1,
                )
                near = near and first[axis] < last[axis]
            if not near:
                continue
            for a in range(first[0], last[0]):
                dx = low[0] + (a + 0.5) * size[0] - centre[0]
                for b in range(first[1], last[1]):
                    dy = low[1] + (b + 0.5) * size[1] - centre[1]
                    rest = radius[i] ** 2 - dx * dx - dy * dy
                    for c in range(first[2], last[2]):
                        dz = low[2] + (c + 0.5) * size[2] - centre[2]
                        if dz * dz <= rest:
                            solid[a, b, c] = True
    inside, covered = 0, 0
    for a in range(count[0]):
        for b in range(count[1]):
            off2 = (low[0] + (a + 0.5) * size[0]) ** 2 + (
                low[1] + (b + 0.5) * size[1]
            ) ** 2
            if inner > 0.0 and off2 > inner * inner:
                continue
            inside += count[2]
            covered += solid[a, b].sum()
    return covered / inside


def _bounds(domain: Domain, top: float) -> tuple[Array, Array]:
    return np.array(domain.lower), np.array([*domain.upper[:2], top])
