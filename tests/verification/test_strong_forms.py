"""The weak forms against the equations in strong form, at smooth fields: signs,
factors, hoop and boundary terms.

The equations of the model files are differentiated pointwise as they are written
(divergence of fluxes), tested with every basis function, and compared with the form
plus its boundary terms. Both sides differ by quadrature of smooth functions on a few
cells: 1e-8 of the largest entry in the plane, where the rule has order 16, and 1e-5 on
tetrahedra, where the highest rule has order 9.
"""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from manufactured_cases import OPTICS, Flow, Heat, Radiating, mesh

from contbed.fem.skfem import Ops
from contbed.packed_bed.equations import porous_flow, two_energy
from contbed.radiation.equations import p1 as radiation
from studies._exact.manufactured import Manufactured, exact, jet

TOLERANCE = {"line": 1e-8, "triangle": 1e-8, "quadrilateral": 1e-8, "tetrahedron": 1e-5}
SIGMA = 5.670374419e-8
ORDER = {"line": 16, "triangle": 16, "quadrilateral": 16, "tetrahedron": 9}


def heat_strong(
    case: Heat, dim: int, c: two_energy.Coefficients, x: Any
) -> dict[str, Any]:
    """Both balances at points as the equations of the model are written: fluxes
    first, then their divergence.
    """
    velocity = case.velocity(dim)
    jets = {name: jet(function, x) for name, function in case.fields(dim).items()}
    u = [jet(lambda *at, k=k: velocity(*at)[k], x)[0] for k in range(dim)]
    speed = np.sqrt(sum(u_k * u_k for u_k in u))
    transfer = c.exchange(jets["T_fluid"][0], jets["T_solid"][0]) * (
        jets["T_solid"][0] - jets["T_fluid"][0]
    )
    out = {}
    taken_up = 0.0
    if isinstance(case, Radiating):
        taken_up = OPTICS.absorption["T_solid"] * (
            jets["G"][0] - 4.0 * SIGMA * jets["T_solid"][0] ** 4
        )
    for name, other, phase, gain in (
        ("T_fluid", "T_solid", c.fluid, transfer + c.fluid.source),
        ("T_solid", "T_fluid", c.solid, c.solid.source - transfer + taken_up),
    ):
        T, slope = jets[name]
        across, along, _ = phase.dispersion or (0.0, 0.0, None)
        forward = sum(u_k * s for u_k, s in zip(u, slope, strict=True)) / speed
        total = -gain.value
        for k in range(dim):
            mass_flux = u[k] if name == "T_fluid" else phase.mass_flux[k]
            cross = c.cross(0.5 * (T + jets[other][0]))
            conducted = (phase.conductivity(T) + across) * slope[k] + cross * jets[
                other
            ][1][k]
            flux = (
                mass_flux * phase.enthalpy(T)
                - conducted
                - along * forward * u[k] / speed
            )
            total = (
                total
                + flux.tangents[k]
                + (flux.value / x[0] if case.axisymmetric and k == 0 else 0.0)
            )
        out[name] = total
    return out


HEAT = {
    "line": Heat("line", (4,), 2, nonlinear=True, stabilised=False),
    "triangle": Heat("triangle", (3,), 2, nonlinear=True, stabilised=False),
    "quadrilateral": Heat("quadrilateral", (3,), 3, nonlinear=True, stabilised=False),
    "tetrahedron": Heat("tetrahedron", (2,), 1, nonlinear=True, stabilised=False),
    "triangle_axisymmetric": Heat(
        "triangle", (3,), 2, nonlinear=True, stabilised=False, axisymmetric=True
    ),
    "triangle_supg": Heat("triangle", (3,), 2, uniform=True),
    "quadrilateral_supg": Heat("quadrilateral", (3,), 2, uniform=True),
    "tetrahedron_supg": Heat("tetrahedron", (2,), 2, uniform=True),
    "quadrilateral_supg_axisymmetric": Heat(
        "quadrilateral", (3,), 2, uniform=True, axisymmetric=True
    ),
    "triangle_radiating": Radiating("triangle", (3,), 2, stabilised=False),
    "quadrilateral_radiating_supg": Radiating("quadrilateral", (3,), 2, uniform=True),
    "tetrahedron_radiating_supg": Radiating("tetrahedron", (2,), 2, uniform=True),
    "quadrilateral_radiating_axisymmetric": Radiating(
        "quadrilateral", (3,), 2, stabilised=False, axisymmetric=True
    ),
}


