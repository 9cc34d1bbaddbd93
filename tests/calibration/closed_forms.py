"""Models in closed form for tests of the fit: they are given scaled keys, as runs of
scenes are.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from contbed.many.calibrate.fit import Data
from contbed.many.distributions import Distribution


class ClosedForm:
    """A model of named keys; `calls` counts how often it was evaluated,
    `fails(keys)` says where it has no result.
    """

    def __init__(
        self,
        function: Callable[..., object],
        priors: Sequence[Distribution],
        fails=lambda keys: False,
    ):
        self.function, self.priors, self.fails, self.calls = function, priors, fails, 0

    def values(self, z):
        self.calls += len(z)
        keys = np.column_stack(
            [prior.value(z[:, k]) for k, prior in enumerate(self.priors)]
        )
        found = np.array([self.function(*row) for row in keys], dtype=float)
        found[[bool(self.fails(row)) for row in keys]] = np.nan
        return found

    def slopes(self, z):
        return None


def data(values, error, groups=None) -> Data:
    """All values of a model, as they follow each other in one series, or each by
    itself.
    """
    count = len(values)
    return Data(
        np.arange(count),
        np.asarray(values, dtype=float),
        np.broadcast_to(np.asarray(error, dtype=float), count).copy(),
        np.arange(count) if groups is None else np.asarray(groups),
    )
