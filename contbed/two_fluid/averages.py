"""Averages of a two-fluid run: in time, by phase, along and across the bed, and how far
they have converged.

The granular temperature of the model misses the motion that the grid resolves; what a
tracer would show is

    theta_total = <theta> + sum over directions of var(u_solid)/3

with phase-weighted averages <.> and variances; in a plane the missing direction counts
as the lateral one again.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from contbed.two_fluid import momentum_budget
from contbed.two_fluid.simulation import Simulation

HALVES = 2
# of `Averages.arrays`, those that do not list cells
OF_BED = ("weight", "momentum", "sum_forces")


@dataclass
class Averages:
    """Sums over time of each half of the window, weighted by the steps; `momentum`
    after the last step.

    On the part of a bed that one rank has, they are those of its own cells; OF_BED are
    of the whole bed.
    """

    start: float
    end: float
    weight: np.ndarray = field(default_factory=lambda: np.zeros(HALVES))
    sums: dict[str, np.ndarray] = field(default_factory=dict)
    momentum: float = 0.0

    def add(self, bed: Simulation) -> None:
        """Take the last step of the bed into account."""
        if self.open_later(bed):
            return
        before, self.momentum = self.momentum, momentum_budget.momentum(bed)
        if bed.clock.time <= self.start:
            return
        half = min(
            int(HALVES * (bed.state.time - self.start) / (self.end - self.start)),
            HALVES - 1,
        )
        own = bed.model.grid.halo.cells
        fields = {name: values[own] for name, values in bed.state.fields().items()}
        s, u_solid = fields["eps_s"], fields["u_solid"]
        now = {
            "eps_s": s,
            "theta": s * fields["theta"],
            "p": fields["p"],
            "u_gas": (1.0 - s[:, None]) * fields["u_gas"],
            "u_solid": s[:, None] * u_solid,
            "square": s[:, None] * u_solid**2,
            "speed": s * np.linalg.norm(u_solid, axis=1),
            "forces": momentum_budget.forces(bed, before),
        }
        if "T_gas" in fields:
            now |= {
                "T_gas": (1.0 - s) * fields["T_gas"],
                "T_solid": s * fields["T_solid"],
            }
        self.weight[half] += bed.state.dt
        for name, value in now.items():
            if name not in self.sums:
                self.sums[name] = np.zeros((HALVES, *value.shape))
            self.sums[name][half] += bed.state.dt * value

    def open_later(self, bed: Simulation) -> bool:
        """Return whether the next step of the bed is not in the window either, so
        that this one does not matter.
        """
        clock, growth = bed.clock, max(1.0, bed.model.options.growth)
        return clock.time + growth * max(clock.dt, clock.dt_wanted) <= self.start

    def whole(self) -> Averages:
        """Return the averages of the whole bed, which are these."""
        return self

    def means(self, half: int | None = None) -> dict[str, np.ndarray]:
        """Return fields of averages, of all or of one half.

        They are eps_s, p, phase-weighted velocities and speed of the particles,
        temperatures, theta and theta_total.
        """
        weight = self.weight.sum() if half is None else self.weight[half]
        pick = slice(None) if half is None else slice(half, half + 1)
        mean = {
            name: value[pick].sum(axis=0) / weight for name, value in self.sums.items()
        }
        s = np.maximum(mean["eps_s"], 1e-12)
        u = mean["u_solid"] / s[:, None]
        variance = np.maximum(mean["square"] / s[:, None] - u**2, 0.0)
        # the directions that are not there count as the first one
        total = variance.sum(axis=1) + (3 - u.shape[1]) * variance[:, 0] * (
            u.shape[1] > 1
        )
        share = {"T_gas": 1.0 - mean["eps_s"], "T_solid": s}
        warm = {name: mean[name] / share[name] for name in share if name in mean}
        return warm | {
            "eps_s": mean["eps_s"],
            "p": mean["p"],
            "u_gas": mean["u_gas"] / (1.0 - mean["eps_s"])[:, None],
            "u_solid": u,
            "speed_solid": mean["speed"] / s,
            "theta": mean["theta"] / s,
            "theta_total": mean["theta"] / s + total / 3.0,
        }

    def forces(self) -> np.ndarray:
        """Return the means of `momentum_budget.forces` [N]."""
        return np.asarray(self.sums["forces"].sum(axis=0) / self.weight.sum())

    def drift(self) -> float:
        """Largest difference of the two halves in eps_s, over its mean: 0 for
        converged averages.
        """
        if not (self.weight > 0).all():
            return float("nan")
        first, second = self.means(0)["eps_s"], self.means(1)["eps_s"]
        return float(
            np.abs(first - second).mean()
            / max(float((first + second).mean()) / 2, 1e-300)
        )

    def arrays(self) -> dict[str, np.ndarray]:
        """For a checkpoint."""
        sums = {f"sum_{name}": value for name, value in self.sums.items()}
        return {"weight": self.weight, "momentum": np.array(self.momentum), **sums}

    def resume(self, arrays: dict[str, np.ndarray]) -> None:
        """Back to what `arrays` gave."""
        self.weight, self.momentum = (
            np.array(arrays["weight"]),
            float(arrays["momentum"]),
        )
        self.sums = {
            name[4:]: np.array(value)
            for name, value in arrays.items()
            if name.startswith("sum_")
        }


def along(
    position: np.ndarray,
    volume: np.ndarray,
    values: dict[str, np.ndarray],
    weights: dict[str, np.ndarray],
    bins: int,
) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Means of cells in equal bins of a coordinate: the coordinate of the bins that
    hold cells, and each value.

    `weights` names what a value is weighted by besides the volume, such as the fraction
    of the phase. Where a phase is not, its temperature is not a number, other means of
    it are 0.
    """
    low, high = position.min(), position.max()
    which = np.minimum(
        ((position - low) / max(high - low, 1e-300) * bins).astype(int), bins - 1
    )
    held = np.bincount(which, volume, bins)
    there = held > 0
    place = np.bincount(which, volume * position, bins)[there] / held[there]
    out = {}
    for name, value in values.items():
        weight = volume * weights.get(name, 1.0)
        total = np.bincount(which, weight, bins)[there]
        out[name] = np.bincount(which, weight * value, bins)[there] / np.maximum(
            total, 1e-300
        )
        if name.endswith(" [K]"):
            out[name] = np.where(total > 0.0, out[name], np.nan)
    return place, out


def spectrum(t: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Frequencies [Hz] and power per frequency of an evenly sampled series, without
    its mean, Hann window.
    """
    step = (t[-1] - t[0]) / (len(t) - 1)
    window = np.hanning(len(values))
    power = (
        np.abs(np.fft.rfft((values - values.mean()) * window)) ** 2
        * 2.0
        * step
        / np.sum(window**2)
    )
    return np.fft.rfftfreq(len(values), step)[1:], power[1:]
