"""Every form, recorded and compiled by FFCx, gives the element residual that scikit-fem
assembles.

One general cell of each shape, random unknowns, the same quadrature points on both
sides. Both sum the same terms in another order: they agree to 1e-12 of the largest
entry, some thousand roundings.
"""

import shutil
import sysconfig
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache
from pathlib import Path
from tempfile import TemporaryDirectory
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import skfem
from skfem.quadrature import get_quadrature

from contbed.closures import dispersion_wakao_kaguei_axial, nusselt_gunn
from contbed.fem import stabilisation
from contbed.fem.ad import dual
from contbed.fem.ad.dual import Components
from contbed.fem.ad.graph import Field, Graph, recorded
from contbed.fem.elements import lagrange
from contbed.fem.skfem import Ops, System
from contbed.materials import ConstantFluid, Solid, gas_mixture
from contbed.packed_bed.equations import porous_flow, two_energy
from contbed.radiation.equations import p1 as radiation
from contbed.ranks.recording import recording_of

basix = pytest.importorskip("basix", reason="fenics-basix is not installed")
pytest.importorskip("basix.ufl", reason="fenics-basix is older than these tests")
ufl = pytest.importorskip("ufl", reason="fenics-ufl is not installed")
jit = pytest.importorskip(
    "ffcx.codegeneration.jit", reason="fenics-ffcx is not installed"
)
recorded_ufl = pytest.importorskip(
    "contbed.ranks.ufl", reason="fenics-ufl is not installed"
)
pytestmark = [
    pytest.mark.skipif(
        not (shutil.which("cc") or shutil.which("gcc")),
        reason="FFCx needs a C compiler: no cc, gcc",
    ),
    pytest.mark.skipif(
        not Path(sysconfig.get_paths()["include"], "Python.h").exists(),
        reason="FFCx needs the header Python.h",
    ),
]

TOLERANCE = 1e-12
MESHES = {
    "triangle": skfem.MeshTri(
        np.array([[0.6, 1.7, 1.1], [0.2, 0.5, 1.3]]), np.array([[0], [1], [2]])
    ),
    "quadrilateral": skfem.MeshQuad(
        np.array([[0.5, 1.8, 1.5, 0.7], [0.1, 0.4, 1.6, 1.2]]),
        np.array([[0], [1], [2], [3]]),
    ),
    "tetrahedron": skfem.MeshTet(
        np.array([[0.1, 1.2, 0.3, 0.4], [0.0, 0.2, 1.1, 0.3], [0.1, 0.3, 0.2, 0.9]]),
        np.array([[0], [1], [2], [3]]),
    ),
}
BASIX_ORDER = {
    "triangle": [0, 1, 2],
    "quadrilateral": [0, 1, 3, 2],
    "tetrahedron": [0, 1, 2, 3],
}
POROSITY, DIAMETER, BED = 0.4, 3e-3, 0.1


def flow_coefficients(o: Any, known: Any) -> porous_flow.Coefficients:
    """All terms of comparable size at velocities and pressures of order one."""
    return porous_flow.Coefficients(
        1.3, 0.7, POROSITY, 0.5, 0.6, Components([0.3, -0.2, 0.1][: o.dim]), 1.0
    )


def constant_properties() -> tuple[Any, Any]:
    """Heat capacities, conductivities and velocities of order one."""
    return ConstantFluid(1.2, 0.9, 0.4, 0.3), Solid(1.5, 0.8, 0.6)


def real_properties() -> tuple[Any, Any]:
    """A gas of three species and a solid with polynomial properties."""
    return gas_mixture("N2:0.7, O2:0.2, H2O:0.1", 101325.0), Solid(
        2000.0, (500.0, 0.4), (0.8, 1e-3, 1e-7)
    )


