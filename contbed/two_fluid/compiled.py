"""How kernels are compiled: kept on disk, a division by zero gives infinity as in numpy.

Kernels of the kind `summing` may take sums in another order than written, always the same one.
"""

from numba import njit

kernel = njit(cache=True, error_model="numpy")
summing = njit(cache=True, error_model="numpy", fastmath={"reassoc", "contract"})
