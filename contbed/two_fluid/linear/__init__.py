"""Linear systems on cells and faces: conjugate gradients, multigrid, banded
elimination.
"""
