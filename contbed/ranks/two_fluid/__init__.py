"""A two-fluid bed on several ranks: parts of its grid, their ghost cells, the
pressure equation by PETSc.
"""
