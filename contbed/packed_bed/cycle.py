"""Cyclic steady state of a packed bed: temperatures over the span of the scene."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np

from contbed.packed_bed.transient import HeatHistory, HeatSteps


class HeatCycle:
    """What a packed bed says of its cycle: all of its state is stored."""

    def __init__(self, steps: HeatSteps):
        self.steps = steps

    def scale(self, after: HeatHistory) -> Any:
        """Return the span of temperatures, as that of each unknown."""
        return self.steps.span / np.broadcast_to(
            self.steps.problem.weights, after.state.shape
        )

    def stored(self, state: Any, scale: Any) -> Any:
        """Return the state over its scale."""
        return state / scale

    def begun(self, values: Any, scale: Any, after: HeatHistory) -> HeatHistory:
        """Return the history at the start of a period from an extrapolated state."""
        return self.again(replace(after, state=values * scale))

    def again(self, after: HeatHistory) -> HeatHistory:
        """Return the history at the start of a period from a state."""
        first, vertices = self.steps.control.first, after.vertices
        return HeatHistory(state=after.state, size=first, vertices=vertices)