def heat_coefficients(
    o: Any, velocity: Any, materials: Any, *, uniform: bool, stabilised: bool
) -> Any:
    """Everything the two-energy form can hold: exchange by Gunn, dispersion by
    Wakao, tortuosity, tau, sources.
    """
    fluid, solid = materials()
    T_ref = 700.0
    density = float(fluid.density(T_ref))
    velocity_solid = Components([0.2, 0.1, -0.3][: o.dim])
    if uniform:
        velocity = Components([0.9, -0.4, 0.5][: o.dim])
    w = velocity - velocity_solid
    speed = np.sqrt(o.dot(w, w))

    def exchange(T_fluid: Any, T_solid: Any) -> Any:
        k, mu = fluid.conductivity(T_fluid), fluid.viscosity(T_fluid)
        Re = fluid.density(T_fluid) * speed * DIAMETER / mu
        return (
            nusselt_gunn(Re, mu * fluid.heat_capacity(T_fluid) / k, POROSITY)
            * k
            * 500.0
        )

    size = np.sqrt(o.dot(velocity, velocity))
    Pe = (
        density
        * float(fluid.heat_capacity(T_ref))
        * size
        * DIAMETER
        / float(fluid.conductivity(T_ref))
    )
    along = dispersion_wakao_kaguei_axial(Pe, float(fluid.conductivity(T_ref)))
    phases = {}
    for name, material, u, fraction in (
        ("fluid", fluid, velocity, POROSITY),
        ("solid", solid, velocity_solid, 0.6),
    ):
        flux = u * float(material.density(T_ref))
        capacity, k = (
            float(material.heat_capacity(T_ref)),
            float(material.conductivity(T_ref)),
        )
        tau = stabilisation.tau(
            np.sqrt(o.dot(flux, flux)) * capacity, k, 40.0, capacity, o.h, 2
        )
        phases[name] = two_energy.Phase(
            mass_flux=flux,
            divergence=None
            if uniform or name == "solid"
            else o.div(velocity) * density,
            enthalpy=material.enthalpy,
            heat_capacity=material.heat_capacity,
            capacity=capacity,
            offset=float(material.enthalpy(T_ref)) - capacity * T_ref,
            conductivity=lambda T, material=material, fraction=fraction: (
                fraction * material.conductivity(T)
            ),
            dispersion=(0.1 * along, 0.9 * along, velocity / size)
            if name == "fluid"
            else None,
            content=lambda T, m=material, fraction=fraction: (
                fraction * m.density(T) * m.enthalpy(T)
            ),
            source=3.0,
            tau=tau if stabilised else None,
        )
    return two_energy.Coefficients(
        phases["fluid"],
        phases["solid"],
        exchange,
        lambda T: 0.05 * solid.conductivity(T),
    )


@dataclass(frozen=True)
class Case:
    """A form with its coefficients, `coeffs(ops, velocity field)`."""

    form: Callable[..., Any]
    coeffs: Callable[[Any, Any], Any]
    fields: Callable[[int], dict[str, tuple[int, int]]]
    order: int = 5
    axisymmetric: bool = False
    scale: tuple[float, float] = (-1.0, 1.0)


def flow(axisymmetric: bool = False) -> Case:
    """Flow on Taylor-Hood elements."""
    fields = lambda dim: {"u": (2, dim), "p": (1, 0)}  # noqa: E731
    return Case(
        porous_flow.residual, flow_coefficients, fields, axisymmetric=axisymmetric
    )


def heat(
    form: Any,
    materials: Any,
    *,
    uniform: bool = False,
    stabilised: bool = True,
    degree: int = 2,
    axisymmetric: bool = False,
) -> Case:
    """Both energy equations."""
    return Case(
        form,
        lambda o, known: heat_coefficients(
            o, known, materials, uniform=uniform, stabilised=stabilised
        ),
        lambda dim: dict.fromkeys(two_energy.FIELDS, (degree, 0)),
        axisymmetric=axisymmetric,
        scale=(300.0, 1200.0),
    )


OPTICS = radiation.Coefficients({"T_solid": 0.7, "T_fluid": 0.2}, 0.9, 4e4, 0.3)


def radiating(form: Any, coeffs: Any, *, axisymmetric: bool = False) -> Case:
    """Incident radiation beside both temperatures."""
    return Case(
        form,
        coeffs,
        lambda dim: dict.fromkeys((*two_energy.FIELDS, *radiation.FIELDS), (2, 0)),
        axisymmetric=axisymmetric,
        scale=(300.0, 1200.0),
    )


