"""How kernels are compiled, the types of their arguments, and two constants that all of
them share.

Kernels are kept on disk, and several threads may run them at the same time; a division
by zero gives infinity as in numpy. Kernels of the kind `summing` may take sums in
another order than written, always the same one. Those of the kind `inner` are called by
other kernels only.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import llvmlite.binding as llvm
import numpy as np
from numpy.typing import NDArray

from contbed.compiled import functions

Array = NDArray[np.float64]
Flags = NDArray[np.bool_]
Indices = NDArray[np.int64]
Function = TypeVar("Function", bound=Callable[..., object])

PLAIN: dict[str, Any] = {"cache": True, "error_model": "numpy", "nogil": True}
SUMS = {"reassoc", "contract"}
HERE = Path(__file__).parent
CONTENT = functions.digest(
    [*HERE.rglob("*.py"), HERE.parent / "compiled" / "barrier.py"]
)

# pairs of arrays in a loop up to which LLVM compares their addresses, so as to make
# vectors of the loop; with its defaults of 8 and 128 it leaves out loops over faces,
# which read 17 arrays and write 8
MAX_ALIAS_CHECKS = 300
for option in ("runtime-memory-check-threshold", "vectorize-memory-check-threshold"):
    llvm.set_option("", f"-{option}={MAX_ALIAS_CHECKS}")

SMALLEST = 1e-300  # added to a denominator that may be zero
# where loops over a row start: an unsigned number as its indices are
ZERO = np.uint64(0)
# magnitudes below count as zero: products of two of them would be slow subnormal
# numbers
UNDERFLOW = 1e-60


def kernel(function: Function) -> Function:
    """Compile a function of arrays."""
    return functions.tied(functions.entry(**PLAIN)(function), CONTENT)


def summing(function: Function) -> Function:
    """Compile a function whose sums may be reordered into vectors."""
    return functions.tied(functions.entry(**PLAIN, fastmath=SUMS)(function), CONTENT)


def inner(function: Function) -> Function:
    """Compile a function that only kernels call."""
    return functions.tied(functions.inner(**PLAIN)(function), CONTENT)


def inner_summing(function: Function) -> Function:
    """Compile a function that only kernels call, and whose sums may be reordered
    into vectors.
    """
    return functions.tied(functions.inner(**PLAIN, fastmath=SUMS)(function), CONTENT)
