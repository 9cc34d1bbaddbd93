"""What a transient run of a reacting bed has passed: its state and totals, and how
they are kept in a checkpoint.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from contbed.errors import SceneError
from contbed.reacting_bed.amounts import Least
from contbed.reacting_bed.scene import Time
from contbed.scene.toml_lines import Origin

Array = NDArray[np.float64]
SAME = 1e-12  # relative distance below which two times are the same
ARRAYS = (
    "u",
    "held",
    "passed",
    "both_ways",
    "sources",
    "damping",
    "damped",
    "vertices",
)
NUMBERS = (
    "time",
    "dt",
    "steps",
    "steps_damped",
    "steps_limited",
    "unbounded",
    "carried",
    "changes",
    "most",
    "rough",
)
EXTENTS, KEPT = "extents_", "kept_"  # begin names of arrays of a checkpoint
PRESSURE = "pressure"
FLOW = "flow"  # column of the outlet: moles of the gas that leaves, along x [mol/m2/s]


@dataclass(frozen=True)
class History:
    """State of a run and its integrals over time; a step returns a new one.

    u : (unknowns, N, p + 1), those of a section ring by ring; dt : length of the next
        step [s]
    held : (m,) what the bed held at the start, means over the section as all integrals
        are
    passed : (m, 2) integrals of the fluxes through both ends, along x
    both_ways : (m, 2) integrals of their magnitudes, which a flow that turns does not
        cancel
    damping : (unknowns, N) with which the next step begins, see `bounded`; damped :
        (N,) cells that were damped
    steps_damped, steps_limited : steps in which cells were damped, and in which rates
        took all there was of a solid
    unbounded : steps with amounts below zero
    sources : (m,) integrals of the sources
    carried : integral of the heat of all streams above 298.15 K [J/m2]
    outlet : (steps, columns) of the outlet over time, `columns` their names
    vertices : of the present cells (N + 1,) [m]; changes : how often they were others;
        most : the largest N
    pressure : at which a gas is stored at all nodes, where cells follow errors [Pa];
        None: that of the start
    rough : integral of the largest error of a cell over its size, see
        `cells.errors` [s]
    kept : vertices and states at output times
    least : amount of a gas or solid of all steps
    extents : of reactions inside of pellets, by their number and kind: first guesses,
        on which last digits depend
    """

    u: Array
    dt: float
    held: Array
    passed: Array
    both_ways: Array
    sources: Array
    damping: Array
    damped: NDArray[np.bool_]
    vertices: Array
    pressure: Array | None = None
    carried: float = 0.0
    time: float = 0.0
    steps: int = 0
    steps_damped: int = 0
    steps_limited: int = 0
    unbounded: int = 0
    columns: tuple[str, ...] = ()
    outlet: tuple[tuple[float, ...], ...] = ()
    changes: int = 0
    most: int = 0
    rough: float = 0.0
    kept: Mapping[float, tuple[Array, Array]] = field(default_factory=dict)
    extents: Mapping[tuple[int, str], Array] = field(default_factory=dict)
    least: Least = field(default_factory=Least)

    def pack(self) -> tuple[dict[str, Any], dict[str, Any]]:
        """Return the arrays and numbers of a checkpoint."""
        arrays = {name: getattr(self, name) for name in ARRAYS}
        arrays |= {
            "outlet": np.array(self.outlet),
            "times": np.array([*self.kept]),
            "least": np.array(self.least),
        }
        arrays |= {
            f"{KEPT}{k}_{n}": part
            for k, pair in enumerate(self.kept.values())
            for n, part in enumerate(pair)
        }
        arrays |= {} if self.pressure is None else {PRESSURE: self.pressure}
        arrays |= {
            f"{EXTENTS}{count}_{kind}": extents
            for (count, kind), extents in self.extents.items()
        }
        return arrays, {name: getattr(self, name) for name in NUMBERS} | {
            "columns": list(self.columns)
        }

    @classmethod
    def unpack(cls, arrays: Mapping[str, Any], meta: Mapping[str, Any]) -> History:
        """Restore a history from a checkpoint."""
        extents = {}
        for name in arrays:
            if name.startswith(EXTENTS):
                count, _, kind = name.removeprefix(EXTENTS).partition("_")
                extents[int(count), kind] = arrays[name]
        return cls(
            **{name: arrays[name] for name in ARRAYS},
            **{name: meta[name] for name in NUMBERS},
            columns=tuple(meta["columns"]),
            outlet=tuple(tuple(row) for row in arrays["outlet"].tolist()),
            pressure=arrays.get(PRESSURE),
            kept={
                t: (arrays[f"{KEPT}{k}_0"], arrays[f"{KEPT}{k}_1"])
                for k, t in enumerate(arrays["times"].tolist())
            },
            extents=extents,
            least=Least(*arrays["least"].tolist()),
        )

    def fitted(self, time: Time, where: Origin) -> History:
        """Return the history as if the run had been asked for this end and these output
        times from its start.

        Raises
        ------
        SceneError : an output time has passed and was not kept, or the end has passed
        """
        if time.end < self.time * (1 - SAME):
            text = f"lies before {self.time:g} s, which the checkpoint has reached"
            raise SceneError(
                f"{where.at(('time', 'end'))}: time.end = {time.end:g}: {text}"
            )
        passed = [t for t in output_times(time) if t <= self.time * (1 + SAME)]
        missing = [
            t for t in passed if t not in self.kept and abs(t - self.time) > SAME * t
        ]
        if missing:
            text = (
                f"{missing[0]:g} s lies before {self.time:g} s, which the "
                "checkpoint has reached, and was not kept"
            )
            raise SceneError(f"{where.at(('time', 'times'))}: time.times: {text}")
        return replace(
            self, kept={t: self.kept.get(t, (self.vertices, self.u)) for t in passed}
        )

    def keeping(self, time: float) -> History:
        """Return the history that keeps its state as that of an output time."""
        return replace(self, kept={**self.kept, time: (self.vertices, self.u)})

    def table(self) -> dict[str, Array]:
        """Return the outlet over time by column, without the flow of the gas."""
        found = dict(zip(self.columns, np.array(self.outlet).T, strict=True))
        found.pop(FLOW, None)
        return found


def output_times(time: Time) -> Sequence[float]:
    """Return the times at which profiles are kept, the end included [s]."""
    return sorted({*time.times, time.end} - {0.0})
