"""How kernels are compiled, the types of their arguments, and two constants that all of them share.

Kernels are kept on disk; a division by zero gives infinity as in numpy. Kernels of the kind `summing` may take sums in
another order than written, always the same one.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar, cast

import numpy as np
from numba import njit
from numpy.typing import NDArray

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]
Indices = NDArray[np.int64]
Function = TypeVar("Function", bound=Callable[..., object])

SMALLEST = 1e-300  # added to a denominator that may be zero
UNDERFLOW = 1e-60  # magnitudes below count as zero: products of two of them would be slow subnormal numbers


def kernel(function: Function) -> Function:
    """Compile a function of arrays."""
    return cast(Function, njit(cache=True, error_model="numpy")(function))


def summing(function: Function) -> Function:
    """Compile a function whose sums may be reordered into vectors."""
    return cast(Function, njit(cache=True, error_model="numpy", fastmath={"reassoc", "contract"})(function))
