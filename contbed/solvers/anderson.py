"""Fixed points of a map that is costly, y = Phi(y), by Anderson's acceleration.

    y_new = Phi(y) - sum_j gamma_j (Phi_(j+1) - Phi_j)
    gamma minimises |F - sum_j gamma_j (F_(j+1) - F_j)|,    F = Phi(y) - y

over the last `DEPTH` evaluations; for a linear map this is GMRES.

Source: Anderson, J. ACM 12 (1965) 547, doi:10.1145/321296.321305; Walker, Ni, SIAM J.
    Numer. Anal. 49 (2011) 1715,
doi:10.1137/10078356X.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

DEPTH = 25  # former evaluations that are combined


class Anderson:
    """Gives the next state from a state and its image.

    `pairs` are the images and changes of former calls, at most `DEPTH` + 1.
    """

    def __init__(self, pairs: Sequence[tuple[Any, Any]] = ()) -> None:
        self.pairs = tuple(pairs)

    def __call__(self, state: Any, image: Any) -> Any:
        """Return the next state (n,); it is the image where nothing else is known."""
        self.pairs = (*self.pairs, (image, image - state))[-DEPTH - 1 :]
        if len(self.pairs) == 1:
            return image
        images, changes = (np.array(each) for each in zip(*self.pairs, strict=True))
        columns = np.diff(changes, axis=0).T
        gamma = np.linalg.lstsq(columns, changes[-1], rcond=1e-12)[0]
        return image - np.diff(images, axis=0).T @ gamma