def heat_with_radiation(o: Any, known: Any) -> Any:
    """Both energy equations with what the solid takes up."""
    c = heat_coefficients(o, known, real_properties, uniform=False, stabilised=True)
    return replace(
        c,
        radiated=lambda unknowns: radiation.absorbed(unknowns.T_solid, unknowns.G, 0.7),
    )


CASES = {
    "flow": flow(),
    "heat_uniform_velocity_degree_1": heat(
        two_energy.residual, constant_properties, uniform=True, degree=1
    ),
    "heat_constant_properties": heat(two_energy.residual, constant_properties),
    "heat_gas_without_supg": heat(
        two_energy.residual, real_properties, stabilised=False
    ),
    "heat_gas": heat(two_energy.residual, real_properties),
    "heat_gas_degree_3": heat(two_energy.residual, real_properties, degree=3),
    "storage": heat(two_energy.storage, real_properties),
    "radiation": radiating(radiation.residual, lambda o, known: OPTICS),
    "heat_with_radiation": radiating(two_energy.residual, heat_with_radiation),
}
ROUND = {
    "flow_axisymmetric": flow(axisymmetric=True),
    "heat_axisymmetric": heat(two_energy.residual, real_properties, axisymmetric=True),
    "storage_axisymmetric": heat(
        two_energy.storage, real_properties, axisymmetric=True
    ),
    "radiation_axisymmetric": radiating(
        radiation.residual, lambda o, known: OPTICS, axisymmetric=True
    ),
}
ALL = [
    (cell, name)
    for cell in MESHES
    for name in (CASES if cell == "tetrahedron" else CASES | ROUND)
]


def lagrange_element(cell: str, degree: int, ncomponents: int) -> Any:
    """The element with equispaced nodes: a vector, or a scalar for 0 components."""
    shape = (ncomponents,) if ncomponents else None
    return basix.ufl.element(
        "P",
        cell,
        degree,
        lagrange_variant=basix.LagrangeVariant.equispaced,
        shape=shape,
    )