@pytest.mark.parametrize("name", HEAT)
def test_two_energy(name: str) -> None:
    case = HEAT[name]
    m = mesh(case.shape, case.sizes[0])
    system = case.system(m, ORDER[case.shape])
    fields = case.fields(m.dim())
    c = case.coefficients(system, system.cells)
    forms: list[Any] = [(two_energy.residual, system.cells, c)]
    for part in system.boundary("all"):
        known = {field: exact(function, m, part) for field, function in fields.items()}
        here, o = case.coefficients(system, part), Ops(part)
        for field, other, phase in (
            ("T_fluid", "T_solid", here.fluid),
            ("T_solid", "T_fluid", here.solid),
        ):
            cross = here.cross(0.5 * (known[field] + known[other]))
            conducted = (
                two_energy.conduction(known[field], phase, o)
                + o.grad(known[other]) * cross
            )
            flux = o.dot(conducted, part.n).value
            wall = two_energy.BoundaryTerms(
                field, phase.mass_flux, phase.enthalpy, flux=flux
            )
            forms.append((two_energy.boundary, part, wall))
    weak = Manufactured(system, fields, forms).load()
    strong = heat_strong(case, m.dim(), c, system.cells.x.items)

    def tested(unknowns: Any, tests: Any, c: two_energy.Coefficients, o: Ops) -> Any:
        total: Any = 0.0
        for field, phase in (("T_fluid", c.fluid), ("T_solid", c.solid)):
            v = getattr(tests, field)
            weight = (
                v
                if phase.tau is None
                else v + phase.tau * o.dot(phase.mass_flux, o.grad(v))
            )
            total = strong[field] * weight + total
        return total

    expected = system.assemble(
        [(tested, system.cells, c)], np.zeros(system.size), False
    )[0]
    assert (
        np.abs(weak - expected).max() <= TOLERANCE[case.shape] * np.abs(expected).max()
    )


RADIATING = {
    "triangle": Radiating("triangle", (3,), 2),
    "quadrilateral": Radiating("quadrilateral", (3,), 3),
    "tetrahedron": Radiating("tetrahedron", (2,), 1),
    "triangle_axisymmetric": Radiating("triangle", (3,), 2, axisymmetric=True),
    "quadrilateral_axisymmetric": Radiating(
        "quadrilateral", (3,), 2, axisymmetric=True
    ),
}


@pytest.mark.parametrize("name", RADIATING)
def test_radiation(name: str) -> None:
    """Emission of three species, diffusion, a gray wall and an opening."""
    case = RADIATING[name]
    m = mesh(case.shape, case.sizes[0])
    system = case.system(m, ORDER[case.shape])
    fields, c = case.fields(m.dim()), OPTICS
    weak = Manufactured(system, fields, case.radiation(system)).load()
    G, slope = jet(fields["G"], system.cells.x.items)
    T = fields["T_solid"](*system.cells.x.items)
    laplacian = sum(slope[k].tangents[k] for k in range(m.dim()))
    if case.axisymmetric:
        laplacian = laplacian + slope[0].value / system.cells.x[0]
    active = c.absorption["T_solid"]
    emitted = 4.0 * SIGMA * (active * T**4 + 0.1 * 900.0**4 + 0.05 * 1200.0**4)
    strong = (active + 0.15) * G.value - emitted - c.diffusion * laplacian

    def tested(unknowns: Any, tests: Any, c: Any, o: Ops) -> Any:
        return strong * tests.G

    forms: list[Any] = [(tested, system.cells, None)]
    for side, factor, power in (
        ("right", 0.6 / (2.0 * (2.0 - 0.6)), 7e4),
        ("rest", 0.5, 3e4),
    ):
        for part in system.boundary(side):
            G_there, slope_there = jet(fields["G"], part.x.items)
            outward = sum(part.n[k] * slope_there[k].value for k in range(m.dim()))
            defect = c.diffusion * outward - factor * (4.0 * power - G_there.value)

            def tested_there(
                unknowns: Any, tests: Any, c: Any, o: Ops, defect: Any = defect
            ) -> Any:
                return defect * tests.G

            forms.append((tested_there, part, None))
    expected = system.assemble(forms, np.zeros(system.size), False)[0]
    assert (
        np.abs(weak - expected).max() <= TOLERANCE[case.shape] * np.abs(expected).max()
    )


@pytest.mark.parametrize("scattering", [0.0, 160.0])
def test_hemispherical_fluxes(scattering: float) -> None:
    """pi I(+-) = G/4 +- q/2 satisfy the two equations of the two-flux method where G
    satisfies its own, to round-off:

    +-1/2 dI(+-)/dz = -beta I(+-) + K_a sigma T^4/pi + K_s/2 (I+ + I-), for G = 4 sigma
    T^4 + A exp(z sqrt(K_a/D)). The heat radiated by the bed is then dq/dz.
    """
    K_a, T, A = 40.0, 1100.0, 2e4
    beta = K_a + scattering
    D = 1.0 / (4.0 * beta)
    k = (K_a / D) ** 0.5
    z = np.linspace(0.0, 0.05, 11)
    G = 4.0 * SIGMA * T**4 + A * np.exp(k * z)
    slope, q, slope_q = (
        A * k * np.exp(k * z),
        -D * A * k * np.exp(k * z),
        -D * A * k**2 * np.exp(k * z),
    )
    source = K_a * SIGMA * T**4 + 0.25 * scattering * G
    for sign in (1.0, -1.0):
        flux, change = G / 4.0 + sign * q / 2.0, slope / 4.0 + sign * slope_q / 2.0
        np.testing.assert_allclose(
            0.5 * sign * change,
            source - beta * flux,
            rtol=0,
            atol=1e-14 * beta * G.max(),
        )
    radiated = -radiation.absorbed(T, G, K_a)
    np.testing.assert_allclose(radiated, slope_q, rtol=0, atol=1e-14 * beta * G.max())


