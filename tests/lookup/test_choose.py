"""Closures for a place at given conditions."""

import subprocess
import sys
from unittest.mock import Mock

from pytest import approx

from contbed import cli
from contbed.closures import registry
from contbed.explain.rank_closures import (
    conditions,
    derived,
    fluidized,
    kind_for,
    ranked,
    table,
)
from contbed.explain.sheets import entries, explain
from contbed.reacting_bed.closures import places_of
from tests.cases import each_case
from tests.command_line import command
from tests.refusals import refused


def test_conditions_are_in_si():
    found = conditions("d_p=300 um, rho_s = 2600, T=850 degC, k_s=2 W/m/K")
    assert found == approx(
        {"d_p": 3e-4, "rho_solid": 2600.0, "T": 1123.15, "k_solid": 2.0}, rel=1e-12
    )


@each_case(__file__, "bad_conditions_say_what_is_wrong")
def test_bad_conditions_say_what_is_wrong(text, part):
    refused(part, conditions, text)


def test_what_follows_from_the_conditions():
    """Numbers by hand; the gas is air, whose Prandtl number is 0.71 within 2 % at
    300 K (Incropera, table A.4).
    """
    known, remark = derived({"T": 300.0, "d_p": 1e-3, "u": 0.5, "rho_solid": 2500.0})
    assert "air at 300 K" in remark
    assert known["rho"] == approx(101325 * 0.02885 / 8.314 / 300, rel=1e-3)
    assert known["Pr"] == approx(0.71, rel=0.02)
    assert known["Re"] == approx(0.5e-3 * known["rho"] / known["mu"])
    assert known["Ar"] == approx(
        1e-9 * known["rho"] * (2500 - known["rho"]) * 9.81 / known["mu"] ** 2
    )
    given, none = derived({"mu": 1e-3, "rho": 1000.0, "u": -1.0, "d_p": 1e-3})
    assert none == "" and given["Re"] == approx(1000.0)


def test_closures_inside_their_range_come_first():
    choices = ranked("nusselt", {"Re": 3.0, "Pr": 0.7, "eps": 0.4})
    verdicts = [bool(choice.outside) for choice in choices]
    # Re from 15 on
    assert verdicts == sorted(verdicts) and choices[-1].name == "nusselt_wakao_kaguei"
    gunn = next(choice for choice in choices if choice.name == "nusselt_gunn")
    assert gunn.value == approx(
        float(registry.get("nusselt_gunn")(Re=3.0, Pr=0.7, eps=0.4))
    )


def test_a_fluidized_bed_spans_reynolds_numbers():
    """From minimum fluidization to the terminal velocity; a value beyond the range
    on one side is outside.
    """
    known, _ = derived(conditions("d_p=300 um, rho_s=2600, T=850 degC"))
    spans = fluidized(known)
    assert 0.07 < spans["Re"][0] < 0.08 and 4.0 < spans["Re"][1] < 4.5
    outside = {choice.name for choice in ranked("drag", known, spans) if choice.outside}
    # porosities up to 0.95, from 0.41
    assert outside >= {"drag_beetstra", "drag_igci", "drag_milioli"}
    assert not outside & {"drag_gidaspow", "drag_wen_yu", "drag_di_felice"}
    assert fluidized({"d_p": 1e-3}) == {}


def test_laws_of_minimum_fluidization_show_their_velocity():
    """Re nu/d_p by Wen and Yu, Re = (33.7^2 + 0.0408 Ar)^0.5 - 33.7; the listing has
    five digits of Re, and g of four.
    """
    text = table(
        "closures.minimum_fluidization", "d_p=500 um, rho_s=2500, rho=1.2, mu=1.8e-5"
    )
    Ar = 500e-6**3 * 1.2 * (2500.0 - 1.2) * 9.80665 / 1.8e-5**2
    u_mf = ((33.7**2 + 0.0408 * Ar) ** 0.5 - 33.7) * 1.5e-5 / 500e-6
    (line,) = [each for each in text.split("\n") if "wen_yu" in each]
    assert float(line.split()[-2]) == approx(u_mf, rel=1e-3)
    assert line.endswith(" m/s")


def test_particles_that_float_have_no_archimedes_number():
    known, _ = derived(conditions("d_p=300 um, rho_s=0.5, T=300"))
    assert "Ar" not in known and fluidized(known) == {}


def test_a_ratio_of_spans_is_as_wide_as_it_can_be():
    from contbed.explain.rank_closures import _of

    assert _of("a/b", {"a": (1.0, 2.0), "b": (4.0, 8.0)}) == (0.125, 0.5)


def test_kind_of_a_place():
    assert kind_for("solids.sand.nusselt") == "nusselt"
    assert kind_for("drag") == "drag"
    text = table("boundary.left.coefficient", None)
    assert "two_fluid takes those of kind bed_tube" in text and "wall_" in text
    refused(r"closures\.drag", kind_for, "closures.darg")


def test_kinds_of_places_are_those_that_a_reacting_bed_binds():
    """What is offered for a place is what its scene takes there."""
    bound = {
        ".".join(key): kind
        for key, _, kind in places_of(
            Mock(), Mock(), {"NAME": Mock()}, {"wall": Mock()}
        )
    }
    assert bound == {key: kind_for(key) for key in bound}
    assert bound["closures.dispersion_mass"] == "mass_dispersion"


def test_the_command(capsys):
    assert (
        command(
            "closures --for closures.drag --at 'd_p=300 um, rho_s=2600, T=850 degC'"
        )
        == 0
    )
    out = capsys.readouterr().out
    assert "Re = 0.07556 to 4.215" in out
    assert (
        out.index("drag_gidaspow") < out.index("drag_beetstra")
        and "range 0.35 to 0.95" in out
    )


def test_every_name_explains_itself():
    for name in entries():
        assert explain(name)


def test_the_shell_completes_names():
    code = "import sys; from contbed.cli import main; sys.exit(main([]))"
    environment = {
        "_CONTBED_COMPLETE": "complete_bash",
        "COMP_WORDS": "contbed explain nusselt_gu",
        "COMP_CWORD": "2",
    }
    done = subprocess.run([sys.executable, "-c", code], env=environment | {"PYTHONPATH": ":".join(sys.path)},
                          capture_output=True, text=True)  # fmt: skip
    assert done.stdout.split() == ["nusselt_gunn"]


def test_a_closure_without_a_value_names_what_it_needs(capsys):
    at = "Re=500, Pr=1.0, eps=0.4"
    assert cli.main(["closures", "--for", "closures.nusselt", "--at", at]) == 0
    after = capsys.readouterr().out.partition("nusselt_power")[2].splitlines()
    assert after[1].strip() == "not known: a, b"
