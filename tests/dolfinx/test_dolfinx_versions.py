"""What the shim makes of the UFL, Basix and FFCx at hand, which may be newer than any DOLFINx that was run.

A form with values at our own quadrature points, values in cells and a mixed unknown is compiled by FFCx and evaluated
on the reference triangle, where the answer is a sum over those points.
"""

import shutil
import sysconfig
from pathlib import Path

import numpy as np
import pytest
from skfem.quadrature import get_quadrature
from skfem.refdom import RefTri

from contbed.fem import dolfinx_versions as versions

pytestmark = pytest.mark.without_dolfinx
ufl = pytest.importorskip("ufl", reason="fenics-ufl is not installed")
pytest.importorskip("basix.ufl", reason="Basix is older than the functions tested here")
jit = pytest.importorskip("ffcx.codegeneration.jit", reason="fenics-ffcx is not installed")


@pytest.mark.skipif(not (shutil.which("cc") or shutil.which("gcc")), reason="FFCx needs a C compiler: no cc, gcc")
@pytest.mark.skipif(
    not Path(sysconfig.get_paths()["include"], "Python.h").exists(), reason="FFCx needs the header Python.h"
)
def test_elements_compile_and_hold_values_at_our_points(tmp_path: Path) -> None:
    X, W = get_quadrature(RefTri, 7)
    points = np.ascontiguousarray(X.T)
    mesh = ufl.Mesh(versions.lagrange("triangle", 1, 2))
    mixed = versions.mixed([versions.lagrange("triangle", 2, 2), versions.lagrange("triangle", 1, 0)])
    data, constant, state = (
        ufl.Coefficient(ufl.FunctionSpace(mesh, element))
        for element in (versions.quadrature("triangle", points, W), versions.constants("triangle"), mixed)
    )
    rule = {"quadrature_rule": "custom", "quadrature_points": points, "quadrature_weights": W, "quadrature_degree": 7}
    form = data * constant * state[2] * ufl.Measure("dx", domain=mesh, metadata=rule)
    (compiled,), module, _ = jit.compile_forms([form], cache_dir=tmp_path, cffi_extra_compile_args=["-O0"], timeout=60)
    random = np.random.default_rng(5)
    values, pressure = random.uniform(1.0, 2.0, len(W)), random.uniform(1.0, 2.0, 3)
    order = {data: values, constant: np.array([3.0]), state: np.append(np.zeros(12), pressure)}
    used = [form.coefficients()[compiled.original_coefficient_positions[k]] for k in range(compiled.num_coefficients)]
    w = np.concatenate([order[coefficient] for coefficient in used])
    x = np.array([[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
    A, ffi = np.zeros(1), module.ffi
    pointers = [ffi.cast("double*", array.ctypes.data) for array in (A, w, np.zeros(1), x)]
    compiled.form_integrals[0].tabulate_tensor_float64(*pointers, ffi.NULL, ffi.NULL, ffi.NULL)
    linear = pressure[0] * (1 - X[0] - X[1]) + pressure[1] * X[0] + pressure[2] * X[1]
    assert A[0] == pytest.approx(3.0 * np.sum(W * values * linear), rel=1e-13)
