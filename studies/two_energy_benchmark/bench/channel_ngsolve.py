"""The Brinkman channel of a scene in NGSolve: Taylor-Hood flow by Newton from plug
flow, then quadratic temperatures.

    channel_ngsolve.py SCENE SOLVER [compile] [condense]

The mesh has the cells of the scene. Plain Galerkin, which is less work than the
stabilised forms of contbed.
"""

import json
import sys
import tomllib
from pathlib import Path

import ngsolve as ng
import numpy as np
from ngsolve.meshes import MakeStructured2DMesh

scene_file, solver, *options = sys.argv[1:]
ng.SetNumThreads(1)
condense = "condense" in options
scene = tomllib.loads(Path(scene_file).read_text(encoding="utf-8"))
fluid, solid, grid = scene["gas"], scene["solids"]["particles"], scene["mesh"]
length, height, eps = grid["length"], grid["height"], scene["packed_bed"]["porosity"]
left = scene["boundary"]["left"]
rho, mu = fluid["density"], fluid["viscosity"]
# the closures of the scene
K, c_F, ha = 2.025e-5, 0.16735113224353035, 3581.039775375903
plug, moving = (
    ng.CF((left["gas"]["velocity"], 0)),
    ng.CF((left["solids"]["particles"]["velocity"], 0)),
)


def compiled(integrand: ng.CoefficientFunction) -> ng.CoefficientFunction:
    return integrand.Compile() if "compile" in options else integrand


mesh = MakeStructured2DMesh(
    quads=grid["shape"] == "quadrilateral",
    nx=grid["cells"][0],
    ny=grid["cells"][1],
    mapping=lambda x, y: (length * x, height * y),
)
inlet, outlet, walls = (
    mesh.Boundaries(name) for name in ("left", "right", "bottom|top")
)

# flow: plug flow, at rest on the walls, the inlet keeps its corners
velocities = ng.VectorH1(mesh, order=2, dirichlet="left|bottom|top")
space = velocities * ng.H1(mesh, order=1)
(u, p), (v, q) = space.TnT()
flow = ng.GridFunction(space)
velocity = flow.components[0]
velocity.Set(plug)
values, at_inlet = velocity.vec.FV().NumPy(), np.array(list(velocities.GetDofs(inlet)))
entering = values[at_inlet].copy()
values[np.array(list(velocities.GetDofs(walls)))] = 0.0
values[at_inlet] = entering
w = u - moving
drag = eps * (mu / K + rho * c_F / K**0.5 * ng.sqrt(ng.InnerProduct(w, w) + 1e-19))
inertia = rho / eps * ng.InnerProduct(ng.grad(u) * u, v)
viscous = mu * ng.InnerProduct(ng.grad(u), ng.grad(v))
balance = ng.BilinearForm(space, condense=condense)
balance += (
    compiled(
        inertia + viscous + drag * ng.InnerProduct(w, v) - p * ng.div(v) - q * ng.div(u)
    )
    * ng.dx
)
residual, step = flow.vec.CreateVector(), flow.vec.CreateVector()
free = ng.Projector(space.FreeDofs(), True)
balance.Apply(flow.vec, residual)
free.Project(residual)
scale = ng.Norm(residual)
for _ in range(20):
    balance.AssembleLinearization(flow.vec)
    if condense:
        residual.data += balance.harmonic_extension_trans * residual
    step.data = balance.mat.Inverse(space.FreeDofs(condense), inverse=solver) * residual
    if condense:
        step.data += balance.inner_solve * residual
        step.data += balance.harmonic_extension * step
    flow.vec.data -= step
    balance.Apply(flow.vec, residual)
    free.Project(residual)
    if ng.Norm(residual) <= 1e-12 * scale or ng.Norm(step) <= 1e-10 * ng.Norm(flow.vec):
        break
else:
    sys.exit(f"Newton does not converge with {solver}")

# temperatures
scalar = ng.H1(mesh, order=2, dirichlet="left")
space = scalar * scalar
(f, s), (a, b) = space.TnT()
T = ng.GridFunction(space)
T_fluid, T_solid = T.components
T_fluid.Set(scene["boundary"]["left"]["gas"]["fixed_temperature"], definedon=inlet)
T_solid.Set(
    scene["boundary"]["left"]["solids"]["particles"]["fixed_temperature"],
    definedon=inlet,
)
heat = ng.BilinearForm(space, condense=condense)
terms = rho * fluid["heat_capacity"] * (velocity * ng.grad(f)) * a
terms += eps * fluid["conductivity"] * ng.grad(f) * ng.grad(a)
terms += solid["density"] * solid["heat_capacity"] * (moving * ng.grad(s)) * b
terms += (1 - eps) * solid["conductivity"] * ng.grad(s) * ng.grad(b)
heat += compiled(terms + ha * (f - s) * (a - b)) * ng.dx
heat.Assemble()
residual = T.vec.CreateVector()
residual.data = heat.mat * T.vec
T.vec.data -= heat.mat.Inverse(space.FreeDofs(condense), inverse=solver) * residual
if condense:
    T.vec.data += heat.harmonic_extension * T.vec

through = ng.Integrate(velocity[0], mesh, ng.BND, definedon=outlet)
mean = ng.Integrate(velocity[0] * T_fluid, mesh, ng.BND, definedon=outlet) / through
mean_solid = ng.Integrate(T_solid, mesh, ng.BND, definedon=outlet) / height
print(json.dumps({"T_fluid_out_K": mean, "T_solid_out_K": mean_solid}))