class Element:
    """One case on one cell: the form recorded and in UFL, the scikit-fem system, and
    data for both.
    """

    def __init__(self, cell: str, case: Case):
        mesh = MESHES[cell]
        dim = mesh.dim()
        self.cell, self.case = cell, case
        fields = case.fields(dim)
        self.system = System(mesh, fields, case.order, axisymmetric=case.axisymmetric)
        self.velocity_system = System(mesh, {"u": (2, dim)}, case.order)
        self.mesh = ufl.Mesh(lagrange_element(cell, 1, dim))
        self.element = basix.ufl.mixed_element(
            [lagrange_element(cell, *field) for field in fields.values()]
        )
        self.element_low = basix.ufl.mixed_element(
            [lagrange_element(cell, 1, n) for _, n in fields.values()]
        )
        velocity = lagrange_element(cell, 2, dim)
        self.velocity_element = SimpleNamespace(sub_elements=[velocity])
        spaces = (
            ufl.FunctionSpace(self.mesh, element)
            for element in (self.element, self.element_low, velocity)
        )
        self.state, self.state_low, self.velocity = (
            ufl.Coefficient(space) for space in spaces
        )
        self.form = self._form()
        random = np.random.default_rng(7)
        self.values = random.uniform(*case.scale, self.system.size)
        self.velocity_values = random.uniform(-1.0, 1.0, self.velocity_system.size)

    def _form(self) -> Any:
        """The form in UFL, by way of its recording; a component of the velocity is a
        known field.
        """
        system, case, graph = self.system, self.case, Graph()
        x = Components(graph.add("x", axis) for axis in range(system.mesh.dim()))
        ops = Ops(system.cells, x, graph.add("h"))
        known = Components(
            Field(graph, "known", axis) for axis in range(system.mesh.dim())
        )
        coefficients = recorded(graph, system, case.form, case.coeffs(ops, known), ops)
        found = recording_of(graph, coefficients, [*system.offset], system.cells.shape)
        slot, place = recorded_ufl.slot, ufl.SpatialCoordinate(self.mesh)
        leaves = {
            "number": lambda value, plain: ufl.as_ufl(value),
            "slot": lambda k, kind: (
                self.state_low[k] if kind == "low" else slot(self.state[k], kind)
            ),
            "known": lambda k, kind: slot(self.velocity[k], kind),
            "x": lambda axis: place[axis],
            "h": lambda: ufl.MaxCellEdgeLength(self.mesh),
        }
        done, tests = (
            recorded_ufl.expressions(found.entries, leaves),
            ufl.TestFunction(self.state.ufl_function_space()),
        )
        integrand = sum(
            done[entry] * slot(tests[k], kind) for k, kind, entry in found.results
        )
        if case.axisymmetric:
            integrand = 2.0 * np.pi * place[0] * integrand
        points, weights = get_quadrature(system.mesh.elem.refdom, case.order)
        rule = {
            "quadrature_rule": "custom",
            "quadrature_points": points.T.copy(),
            "quadrature_weights": weights,
        }
        return integrand * ufl.dx(
            domain=self.mesh, metadata={"quadrature_degree": case.order, **rule}
        )

    def scikit_fem(self, jacobian: bool = False) -> tuple[Any, Any]:
        """Residual and Jacobian of `System`."""
        system, case = self.system, self.case
        where, space = system.cells, self.velocity_system.fields["u"][0]
        known = system.known(
            where, space, self.velocity_system.part(self.velocity_values, "u")
        )
        return system.assemble(
            [(case.form, where, case.coeffs(Ops(where), known))], self.values, jacobian
        )

    def places(self, system: System, element: Any) -> Any:
        """Number in the system of each local unknown of a UFL element, found by the
        coordinates of its node.
        """
        corners, geometry = (
            system.mesh.p[:, system.mesh.t[:, 0]],
            lagrange(system.mesh.elem.refdom, 1),
        )
        out = []
        for (name, (space, ncomponents)), part in zip(
            system.fields.items(), element.sub_elements, strict=True
        ):
            nodes = corners @ geometry.table(part.basix_element.points.T)
            distance = np.abs(space.points[:, None, :] - nodes[:, :, None]).max(axis=0)
            assert distance.min(axis=1).max() < 1e-12
            components = [system.offset[name, k] for k in range(max(ncomponents, 1))]
            out.append((distance.argmin(axis=1)[:, None] + components).ravel())
        return np.concatenate(out)

    def tabulate(self, form: Any, compiled: Any, ffi: Any) -> Any:
        """The element tensor of a compiled form, in the numbering of the scikit-fem
        system.
        """
        places = self.places(self.system, self.element)
        vertices = self.places(self.system, self.element_low)
        velocity = self.places(self.velocity_system, self.velocity_element)
        data = {
            self.state: self.values[places],
            self.state_low: self.values[vertices],
            self.velocity: self.velocity_values[velocity],
        }
        used = [
            compiled.original_coefficient_positions[k]
            for k in range(compiled.num_coefficients)
        ]
        w = np.concatenate([data[form.coefficients()[k]] for k in used])
        mesh, order = self.system.mesh, BASIX_ORDER[self.cell]
        x = np.zeros((len(order), 3))
        x[:, : mesh.dim()] = mesh.p[:, mesh.t[order, 0]].T
        A = np.zeros((len(places),) * compiled.rank)
        pointer = [
            ffi.cast("double*", array.ctypes.data) for array in (A, w, np.zeros(1), x)
        ]
        kernel = compiled.form_integrals[0].tabulate_tensor_float64
        kernel(*pointer, ffi.NULL, ffi.NULL, ffi.NULL)
        out = np.zeros((self.system.size,) * compiled.rank)
        out[np.ix_(*[places] * compiled.rank)] = A
        return out


