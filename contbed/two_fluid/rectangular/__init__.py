"""Kernels of the two-fluid step for rectangular grids, over rows of faces and of cells.

Each gives the numbers of the kernel of the same name for any mesh, to rounding, and
calls the same functions for the physics of a face. Vectors are (dim, nc) and their
gradients (direction, component, nc) in memory: the transposed arrays of the state.
Loops over a row have no branches that a vector unit cannot take, and never add to two
cells of a face at once: first to all cells on the left, then to all on the right.
"""
