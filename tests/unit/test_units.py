"""Units at the door."""

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from contbed.scene.units import QUANTITIES, to_si
from tests.cases import each_case
from tests.imported import modules_after


@each_case(__file__, "quantities")
def test_quantities(text, unit, value):
    assert to_si(text, unit) == pytest.approx(value, rel=1e-14)


@each_case(__file__, "what_is_no_quantity")
def test_what_is_no_quantity(text, unit, message):
    with pytest.raises(ValueError) as error:
        to_si(text, unit)
    assert message in str(error.value)
    assert len(str(error.value)) < 250


@settings(max_examples=300)
@given(
    st.text("0123456789.eE+-*/^() mKPasgWJdC%_,", max_size=20),
    st.sampled_from(sorted(QUANTITIES)),
)
def test_any_text_gives_a_number_or_a_value_error(text, unit):
    try:
        assert isinstance(to_si(text, unit), float)
    except ValueError as error:
        assert type(error) is ValueError


def test_pint_is_imported_by_the_first_unit_only():
    code = "import contbed.scene.units as u"
    assert "pint" not in modules_after(code)
    assert "pint" in modules_after(f"{code}; u.to_si('1 m', 'm')")


def test_a_machine_under_load_fails_no_generated_case():
    """The profile of the suite, which each case starts from."""
    assert settings.default.deadline is None
    assert HealthCheck.too_slow in settings.default.suppress_health_check
