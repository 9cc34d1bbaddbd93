"""The peer: cases for OpenFOAM's twoPhaseEulerFoam (v1912, Debian package `openfoam`),
written, run and read.

The riser of Vaishali et al. and the bed of Taghipour et al. have the closures that
contbed uses in the scenes beside them: Gidaspow viscosity, Syamlal conductivity, Lun
pressure, Sinclair-Jackson radial distribution, Johnson-Jackson friction, no virtual
mass, laminar gas, one outer and two pressure correctors. Two columns between slip walls
have a pressure of the particles that depends on their fraction alone: glass that
settles in water, and a Riemann problem.
"""

from studies._gallery.openfoam.case import BED_FRACTION, BED_HEIGHT, SOLVER, Case
from studies._gallery.openfoam.files import write
from studies._gallery.openfoam.run import available, field, run, series, times

__all__ = [
    "BED_FRACTION",
    "BED_HEIGHT",
    "SOLVER",
    "Case",
    "available",
    "field",
    "run",
    "series",
    "times",
    "write",
]
