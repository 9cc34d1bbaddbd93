"""What a linear system costs on each engine, and which engine a scene wants.

The rates are processor seconds for one assembly and solution of a million unknowns, the power with which time grows,
and bytes an unknown at the peak, all of them measured by studies/scaling on one core of a 2-core x86-64 machine. Memory
is that of the whole run; with several ranks it is shared but for `LEADER`, the part that the first rank holds alone.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil

from contbed.solve.linear import Policy, free_memory_GB

LEADER = 1.2e3  # bytes an unknown
LONG = 600.0  # [s] for a linear system beyond which ranks are worth their trouble


@dataclass(frozen=True)
class Rate:
    """Seconds for a million unknowns, the power of growth, bytes an unknown."""

    seconds: float
    power: float
    memory: float

    def time(self, size: int) -> float:
        """[s]"""
        return self.seconds * (size / 1e6) ** self.power

    def memory_GB(self, size: int) -> float:
        """[GB]"""
        return 1e-9 * self.memory * size


# by engine and dimension of the mesh; in 3-D scikit-fem's is for factors at 30 000 unknowns, which grow as n^(4/3)
RATES = {
    ("skfem", 1): Rate(4.0, 1.0, 400.0),
    ("skfem", 2): Rate(20.0, 1.15, 5000.0),
    ("skfem", 3): Rate(600.0, 1.6, 8e3),
    ("dolfinx", 1): Rate(3.0, 1.0, 700.0),
    ("dolfinx", 2): Rate(6.0, 1.1, 3200.0),
    ("dolfinx", 3): Rate(50.0, 1.05, 5200.0),
}


def advice(size: int, policy: Policy) -> str:
    """Which engine a scene with this largest system wants, and what one linear system costs there.

    scikit-fem as long as its factors fit in the memory allowed and time is short, else DOLFINx on as many ranks as
    bring the time below `LONG`.
    """
    dimension = policy.dimension
    one, other = RATES["skfem", dimension], RATES["dolfinx", dimension]
    need = policy.predicted_GB(size)
    limit = policy.limit_GB if policy.limit_GB is not None else 0.6 * free_memory_GB()
    seconds = other.time(size)
    cost = f"about {_time(seconds)} of processor and {max(other.memory_GB(size), 0.001):.2g} GB"
    if need <= limit and one.time(size) <= LONG:
        return (f"engine: skfem, about {_time(one.time(size))} of processor and {max(need, 0.001):.2g} GB for each "
                f"linear system; dolfinx {cost}")  # fmt: skip
    why = f"skfem would need {need:.3g} GB of {limit:.3g} GB" if need > limit else (
        f"skfem would take {_time(one.time(size))} for each linear system")  # fmt: skip
    ranks = max(2, ceil(seconds / LONG))
    return f"engine: dolfinx, mpirun -n {ranks}: {cost} for each linear system, all ranks together; {why}"


def _time(seconds: float) -> str:
    if seconds >= 3600.0:
        return f"{seconds / 3600.0:.2g} h"
    return f"{max(seconds, 0.001):.2g} s"
