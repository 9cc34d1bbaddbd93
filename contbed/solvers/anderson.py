"""Fixed points of a map that is costly, y = Phi(y), by Anderson's acceleration.

    y_new = Phi(y) - sum_j gamma_j (Phi_(j+1) - Phi_j)
    gamma minimises |F - sum_j gamma_j (F_(j+1) - F_j)|,    F = Phi(y) - y

over the last `DEPTH` evaluations; for a linear map this is GMRES.

Source: Anderson, J. ACM 12 (1965) 547, doi:10.1145/321296.321305; Walker, Ni, SIAM J.
    Numer. Anal. 49 (2011) 1715,
doi:10.1137/10078356X.
"""

from __future__ import annotations

from typing import Any

import numpy as np

DEPTH = 25  # former evaluations that are combined


class Anderson:
    """Gives the next state from a state and its image; it remembers former pairs."""

    def __init__(self) -> None:
        self._images: list[Any] = []
        self._changes: list[Any] = []

    def __call__(self, state: Any, image: Any) -> Any:
        """Return the next state (n,); it is the image where nothing else is known."""
        self._images.append(image)
        self._changes.append(image - state)
        del self._images[: -DEPTH - 1], self._changes[: -DEPTH - 1]
        if len(self._images) == 1:
            return image
        columns = np.diff(np.array(self._changes), axis=0).T
        gamma = np.linalg.lstsq(columns, self._changes[-1], rcond=1e-12)[0]
        return image - np.diff(np.array(self._images), axis=0).T @ gamma

    def __len__(self) -> int:
        """Return the number of pairs that are remembered."""
        return len(self._images)

    def forget(self) -> None:
        """Forget all pairs, as where the map has changed."""
        self._images.clear()
        self._changes.clear()
