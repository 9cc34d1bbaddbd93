"""Which engine has room for a steady scene.

Bytes per unknown at the peak, of all ranks together, were measured by studies/scaling;
the ranks share them evenly, except for `ROOT_BYTES`, which only rank 0 needs.
"""

from __future__ import annotations

from contbed.solvers.linear import Policy

ROOT_BYTES = 900.0
PROCESS_GB = 0.15
# on DOLFINx, by dimension of the mesh
BYTES = {1: 900.0, 2: 2900.0, 3: 6600.0}


def memory_GB(dimension: int, size: int) -> float:
    """Return the memory [GB] of DOLFINx for `size` unknowns."""
    return PROCESS_GB + 1e-9 * BYTES[dimension] * size


def advice(unknowns: dict[str, int], policy: Policy) -> str:
    """Say which engine suits a scene with these unknowns of its parts: scikit-fem as
    long as its factors fit in the memory allowed, else DOLFINx.
    """
    size, largest = sum(unknowns.values()), max(unknowns.values())
    need = policy.predicted_GB(largest)
    limit = policy.allowed_GB()
    if need <= limit:
        return "engine: skfem"
    return (
        "engine: dolfinx under mpirun, about "
        f"{memory_GB(policy.dimension, size):.2g} GB on all ranks, and "
        f"{1e-9 * ROOT_BYTES * size:.2g} GB more on rank 0; "
        f"skfem would need {need:.3g} GB of {limit:.3g} GB"
    )