@lru_cache
def compiled(cell: str) -> dict[str, tuple[Element, Any]]:
    """All forms of a cell in one compilation: name -> (element, tensor); the flow's
    Jacobian too on triangles.
    """
    cases = CASES if cell == "tetrahedron" else CASES | ROUND
    elements = {name: Element(cell, case) for name, case in cases.items()}
    forms = {name: element.form for name, element in elements.items()}
    if cell == "triangle":
        elements["flow_jacobian"] = elements["flow"]
        forms["flow_jacobian"] = ufl.derivative(forms["flow"], elements["flow"].state)
    with TemporaryDirectory() as folder:
        found, module, _ = jit.compile_forms(
            list(forms.values()),
            cache_dir=folder,
            cffi_extra_compile_args=["-O0"],
            timeout=60,
        )
        return {
            name: (element, element.tabulate(forms[name], one, module.ffi))
            for (name, element), one in zip(elements.items(), found, strict=True)
        }


# forms are compiled for each kind of cell
ELEMENTS = [
    one if one[0] == "triangle" else pytest.param(*one, marks=pytest.mark.slow)
    for one in ALL
]


@pytest.mark.parametrize(("cell", "name"), ELEMENTS)
def test_element_residual(cell: str, name: str) -> None:
    element, tensor = compiled(cell)[name]
    expected = element.scikit_fem()[0]
    assert np.abs(expected).max() > 0
    assert np.abs(tensor - expected).max() <= TOLERANCE * np.abs(expected).max()


def test_derivative_equals_dual_numbers() -> None:
    element, tensor = compiled("triangle")["flow_jacobian"]
    expected = element.scikit_fem(jacobian=True)[1].toarray()
    assert np.abs(tensor - expected).max() <= TOLERANCE * np.abs(expected).max()


UNARY, BINARY = set(dual._UNARY), set(dual._BINARY) | {np.power, np.float_power}


def at_a_point(function: Callable[[Any, Any], Any]) -> float:
    """A function of the coordinates x and y of the point (0.3, 0.8), recorded and
    evaluated by UFL.
    """
    graph = Graph()
    x, y = (graph.add("x", axis) for axis in range(2))
    found = recording_of(
        graph, {("T", 0, "v"): graph.leaf(function(x, y))}, [("T", 0)], (1, 1)
    )
    place = ufl.SpatialCoordinate(ufl.Mesh(lagrange_element("triangle", 1, 2)))
    leaves = {
        "number": lambda value, plain: ufl.as_ufl(value),
        "x": lambda axis: place[axis],
    }
    value: float = recorded_ufl.expressions(found.entries, leaves)[found.results[0][2]](
        (0.3, 0.8)
    )
    return value


@pytest.mark.parametrize(
    "ufunc",
    sorted(UNARY | BINARY | dual._COMPARISONS, key=str),
    ids=lambda f: f.__name__,
)
def test_every_function_of_dual_numbers_has_a_counterpart(ufunc: Any) -> None:
    pairs: list[Callable[[Any, Any], Any]] = [
        lambda x, y: (x, y),
        lambda x, y: (y, x),
        lambda x, y: (x, 0.3),
    ]
    for pair in pairs:

        def function(x: Any, y: Any, pair: Any = pair) -> Any:
            found = ufunc(*pair(x, y)[: 1 if ufunc in UNARY else 2])
            return np.where(found, 2.0 * x, y) if ufunc in dual._COMPARISONS else found

        # two roundings
        assert at_a_point(function) == pytest.approx(
            float(function(0.3, 0.8)), rel=1e-14
        )


@pytest.mark.parametrize(
    "condition",
    [
        lambda x, y: (x < y) & (x < 0.1),
        lambda x, y: (x < y) | (x < 0.1),
        lambda x, y: np.logical_not(x < y),
        lambda x, y: np.logical_and(x < y, y < 1.0),
        lambda x, y: np.logical_or(x > y, y > 1.0),
        lambda x, y: np.invert(np.greater(x, y)),
        lambda x, y: 1.0 < 2.0,
        lambda x, y: 1.0 > 2.0,
    ],
)
def test_conditions_combine(condition: Any) -> None:
    expected = np.where(condition(np.float64(0.3), np.float64(0.8)), 0.3, 1.6)
    assert at_a_point(lambda x, y: np.where(condition(x, y), x, 2.0 * y)) == expected
