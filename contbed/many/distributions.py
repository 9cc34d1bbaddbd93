"""Distributions of uncertain keys, in samples and as what is known before a
calibration.

Each one is even or normal in a coordinate w, which is the value or its logarithm; the
scaled coordinate z is w less its mean over its standard deviation, so that z has mean 0
and standard deviation 1 whatever the key.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from contbed.arrays import Array

# Half the width of an even distribution over its standard deviation, the root of 3
HALF_WIDTH = math.sqrt(3.0)


@dataclass(frozen=True)
class Distribution:
    """A distribution of a number in SI.

    low, high : ends of an even distribution; of a normal one, the value at z = 0 and
        that at z = 1
    even : even between the ends and nothing outside, or normal
    logarithmic : the logarithm of the value is distributed so
    whole : integers from the low to the high end alone, each as likely as the others
    """

    low: float
    high: float
    even: bool
    logarithmic: bool = False
    whole: bool = False

    def __call__(self, u: Array) -> Array:
        """Return the values below which a share `u` of the distribution lies, of the
        shape of `u`.
        """
        if self.whole:
            return np.minimum(
                self.low + np.floor(u * (self.high - self.low + 1.0)), self.high
            )
        if self.even and not self.logarithmic:
            return self.low + u * (self.high - self.low)
        if self.even:
            return self.low * np.exp(u * math.log(self.high / self.low))
        from scipy.special import ndtri

        return self.value(ndtri(u))

    def value(self, z: Array | float) -> Array:
        """Return the values at scaled coordinates, of the same shape."""
        z = np.asarray(z, dtype=float)
        if self.even:
            return self(0.5 * (1.0 + z / HALF_WIDTH))
        if self.logarithmic:
            return self.low * np.exp(z * math.log(self.high / self.low))
        return self.low + z * (self.high - self.low)

    def scaled(self, value: Array | float) -> Array:
        """Return the scaled coordinates of values, of the same shape."""
        value = np.asarray(value, dtype=float)
        if self.logarithmic:
            share = np.log(value / self.low) / math.log(self.high / self.low)
        else:
            share = (value - self.low) / (self.high - self.low)
        return np.asarray(HALF_WIDTH * (2.0 * share - 1.0) if self.even else share)

    def slope(self, z: float) -> float:
        """Return the derivative of the value with respect to the scaled coordinate."""
        width = (
            math.log(self.high / self.low) if self.logarithmic else self.high - self.low
        )
        each = width / (2.0 * HALF_WIDTH) if self.even else width
        return each * float(self.value(z)) if self.logarithmic else each

    @property
    def bounds(self) -> tuple[float, float]:
        """The scaled coordinates between which values are possible."""
        return (-HALF_WIDTH, HALF_WIDTH) if self.even else (-math.inf, math.inf)

    @property
    def mean(self) -> float:
        """Mean of the values."""
        if not self.logarithmic:
            return 0.5 * (self.low + self.high) if self.even else self.low
        width = math.log(self.high / self.low)
        return (
            (self.high - self.low) / width
            if self.even
            else self.low * math.exp(0.5 * width**2)
        )

    @property
    def deviation(self) -> float:
        """Standard deviation of the values."""
        if self.whole:
            return math.sqrt(((self.high - self.low + 1.0) ** 2 - 1.0) / 12.0)
        if not self.logarithmic:
            return abs(self.high - self.low) / (2.0 * HALF_WIDTH if self.even else 1.0)
        width = math.log(self.high / self.low)
        if self.even:
            return math.sqrt(
                (self.high**2 - self.low**2) / (2.0 * width) - self.mean**2
            )
        return abs(self.mean) * math.sqrt(math.expm1(width**2))

    def __str__(self) -> str:
        """Return the distribution in words, numbers in SI."""
        logarithm = " in its logarithm" if self.logarithmic else ""
        if self.whole:
            return f"integers from {self.low:.6g} to {self.high:.6g}"
        if self.even:
            return f"even{logarithm} from {self.low:.6g} to {self.high:.6g}"
        if self.logarithmic:
            return (
                f"log-normal about {self.low:.6g} with a factor of "
                f"{self.high / self.low:.6g}"
            )
        return (
            f"normal about {self.low:.6g} with a standard deviation of "
            f"{self.high - self.low:.6g}"
        )
