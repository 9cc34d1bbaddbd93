"""How kernels are compiled: kept on disk, a division by zero gives infinity as in numpy."""

from numba import njit

kernel = njit(cache=True, error_model="numpy")
