"""Bound closures: called by name in numpy and in compiled kernels, refused where
arguments are missing, ranges kept.
"""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np
import pytest
from numpy.testing import assert_allclose

from contbed import closures
from contbed.closures.binding import bind
from contbed.closures.compiled import Face, kernel, own_values
from contbed.scene.tables import Closure
from tests.cases import each_case
from tests.refusals import refused

DRAG = ("Re", "eps", "d_p", "mu")
KNOWN = {"Re": 40.0, "eps": 0.6, "d_p": 1e-3, "mu": 1.8e-5}
GLOBAL_LAW = None


def of_cells(Re, eps, d_p, mu, own, out):
    """A kernel as a model writes it."""
    for i in range(len(Re)):
        out[i] = GLOBAL_LAW(Re[i], eps[i], d_p, mu, own)


def in_kernel(closure):
    """Values of a drag law in two cells."""
    out = np.empty(2)
    law = kernel(of_cells, {"GLOBAL_LAW": Face(closure, DRAG)})
    law(
        np.full(2, KNOWN["Re"]),
        np.full(2, KNOWN["eps"]),
        KNOWN["d_p"],
        KNOWN["mu"],
        own_values(closure),
        out,
    )
    return out


@pytest.mark.parametrize(
    "spec", ["gidaspow", "di_felice", Closure(name="syamlal_obrien", c=0.9, d=2.0)]
)
def test_a_kernel_calls_the_closure_of_the_scene(spec):
    closure = bind(spec, "drag", DRAG)
    assert_allclose(in_kernel(closure), closure(**KNOWN), rtol=1e-13)


def stokes(d_p, mu):
    """What a law may share with others: a plain function of its module."""
    return 18.0 * mu / d_p**2


def test_a_kernel_compiles_the_functions_that_a_closure_calls(scratch_register):
    @closures.closure(kind="drag", ranges={"eps": (0, 1)}, source="somebody")
    def drag_with_a_helper(eps, d_p, mu):
        return stokes(d_p, mu) / eps

    closure = bind("drag_with_a_helper", "drag", DRAG)
    assert_allclose(in_kernel(closure), closure(**KNOWN), rtol=1e-13)


def test_a_kernel_without_a_closure_is_zero():
    assert in_kernel(None).tolist() == [0.0, 0.0]


def test_a_closure_with_its_arguments_in_another_order(scratch_register):
    @closures.closure(kind="drag", ranges={"eps": (0, 1)}, source="somebody")
    def drag_reordered(mu, factor, eps, Re, power=2.0):
        return factor * mu * Re / eps**power

    closure = bind(Closure(name="reordered", factor=3.0, power=1.5), "drag", DRAG)
    expected = 3.0 * 1.8e-5 * 40.0 / 0.6**1.5
    assert closure(**KNOWN) == pytest.approx(expected, rel=1e-14)
    assert_allclose(in_kernel(closure), expected, rtol=1e-14)


def test_kernels_are_kept_on_disk():
    closure = bind("gidaspow", "drag", DRAG)
    in_kernel(closure)
    law = kernel(of_cells, {"GLOBAL_LAW": Face(closure, DRAG)})
    folder = Path(os.environ["NUMBA_CACHE_DIR"])
    index = list(folder.glob(f"*/*{law.py_func.__qualname__}*.nbi"))
    assert index, "numba keeps no index of this kernel"
    other = kernel(
        of_cells, {"GLOBAL_LAW": Face(bind("di_felice", "drag", DRAG), DRAG)}
    )
    assert other.py_func.__qualname__ != law.py_func.__qualname__


def test_what_cannot_be_given_is_listed():
    refused(
        r"needs eps: \{name = \"gunn\", eps = ...\}; given here: Pr, Re",
        bind,
        "gunn",
        "nusselt",
        ("Re", "Pr"),
    )
    assert (
        bind(Closure(name="gunn", eps=0.4), "nusselt", ("Re", "Pr"))(Re=10.0, Pr=0.7)
        > 0
    )


@each_case(__file__, "parameters_have_bounds")
def test_parameters_have_bounds(kind, closure, message):
    refused(
        message,
        bind,
        Closure(**closure),
        kind,
        ("Re", "Pr", "eps", "k_fluid", "k_solid", "T", "d_p", "u_excess"),
    )


ANY_SIGN = {"pressure_gradient_ergun": {"u"}}  # arguments without bounds


@pytest.mark.parametrize("name", closures.names())
def test_every_number_that_a_scene_may_give_has_bounds(name):
    facts = closures.sheet(name)
    numbers = {
        key
        for key in (*facts.arguments, *facts.options)
        if not isinstance(facts.options.get(key), str)
    }
    assert numbers - set(facts.bounds) == ANY_SIGN.get(name, set())
    for key in numbers & set(facts.bounds):
        assert -1.0 not in facts.bounds[key], key
        if key in facts.options:
            assert facts.options[key] in facts.bounds[key], key


def test_bounds_stand_in_the_data_sheet():
    assert "a : [0, inf)\nb : [0, inf)\n" in closures.data_sheet("nusselt_power")
    assert "emissivity : (0, 1]" in closures.data_sheet(
        "conductivity_zehner_bauer_schluender"
    )


def test_used_ranges_are_collected_and_survive_a_restart():
    given = ("Re", "Pr", "eps")
    first, whole = bind("gunn", "nusselt", given), bind("gunn", "nusselt", given)
    states = [
        {"Re": np.array([1.0, 5.0]), "Pr": 0.7, "eps": 0.4},
        {"Re": np.array([2.0, 2e5]), "Pr": 0.7, "eps": 0.3},
    ]
    first(**states[0])
    first.record()
    rest = bind("gunn", "nusselt", given)
    rest.restore(first.state())
    rest.record(**states[1])
    for state in states:
        whole.record(**state)
    assert rest.use() == whole.use()
    assert rest.use().arguments["Re"].used == (1.0, 2e5)
    assert rest.use().arguments["Re"].share_outside == 0.25
    assert rest.use().arguments["eps"].share_outside == 0.5


def test_without_a_record_the_last_call_counts():
    closure = bind("gunn", "nusselt", ("Re", "Pr", "eps"))
    for Re in (1.0, 7.0):
        closure(Re=Re, Pr=0.7, eps=0.4, T=300.0)
    assert closure.use().arguments["Re"].used == (7.0, 7.0)
