"""What a transient run of a reacting bed has passed: its state and totals."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar, Self

import numpy as np

from contbed.arrays import Array, Flags
from contbed.course.history import History
from contbed.reacting_bed.least_amounts import Least

FLOW = "flow"  # column of the outlet: moles of the gas that leaves, along x [mol/m2/s]


@dataclass(frozen=True, kw_only=True)
class BedHistory(History):
    """State of a run (unknowns, N, p + 1), those of a section ring by ring, and its
    integrals over time.

    held : (m,) what the bed held at the start, means over the section as all integrals
        are
    passed : (m, 2) integrals of the fluxes through both ends, along x
    both_ways : (m, 2) integrals of their magnitudes, which a flow that turns does not
        cancel
    stage : state at the first stage of the last step, (unknowns, N, p + 1); None at the
        start and on other cells
    damping : (unknowns, N) with which the next step begins, see `positivity_in_time`; damped :
        (N,) cells that were damped
    steps_damped, steps_limited : steps in which cells were damped, and in which rates
        took all there was of a solid
    unbounded : steps with amounts below zero; absent : what rates took in the first of
        them though there was none of it
    sources : (m,) integrals of the sources
    carried : integral of the heat of all streams above 298.15 K [J/m2]
    columns : names of the columns of the outlet
    vertices : of the present cells (N + 1,) [m]; changes : how often they were others;
        most : the largest N
    pressure : at which a gas is stored at all nodes, where cells follow errors [Pa];
        None: that of the start
    rough : integral of the largest error of a cell over its size, see
        `cells.errors` [s]
    least : amount of a gas or solid of all steps
    extents : of reactions inside of pellets, by their number and kind: first guesses,
        on which last digits depend
    """

    held: Array
    passed: Array
    both_ways: Array
    sources: Array
    damping: Array
    damped: Flags
    vertices: Array
    pressure: Array | None = None
    stage: Array | None = None
    carried: float = 0.0
    steps_damped: int = 0
    steps_limited: int = 0
    unbounded: int = 0
    absent: str | None = None
    columns: tuple[str, ...] = ()
    changes: int = 0
    most: int = 0
    rough: float = 0.0
    extents: Mapping[tuple[int, str], Array] = field(default_factory=dict)
    least: Least = field(default_factory=Least)
    at_start: ClassVar[bool] = False
    # of beds whose cells follow their errors
    free: ClassVar[Collection[str]] = ("state", "damping", "damped", "vertices")

    @property
    def snapshot(self) -> Any:
        """What is kept of an output time: vertices and state."""
        return self.vertices, self.state

    @classmethod
    def of(cls, values: Mapping[str, Any]) -> Self:
        """Return a history from its plain values."""
        found = cls(**values)
        return replace(found, least=Least(*found.least))

    def table(self) -> dict[str, Array]:
        """Return the outlet over time by column, without the flow of the gas."""
        found = dict(zip(self.columns, np.array(self.outlet).T, strict=True))
        found.pop(FLOW, None)
        return found
