"""Memory of runs that factor no matrix."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True)
class MemoryPerUnknown:
    """Takes the place of a policy of linear solvers where no matrix is factored:
    bytes for each unknown.
    """

    bytes_each: float

    def predicted_GB(self, size: int) -> float:
        """Predict the memory of a run [GB]."""
        return 1e-9 * self.bytes_each * size
