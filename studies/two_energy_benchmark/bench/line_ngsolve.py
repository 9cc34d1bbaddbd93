"""The slip row of Pivem & de Lemos in NGSolve on uniform triangles: user time and
largest error.

line_ngsolve.py DEGREE CELLS...
"""

import sys

import ngsolve as ng
import numpy as np
from common import coefficients, largest_error, report, timed
from ngsolve.meshes import MakeStructured2DMesh

POINTS = 401


def solve(
    degree: int, along: int, c: dict[str, float]
) -> tuple[ng.Mesh, ng.GridFunction]:
    """Mesh and both temperatures."""
    length, height = c["length"], c["height"]
    across = max(1, round(along * height / length))
    mesh = MakeStructured2DMesh(
        quads=False, nx=along, ny=across, mapping=lambda x, y: (length * x, height * y)
    )
    scalar = ng.H1(mesh, order=degree, dirichlet="left")
    space = scalar * scalar
    (fluid, solid), (v, w) = space.TnT()
    form = ng.BilinearForm(space)
    form += (
        c["flux_fluid"] * ng.grad(fluid)[0] * v
        + c["d_fluid"] * ng.grad(fluid) * ng.grad(v)
    ) * ng.dx
    form += (
        c["flux_solid"] * ng.grad(solid)[0] * w
        + c["d_solid"] * ng.grad(solid) * ng.grad(w)
    ) * ng.dx
    form += c["ha"] * (fluid - solid) * (v - w) * ng.dx
    form.Assemble()
    theta = ng.GridFunction(space)
    theta.components[1].Set(1.0, definedon=mesh.Boundaries("left"))
    residual = theta.vec.CreateVector()
    residual.data = form.mat * theta.vec
    theta.vec.data -= form.mat.Inverse(space.FreeDofs(), inverse="umfpack") * residual
    return mesh, theta


def main() -> None:
    ng.SetNumThreads(1)
    degree, *sizes = map(int, sys.argv[1:])
    c = coefficients()
    x = np.linspace(0.0, c["length"], POINTS)
    for along in sizes:
        seconds, (mesh, theta) = timed(lambda along=along: solve(degree, along, c))
        points = mesh(x, np.full(POINTS, 0.5 * c["height"]))
        fluid, solid = (component(points).ravel() for component in theta.components)
        report(theta.space.ndof, largest_error(x, fluid, solid, c), seconds)


main()
