"""Streams through the boundaries of a packed bed: mass flows, mean temperatures,
outlet temperatures over time.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from contbed.arrays import Array
from contbed.fem.ad.dual import plain
from contbed.fem.skfem import Ops
from contbed.packed_bed.schedule import PHASES

Streams = dict[str, tuple[float, float]]


def streams(problem: Any, state: Any) -> tuple[Streams, Streams]:
    """Return mass flow and mass-weighted mean temperature by phase, of the streams
    that leave and that enter.
    """
    sums: dict[tuple[str, bool], list[float]] = {}
    for name, part, wall in sorted(
        problem.boundary_terms, key=lambda item: item[2].name
    ):
        if wall.mass_flux is None:
            continue
        out = problem.system.integrate(
            lambda u, o, c=wall: o.dot(c.mass_flux, o.n), [part], state
        )
        carried = problem.system.integrate(
            lambda u, o, c=wall: o.dot(c.mass_flux, o.n) * getattr(u, c.name),
            [part],
            state,
        )
        phase = wall.phase
        condition = problem.build.condition(name, phase)
        if out < 0 and condition is not None and condition.temperature is not None:
            # conduction makes the bed differ from the stream that enters it
            carried = out * condition.temperature
        total = sums.setdefault((phase, out > 0), [0.0, 0.0])
        total[0] += abs(out)
        total[1] += carried if out > 0 else -carried
    leaving, entering = (
        {
            phase: (flow, heat / flow)
            for (phase, leaves), (flow, heat) in sums.items()
            if leaves == wanted and flow > 0
        }
        for wanted in (True, False)
    )
    return leaving, entering


class Outlets:
    """Mean temperatures of the streams that leave, step by step; on a line they are
    those of its end.
    """

    def __init__(self, problem: Any, state: Any):
        self.problem = problem
        self.node: dict[str, int] | None = None
        if problem.mesh.skfem.dim() == 1:
            leaving, _ = streams(problem, state)
            ends = problem.mesh.skfem.boundaries
            self.node = {
                wall.phase: int(problem.system.nodes(wall.name, ends[name])[0])
                for name, part, wall in problem.boundary_terms
                if wall.phase in leaving and _leaves(part, wall)
            }

    def __call__(self, time: float, state: Any) -> tuple[float, ...]:
        """Return the time [s] and the temperature of each phase [K], NaN for one
        that does not leave.
        """
        if self.node is not None:
            found = {phase: float(state[node]) for phase, node in self.node.items()}
        else:
            found = {
                phase: T for phase, (_, T) in streams(self.problem, state)[0].items()
            }
        return (time, *(found.get(phase, np.nan) for phase in PHASES))


def _leaves(part: Any, wall: Any) -> bool:
    if wall.mass_flux is None:
        return False
    return float(np.sum(part.weight * plain(Ops.dot(wall.mass_flux, part.n)))) > 0.0


def outlet_table(rows: list[tuple[float, ...]]) -> dict[str, Array]:
    """Return the outlet over time by column, without phases that never leave."""
    values = np.array([row[: 1 + len(PHASES)] for row in rows]).T
    columns = {"t [s]": values[0]} | {
        f"T_{phase}_out [K]": T for phase, T in zip(PHASES, values[1:], strict=True)
    }
    return {
        name: column for name, column in columns.items() if np.isfinite(column).any()
    }
