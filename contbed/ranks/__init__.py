"""Several ranks of MPI, by DOLFINx and PETSc; no other room imports this one but
`contbed.runner`.

To read in this order: `group` (rank 0 and what all ranks run), `engine` (a scene on all
ranks), `system` and `parts` (meshes and compiled forms on rank 0 and on each rank),
`petsc` (matrices), `two_fluid` (parts of a grid).
"""