@pytest.mark.parametrize("shape", ["triangle", "quadrilateral", "tetrahedron"])
@pytest.mark.parametrize("axisymmetric", [False, True])
def test_divergence_of_a_computed_velocity_does_not_heat(
    shape: str, axisymmetric: bool
) -> None:
    """A uniform temperature solves the equations for any velocity field, to
    round-off.
    """
    if axisymmetric and shape == "tetrahedron":
        return
    case = Heat(shape, (2,), 2, computed=True, axisymmetric=axisymmetric)
    system = case.system(mesh(shape, 2), 7)

    def without_sources(where: Any) -> two_energy.Coefficients:
        c = case.coefficients(system, where)
        return replace(
            c, fluid=replace(c.fluid, source=0.0), solid=replace(c.solid, source=0.0)
        )

    forms: list[Any] = [
        (two_energy.residual, system.cells, without_sources(system.cells))
    ]
    for part in system.boundary("off_axis" if axisymmetric else "all"):
        c = without_sources(part)
        for name, phase in (("T_fluid", c.fluid), ("T_solid", c.solid)):
            forms.append(
                (
                    two_energy.boundary,
                    part,
                    two_energy.BoundaryTerms(name, phase.mass_flux, phase.enthalpy),
                )
            )
    residual = system.assemble(forms, np.full(system.size, 1.7), False)[0]
    uncorrected = [
        (f, d, replace(c, fluid=replace(c.fluid, divergence=None)))
        for f, d, c in forms[:1]
    ] + forms[1:]
    scale = np.abs(
        system.assemble(uncorrected, np.full(system.size, 1.7), False)[0]
    ).max()
    assert scale > 1e-6
    assert np.abs(residual).max() <= 1e-13


FLOW = {
    "triangle": Flow("triangle", (3,)),
    "quadrilateral": Flow("quadrilateral", (3,)),
    "tetrahedron": Flow("tetrahedron", (2,)),
    "triangle_axisymmetric": Flow("triangle", (3,), axisymmetric=True),
    "quadrilateral_axisymmetric": Flow("quadrilateral", (3,), axisymmetric=True),
}


def flow_strong(case: Flow, dim: int, x: Any) -> tuple[list[Any], Any]:
    """Momentum (dim entries) and divergence at points."""
    fields, c = case.fields(dim), case.coefficients(dim)
    jets = [jet(lambda *at, k=k: fields["u"](*at)[k], x) for k in range(dim)]
    u = [value.value for value, _ in jets]
    slope_p = jet(fields["p"], x)[1]
    w = [u_k - solid for u_k, solid in zip(u, c.comoving_velocity.items, strict=True)]
    speed = np.sqrt(sum(w_k**2 for w_k in w))
    resistance = (
        c.viscosity / c.permeability
        + c.density * c.forchheimer / c.permeability**0.5 * speed
    )
    momentum = []
    for k, (_, slope) in enumerate(jets):
        laplacian = sum(slope[m].tangents[m] for m in range(dim))
        if case.axisymmetric:
            laplacian = (
                laplacian
                + slope[0].value / x[0]
                - (u[0] / x[0] ** 2 if k == 0 else 0.0)
            )
        convected = sum(u[m] * slope[m].value for m in range(dim))
        momentum.append(
            c.density / c.porosity * convected
            + slope_p[k].value
            - c.viscosity * laplacian
            + c.porosity * resistance * w[k]
        )
    divergence = sum(jets[k][1][k].value for k in range(dim))
    return momentum, divergence + u[0] / x[0] if case.axisymmetric else divergence


@pytest.mark.parametrize("name", FLOW)
def test_porous_flow(name: str) -> None:
    case = FLOW[name]
    m = mesh(case.shape, case.sizes[0])
    dim = m.dim()
    system = case.system(m, ORDER[case.shape])
    weak = Manufactured(
        system,
        case.fields(dim),
        [(porous_flow.residual, system.cells, case.coefficients(dim))],
    ).load()
    momentum, divergence = flow_strong(case, dim, system.cells.x.items)

    def tested(unknowns: Any, tests: Any, c: Any, o: Ops) -> Any:
        return sum(
            (momentum[k] * tests.u[k] for k in range(dim)),
            start=-1.0 * divergence * tests.p,
        )

    expected = system.assemble(
        [(tested, system.cells, None)], np.zeros(system.size), False
    )[0]
    inner = np.ones(system.size, dtype=bool)
    for k in range(dim):
        inner[system.nodes("u", m.boundary_facets(), k)] = False
    assert (
        np.abs(weak - expected)[inner].max()
        <= TOLERANCE[case.shape] * np.abs(expected).max()
    )
