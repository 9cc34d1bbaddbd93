"""The register: data sheets agree with docstrings, look-ups fail helpfully, range
use counts points.
"""

from __future__ import annotations

import ast
import dataclasses
import doctest
import importlib
import json
import re
from pathlib import Path

import numpy as np
import pytest

from contbed import closures
from contbed.closures.arguments import RESULTS, argument
from contbed.closures.sheet import Docstring
from tests.imported import modules_after
from tests.refusals import refused

SECTIONS = (
    "Parameters",
    "Returns",
    "Range",
    "Fitted to",
    "Limits",
    "Example",
    "Source",
)
MODULES = ["contbed.closures"] + [
    f"contbed.closures.{path.stem}"
    for path in Path(closures.__file__).parent.glob("*.py")
    if path.stem != "__init__"
]


def sections(text: str) -> dict[str, str]:
    """The body of each underlined section, in the order of the text."""
    parts = re.split(r"^(\w[\w ]*)\n-{3,}\n", text, flags=re.MULTILINE)
    return {
        title: body.strip()
        for title, body in zip(parts[1::2], parts[2::2], strict=True)
    }


@pytest.mark.parametrize("name", closures.names())
def test_data_sheet_states_what_is_registered(name):
    facts = closures.sheet(name)
    found = sections(facts.text)
    assert tuple(title for title in found if title != "Bounds") == SECTIONS
    assert all(found.values())
    assert re.search(r"\(\d{4}\): ", facts.summary)
    assert facts.equation
    assert re.match(r"\[(.+?)\]", found["Returns"]).group(1) == facts.unit
    documented = re.findall(
        r"^(\S+) : \[.+?\]", found["Parameters"], flags=re.MULTILINE
    )
    assert documented == [*facts.arguments, *facts.options]
    ranges = re.findall(r"^(\S+) : (\S+) to (\S+)$", found["Range"], flags=re.MULTILINE)
    assert {key: (float(low), float(high)) for key, low, high in ranges} == dict(
        facts.ranges
    )
    assert facts.ranges and all(low < high for low, high in facts.ranges.values())
    assert found["Source"].startswith(facts.source)
    assert closures.get(name).__doc__ == facts.text


@pytest.mark.parametrize(
    "path",
    sorted(Path(closures.__file__).parent.glob("*.py")),
    ids=lambda path: path.stem,
)
def test_nothing_is_stated_twice(path):
    """A docstring has no row that `arguments` has, and no section that the decorator
    gives.
    """
    for node in ast.parse(path.read_text(encoding="utf-8")).body:
        calls = getattr(node, "decorator_list", [])
        if not any(
            isinstance(call, ast.Call) and getattr(call.func, "id", "") == "closure"
            for call in calls
        ):
            continue
        doc = Docstring.read(ast.get_docstring(node))
        facts = closures.sheet(node.name)
        assert doc.sections.get("Result") != [RESULTS.get(facts.kind)]
        assert facts.source not in " ".join(doc.sections.get("Source", []))
        assert set(doc.rows) <= {*facts.arguments, *facts.options}
        for argument_name, row in doc.rows.items():
            known = argument(argument_name, facts.kind)
            assert known is None or row != [
                f"{argument_name} : [{known.unit}] {known.meaning}"
            ]


@pytest.mark.parametrize("module", MODULES)
def test_examples_print_what_they_claim(module):
    assert doctest.testmod(importlib.import_module(module)).failed == 0


@pytest.mark.parametrize("name", closures.names())
def test_every_closure_is_a_plain_function_exported_under_its_name(name):
    function = closures.get(name)
    assert type(function) is type(lambda: None)
    assert getattr(closures, name) is function
    assert name in closures.__all__
    assert ">>> " in sections(closures.sheet(name).text)["Example"]


def test_data_sheet_opens_with_call_kind_and_unit():
    text = closures.data_sheet("nusselt_gunn")
    assert text.startswith(
        "nusselt_gunn(Re, Pr, eps, exponent_Pr=0.333333)\nkind nusselt, unit [-]\n\n"
        "Gunn (1978)"
    )
    assert "doi:10.1016/0017-9310(78)90080-7" in text


def test_sheet_is_frozen():
    facts = closures.sheet("nusselt_gunn")
    with pytest.raises(dataclasses.FrozenInstanceError):
        facts.unit = "m"
    with pytest.raises(TypeError):
        facts.ranges["Re"] = (0, 1)


def test_names_of_a_kind():
    assert closures.names("wall") == ("wall_li_finlayson", "wall_martin_nilles")
    assert set(closures.names("wall")) < set(closures.names())


