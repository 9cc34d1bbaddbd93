"""The sketch of a bed and the first sentences of its report."""

from contbed.explain import editor
from contbed.loading import loads
from contbed.output.sketch import sketch, text_of
from contbed.report.words import amount, following, found, sure
from contbed.scene.identity import resolved
from tests.cases import each_case
from tests.scene_text import scene_of

COUNTER_CURRENT = scene_of(
    """
[mesh]
type = "file"
file = "meshes/heater.msh"
[packed_bed]
porosity = 0.42
[solids.silica]
diameter = 0.012
[boundary.bottom]
gas.velocity = [0.0, 0.6]
gas.temperature = 433.15
[boundary.top]
solids.silica.velocity = [0.0, -0.0008]
solids.silica.fixed_temperature = 973.0
[boundary.wall]
coefficient = 20.0
ambient = 298.0
"""
)


def test_streams_of_a_counter_current_bed_leave_opposite_to_where_they_enter():
    bed = sketch("packed_bed", COUNTER_CURRENT, {"T_fluid_out_K": 966.0})
    assert [(each.text, each.inward) for each in bed.at("top")] == [
        ("silica 973 K, 0.0008 m/s", True),
        ("gas 966 K", False),
    ]
    assert [(each.text, each.inward) for each in bed.at("bottom")] == [
        ("gas 433.1 K, 0.6 m/s", True),
        ("silica", False),
    ]
    assert [each.text for each in bed.at("wall")] == ["wall: 20 W/m2/K to 298 K"]
    assert bed.inside == ("heater.msh", "porosity 0.42", "silica, 12 mm")


def test_a_stream_that_a_vector_leads_out_does_not_enter():
    """Reversed velocities: nothing enters, so that nothing leaves opposite."""
    out = {"bottom": {"gas": {"velocity": [0.0, -0.6]}}}
    bed = sketch("packed_bed", {**COUNTER_CURRENT, "boundary": out})
    assert bed.streams == ()


@each_case(__file__, "each_bed_has_a_sketch_with_its_streams")
def test_each_bed_has_a_sketch_with_its_streams(model, wanted):
    scene = loads(editor.template(model), "scene.toml")
    bed = sketch(model, resolved(scene))
    text = text_of(bed)
    assert wanted in text
    assert all(each in text for each in bed.inside)
    assert all(each.text in text for each in bed.streams)


def test_what_is_no_bed_has_no_sketch():
    assert sketch("radiation", {"boundary": {"left": {}}}) is None


SUMMARY = {
    "status": "ok",
    "qoi": {"conversion_CH4": 0.483, "T_fluid_out_K": 992.2, "duty_W": 20949.9},
    "balances": {"energy": {"relative_residual": -2e-14}, "C": {}},
    "closures": [{"name": "nusselt_gunn", "share_outside": 0.1}],
    "warnings": ["one"],
}


def test_results_are_told_in_sentences_with_units():
    assert list(found(SUMMARY)) == [
        "48.3 % of the CH4 that enters reacts.",
        "The gas leaves at 992.2 K.",
        "The gas takes up 20.9 kW.",
    ]
    assert amount("breakthrough_CO2_s", 1234.5, "s") == "1234 s"


def test_what_is_least_sure_is_named():
    assert list(sure(SUMMARY)) == [
        "All balances close to 2e-14 of their flows.",
        "These closures are used outside of their range: nusselt_gunn.",
    ]
    advice = " ".join(following(SUMMARY))
    for wanted in ("Read the warning below", "contbed closures", "contbed converge"):
        assert wanted in advice
    calm = {**SUMMARY, "qoi": {"estimated_error": 1e-3}, "closures": [], "warnings": []}
    assert list(sure(calm))[-1] == "The mesh leaves an estimated error of 0.1 %."
    assert not list(following(calm))


def test_a_failed_run_says_so_first():
    assert "did not end well" in next(found({"status": "failed"}))
