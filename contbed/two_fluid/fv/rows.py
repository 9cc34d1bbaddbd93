"""Rows of a rectangular grid: cells and faces that follow each other in memory along an
axis.

A grid is rectangular where all faces lie across axes and all cells in the places (i, j,
k) of a lattice, some of which may be empty (obstacles). Its cells are numbered place by
place, the longest axis fastest. Its interior faces then come in rows: face, left and
right cell of the next one are each the next number. Kernels that run over rows read and
write contiguous memory, which compilers turn into vectors; those over single faces (any
mesh) cannot.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

# largest other component of a normal along an axis; spread of places over the size of
# the grid
ON_AXIS = 1e-9


class Rows(NamedTuple):
    """Rows of interior faces, nr of them; a periodic pair is a row with negative or no
    distance of its cells.

    Those of a part of the grid, for one of several threads, hold its cells begin to end
    and all faces of these; a face between two parts is in both, and belongs to that of
    its left cell.

    axis, face, left, right, length (nr,) : direction of the faces, first face with its
    cells, number of faces; but for
        the axis unsigned, as indices that count from them are then known not to be negative
    left_from, left_to, right_from, right_to (nr,) : faces of the row whose left, and
    whose right cell is in the part
    begin, end : first cell of the part, and the one after its last
    arm_left, arm_right (nf,) [m] : distance of the left and of the right centre to the
        face, on boundaries only left
    slope_left, slope_right (nf,) [1/m] : of a cell's gradient along the axis of the
        face, per jump right - left
    edge_axis (nb,) : axis of each boundary face;
    edge_sign (nb,) : 1 where it points along it, or -1
    """

    axis: np.ndarray
    face: np.ndarray
    left: np.ndarray
    right: np.ndarray
    length: np.ndarray
    left_from: np.ndarray
    left_to: np.ndarray
    right_from: np.ndarray
    right_to: np.ndarray
    begin: int
    end: int
    arm_left: np.ndarray
    arm_right: np.ndarray
    slope_left: np.ndarray
    slope_right: np.ndarray
    edge_axis: np.ndarray
    edge_sign: np.ndarray


def places(
    centres: np.ndarray, normals: np.ndarray, left: np.ndarray, right: np.ndarray
) -> np.ndarray | None:
    """Place (nc, dim) of each cell in the lattice; None where the grid is not
    rectangular.

    `left` and `right` are the cells of the faces that are not periodic.
    """
    if (np.sort(np.abs(normals), axis=1)[:, :-1] > ON_AXIS).any():
        return None
    found = np.empty(centres.shape, dtype=np.int64)
    for d, x in enumerate(centres.T):
        order = np.argsort(x, kind="stable")
        new = (
            np.diff(x[order], prepend=x[order[0]])
            > ON_AXIS * np.ptp(centres, axis=0).max()
        )
        found[order, d] = np.cumsum(new)
    apart = np.sort(np.abs(found[right] - found[left]), axis=1)
    beside = (apart[:, -1] == 1).all() and (apart[:, :-1] == 0).all()
    return found if beside and len(np.unique(found, axis=0)) == len(found) else None


def numbering(place: np.ndarray) -> np.ndarray:
    """Return the cells in order, the longest axis fastest."""
    longest_first = np.argsort(-place.max(axis=0), kind="stable")
    order: np.ndarray = np.lexsort(place.T[longest_first])
    return order


def build_rows(
    left: np.ndarray,
    right: np.ndarray,
    normal: np.ndarray,
    arms: tuple[np.ndarray, np.ndarray],
    slopes: tuple[np.ndarray, np.ndarray],
    cells: int,
) -> Rows:
    """Join faces (nf,), ordered by axis and cell, to rows; `cells` is the number of
    cells.

    `arms` and `slopes` are those of both sides, (nf, dim) and (ni, dim).
    """
    ni = len(right)
    along = np.argmax(np.abs(normal), axis=1)
    axis, edge_axis = along[:ni], along[ni:]
    apart = right - left[:ni]
    new = np.ones(ni, dtype=bool)
    new[1:] = (np.diff(axis) != 0) | (np.diff(apart) != 0) | (np.diff(left[:ni]) != 1)
    first = np.flatnonzero(new)
    length = np.diff(np.append(first, ni))
    each = np.arange(len(normal))
    return Rows(
        axis[first],
        first.astype(np.uint64),
        left[first].astype(np.uint64),
        right[first].astype(np.uint64),
        length.astype(np.uint64),
        np.zeros(len(first), np.uint64),
        length.astype(np.uint64),
        np.zeros(len(first), np.uint64),
        length.astype(np.uint64),
        0,
        cells,
        np.abs(arms[0][each, along]),
        np.abs(arms[1][each[:ni], axis]),
        slopes[0][each, along],
        slopes[1][each[:ni], axis],
        edge_axis,
        np.sign(normal[each[ni:], edge_axis]),
    )


def part_of_rows(rows: Rows, begin: int, end: int) -> Rows:
    """Return the rows of the cells from `begin` to before `end`."""
    length = rows.length.astype(np.int64)
    spans = []
    for first in (rows.left.astype(np.int64), rows.right.astype(np.int64)):
        start = np.clip(begin - first, 0, length)
        spans.append((start, np.maximum(start, np.clip(end - first, 0, length))))
    (left_from, left_to), (right_from, right_to) = spans
    of_left, of_right = left_from < left_to, right_from < right_to
    none = length.max(initial=0)
    lowest = np.minimum(
        np.where(of_left, left_from, none), np.where(of_right, right_from, none)
    )
    highest = np.maximum(np.where(of_left, left_to, 0), np.where(of_right, right_to, 0))
    there = of_left | of_right

    def shifted(number: np.ndarray, by: np.ndarray) -> np.ndarray:
        found: np.ndarray = (number.astype(np.int64) + by)[there].astype(np.uint64)
        return found

    return rows._replace(
        axis=rows.axis[there],
        face=shifted(rows.face, lowest),
        left=shifted(rows.left, lowest),
        right=shifted(rows.right, lowest),
        length=shifted(highest, -lowest),
        # a row without a left or a right cell in the part starts where the other one
        # does
        left_from=shifted(np.where(of_left, left_from, lowest), -lowest),
        left_to=shifted(np.where(of_left, left_to, lowest), -lowest),
        right_from=shifted(np.where(of_right, right_from, lowest), -lowest),
        right_to=shifted(np.where(of_right, right_to, lowest), -lowest),
        begin=begin,
        end=end,
    )