def test_unknown_name_points_to_the_nearest():
    refused(
        r"unknown closure 'nuselt_gun'; nearest: nusselt_gunn",
        closures.get,
        "nuselt_gun",
    )
    refused("nearest: nusselt_gunn", closures.sheet, "nusselt_gun")


def test_name_far_from_all_lists_what_there_is():
    refused(
        "unknown wall closure 'zzz'; known: wall_li_finlayson, wall_martin_nilles",
        closures.get,
        "zzz",
        kind="wall",
    )


def test_wrong_kind_is_refused():
    refused(
        "kind 'nusselt', wanted kind 'wall': wall_li_finlayson",
        closures.get,
        "nusselt_gunn",
        kind="wall",
    )


def test_dispersion_pair_by_stem():
    pair = closures.dispersion_pair("dispersion_vdi")
    assert pair == (closures.dispersion_vdi_axial, closures.dispersion_vdi_transverse)
    refused("nearest: dispersion_vdi", closures.dispersion_pair, "dispersion_vd")


def test_every_axial_dispersion_has_its_transverse_partner():
    stems = {
        re.sub("_(axial|transverse)$", "", name)
        for name in closures.names("dispersion")
    }
    assert all(closures.dispersion_pair(stem) for stem in stems)


def test_bounds_are_inclusive_and_nan_is_outside():
    use = closures.usage(
        closures.nusselt_gunn,
        Re=np.array([0.0, 1e5]),
        Pr=1.0,
        eps=np.array([0.35, 1.0]),
    )
    assert use.share_outside == 0
    just_below = 0.35 * (1 - 1e-6)
    use = closures.usage(
        "nusselt_gunn", Re=10.0, Pr=1.0, eps=np.array([0.35, just_below, np.nan, 1.0])
    )
    assert use.arguments["eps"].share_outside == 0.5
    assert use.arguments["Re"].share_outside == 0
    assert use.share_outside == 0.5


def test_range_of_a_ratio():
    use = closures.usage(
        closures.conductivity_krupiczka,
        k_fluid=0.5,
        k_solid=np.array([[0.25], [5.0]]),
        eps=0.4,
    )
    ratio = use.arguments["k_solid/k_fluid"]
    assert ratio.used == (0.5, 10.0)
    assert ratio.share_outside == 0.5


def test_range_use_is_plain_json():
    use = closures.usage(
        closures.nusselt_power, Re=np.array([1.0, -3.0, 5.0]), Pr=1.0, a=1.0, b=2.0
    )
    assert json.loads(json.dumps(use.to_dict(), allow_nan=False)) == {
        "name": "nusselt_power",
        "kind": "nusselt",
        "source": "user",
        "share_outside": pytest.approx(1 / 3),
        "ranges": {
            "Re": {
                "declared": [0.0, None],
                "used": [-3.0, 5.0],
                "share_outside": pytest.approx(1 / 3),
            }
        },
    }


def test_range_use_without_points():
    use = closures.usage(closures.nusselt_wakao_kaguei, Re=np.array([]), Pr=1.0)
    assert use.share_outside == 0
    assert use.to_dict()["ranges"]["Re"]["used"] == [None, None]


def test_range_use_asks_for_the_arguments_of_the_call():
    with pytest.raises(TypeError, match="Pr"):
        closures.usage(closures.nusselt_wakao_kaguei, Re=1.0)


def test_own_closure_is_found_by_name(scratch_register):
    @closures.closure(kind="nusselt", ranges={"Re": (0, 10)}, source="somebody 2020")
    def nusselt_mine(Re):
        return 2 + Re

    assert closures.get("nusselt_mine", kind="nusselt") is nusselt_mine
    assert nusselt_mine(1.0) == 3.0
    assert nusselt_mine.sheet.source == "somebody 2020"


def test_name_of_another_module_cannot_be_taken(scratch_register):
    with pytest.raises(ValueError, match="nusselt_gunn: the name is taken"):

        @closures.closure(kind="nusselt", ranges={}, source="somebody")
        def nusselt_gunn(Re):
            return Re


def test_range_of_no_argument_is_refused(scratch_register):
    with pytest.raises(ValueError, match="range 'Pr' names no argument; it has Re"):

        @closures.closure(kind="nusselt", ranges={"Pr": (0, 1)}, source="somebody")
        def nusselt_other(Re):
            return Re


def test_a_new_kind_needs_a_unit(scratch_register):
    with pytest.raises(ValueError, match="give the unit of the kind 'mixing'"):

        @closures.closure(kind="mixing", ranges={}, source="somebody")
        def mixing_mine(Re):
            return Re


def test_import_costs_numpy_only():
    heavy = {"scipy", "skfem", "pydantic", "matplotlib", "CoolProp", "cantera", "numba"}
    assert not heavy & modules_after("import contbed.closures")
