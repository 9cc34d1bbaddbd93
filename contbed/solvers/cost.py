"""Cost of a steady scene on each engine, and which engine suits it.

The rates are processor seconds of a whole run per million unknowns (flow by Newton in
2-D, heat linear), the power with which time grows, and bytes per unknown at the peak,
measured by studies/scaling on a 2-core x86-64 machine with one thread per rank; those
of multigrid hold for plug flow in 3-D. A transient takes about as much for every few
steps. The ranks share the memory evenly, except for `ROOT_BYTES`, which only rank 0
needs.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil

from contbed.solvers.linear import Policy, free_memory_GB

ROOT_BYTES = 900.0  # bytes per unknown on rank 0
LONG_RUN = 1800.0  # [s] a run that takes longer is advised to use MPI
START_UP = 1.2  # [s] of any run


@dataclass(frozen=True)
class Rate:
    """Processor time [s] for a million unknowns, the power of its growth, and
    memory [bytes] per unknown.
    """

    seconds: float
    power: float
    memory: float

    def time(self, size: int) -> float:
        """Return the processor time [s] for `size` unknowns."""
        return START_UP + self.seconds * float((size / 1e6) ** self.power)

    def memory_GB(self, size: int) -> float:
        """Return the memory [GB] for `size` unknowns."""
        return 0.15 + 1e-9 * self.memory * size


# by engine and dimension of the mesh; factors in 3-D grow faster than their memory,
# n^(4/3)
RATES = {
    ("skfem", 1): Rate(6.0, 1.0, 400.0),
    ("skfem", 2): Rate(50.0, 1.25, 4000.0),
    ("skfem", 3): Rate(1000.0, 1.6, 20e3),
    ("multigrid", 3): Rate(55.0, 1.1, 10e3),
    ("dolfinx", 1): Rate(7.0, 1.0, 900.0),
    ("dolfinx", 2): Rate(21.0, 1.15, 2900.0),
    ("dolfinx", 3): Rate(55.0, 1.05, 6600.0),
}


def _rate(policy: Policy) -> Rate:
    return RATES[
        "multigrid" if policy.multigrid and policy.dimension == 3 else "skfem",
        policy.dimension,
    ]


def advice(
    unknowns: dict[str, int], policy: Policy, run: str = "a steady scene"
) -> str:
    """Say which engine suits a scene with these unknowns of its parts, and what the
    scene costs there.

    `run` names what these costs are for.

    scikit-fem as long as its factors fit in the memory allowed and time is short, else
    DOLFINx on as many ranks as bring the time below `LONG_RUN`.
    """
    size, largest = sum(unknowns.values()), max(unknowns.values())
    one, other = _rate(policy), RATES["dolfinx", policy.dimension]
    need = policy.predicted_GB(largest)
    limit = policy.limit_GB if policy.limit_GB is not None else 0.6 * free_memory_GB()
    there = (
        f"about {_time(other.time(size))} of processor and "
        f"{other.memory_GB(size):.2g} GB"
    )
    if need <= limit and one.time(size) <= LONG_RUN:
        return (
            f"engine: skfem, about {_time(one.time(size))} of processor for {run}; "
            f"dolfinx {there}"
        )
    why = (
        f"skfem would need {need:.3g} GB of {limit:.3g} GB"
        if need > limit
        else (f"skfem would take {_time(one.time(size))}")
    )
    ranks = max(2, ceil(other.time(size) / LONG_RUN))
    first = 0.15 + 1e-9 * ROOT_BYTES * size + other.memory_GB(size) / ranks
    return (
        f"engine: dolfinx, mpirun -n {ranks}: {there} for {run}, {first:.2g} GB of "
        f"it on rank 0; {why}"
    )


def _time(seconds: float) -> str:
    return (
        f"{seconds / 3600.0:.2g} h"
        if seconds >= 3600.0
        else f"{seconds:.{0 if seconds >= 10.0 else 1}f} s"
    )
