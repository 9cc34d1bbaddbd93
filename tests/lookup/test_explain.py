"""Whatever a scene, a template or a list of contbed calls by a name, `contbed
explain` has a data sheet of.
"""

import tomllib

import pytest

from contbed import cli, closures, fields
from contbed.explain import catalogue, editor
from contbed.explain.closure_keys import closure_keys
from contbed.explain.sheets import explain
from contbed.models import MODELS
from contbed.scene import schema
from tests.cases import each_case
from tests.command_line import command

PARTS = catalogue.last_parts(catalogue.keys())
NAMED = ("material", "law", "model", "type", "name")  # keys whose texts are names


def names_of(root, table, path=()):
    """Yield the names of the keys of a table, whole and their last parts, and the texts
    that are names.

    A name that the user chooses, such as that of a boundary, is left out by itself.
    """
    for key, value in table.items():
        here = (*path, key)
        options = [
            option for node in schema.at(root, path) for option in schema.options(node)
        ]
        if any(key in option.get("properties", {}) for option in options):
            yield key
        if schema.at(root, here):
            yield ".".join(here)
        if isinstance(value, dict):
            yield from names_of(root, value, here)
        elif (
            isinstance(value, str)
            and value.isidentifier()
            and (".".join(here) in closure_keys() or key in NAMED)
        ):
            yield value


@pytest.mark.parametrize("kind", MODELS)
def test_every_name_of_a_template_is_explained(kind):
    names = set(
        names_of(schema.of(MODELS[kind].scene), tomllib.loads(editor.template(kind)))
    ) - {"title"}
    assert len(names) > 10
    for name in sorted(names):
        assert explain(name), name


def test_every_closure_kind_place_law_and_material_is_explained():
    groups = ("models", "closures", "reactions", "materials", "tables")
    listed = [
        line.split()[0]
        for group in groups
        for lines in catalogue.sections(group).values()
        for line in lines
    ]
    words = [word + end for word in catalogue.WORDS for end in ("", "s")]
    laws = [law for of in catalogue.laws().values() for law in of]
    for name in {
        *listed,
        *closures.names(),
        *catalogue.kinds(),
        *closure_keys(),
        *laws,
        *words,
        *catalogue.TERMS,
        *fields.RESULTS,
    }:
        assert explain(name), name


def test_every_key_is_found_by_its_last_part():
    for part, whole in PARTS.items():
        text = explain(part)
        for name in whole:
            assert name == part or f"    {name}" in text


@each_case(__file__, "words_that_users_have")
def test_words_that_users_have(capsys, words, part):
    assert cli.main(["explain", *words]) == 0
    assert part in capsys.readouterr().out


@each_case(__file__, "the_nearest_names_are_told")
def test_the_nearest_names_are_told(capsys, name, near):
    assert command(f"explain {name}") == 2
    assert (
        near
        in capsys.readouterr().err.partition("nearest: ")[2].replace(",", "").split()
    )


def test_a_result_of_a_pattern_is_explained_once():
    """Of the patterns T_NAME and T_PHASE_out_K the closer one."""
    assert explain("T_fluid_out_K").count("T_fluid_out_K") == 1
    assert "mean outlet temperature of a stream" in explain("T_fluid_out_K")


def test_a_rate_law_shows_its_equation_and_source():
    text = explain("shrinking_core")
    assert "dX/dt = 3 q^2/(3 q^2 tau_film + 6 q (1 - q) tau_ash + tau_reaction)" in text
    assert "Levenspiel" in text
    assert "r2 = k2 (p_CO p_H2O" in explain("xu_froment_shift")


def test_all_ways_in_which_a_value_may_be_written_are_shown():
    """A number beside names, a text beside a table, and a closure as such."""
    ways = {
        "gas.diffusivity": 'a number > 0 m**2/s, or "cantera" or "fuller"',
        "boundary.NAME.gas.composition": "allowed: a text, or a table with times",
        "closures.nusselt": "a number >= 0, or a closure's name",
        "reactions.NAME.A": "allowed: a number >= 0, or a text",
    }
    for key, shown in ways.items():
        assert shown in explain(key)


def test_several_names_and_a_name_of_several_words(capsys):
    assert command("explain nusselt_gunn bubble_rise") == 0
    shown = capsys.readouterr().out
    assert "Gunn (1978)" in shown
    assert "absolute velocity, upward" in shown
    assert command("explain rate laws") == 0
    assert "CO_oxidation" in capsys.readouterr().out
    assert command("explain gun nusselt_gunn") == 2
    assert "nothing is called 'gun'" in capsys.readouterr().err
