"""Rounding of values to their uncertainties."""

import pytest

from irtiming.report import rounding


@pytest.mark.parametrize(
    ("value_s", "u_s", "text"),
    [
        (372.525e-6, 31.29e-6, "373 ± 31 µs"),
        (372.525e-6, 0.2148e-6, "372.53 ± 0.21 µs"),
        (3.872e-3, 0.123e-3, "3.87 ± 0.12 ms"),
        (567e-6, 123e-6, "570 ± 120 µs"),
        (10.04e-6, 9.96e-6, "10 ± 10 µs"),
        (10.04e-6, 0.0996e-6, "10.04 ± 0.10 µs"),
        (-1.004e-6, 4.2e-6, "−1.0 ± 4.2 µs"),
        (-0.001e-6, 4.2e-6, "0.0 ± 4.2 µs"),
        (2e-9, 0.35e-6, "0 ± 350 ns"),
        (0.025, 0.0, "25 ms"),
        (0.025, None, "25 ms"),
        (0.0, None, "0 µs"),
        (1.5, float("nan"), "1.5 s"),
    ],
)
def test_a_time_has_two_digits_of_its_uncertainty(value_s, u_s, text):
    """Oracle: the GUM's 7.2.6 by hand: u to two digits, the value to the same place, one unit."""
    assert rounding.time_text(value_s, u_s) == text


@pytest.mark.parametrize(
    ("u_s", "text"),
    [(31.29e-6, "31 µs"), (0.4659e-6, "0.47 µs"), (3.1e-9, "3.1 ns"), (1.2e-3, "1.2 ms"), (0.0, "–"), (float("nan"), "–")],
)  # fmt: skip
def test_an_uncertainty_alone_has_two_digits(u_s, text):
    """Oracle: rounded by hand."""
    assert rounding.uncertainty_text(u_s) == text


@pytest.mark.parametrize(
    ("value", "u", "unit", "text"),
    [
        (142.8e-6, 134.5e-6, "rad", "140 ± 130 µrad"),
        (-1.4e-3, 2e-5, "rad", "−1400 ± 20 µrad"),
        (0.0123, 0.00034, "1", "1.230 ± 0.034 %"),
        (3.2e-6, 1.1e-7, "s", "3.20 ± 0.11 µs"),
        (5e-6, None, "rad", "5 µrad"),
    ],
)
def test_any_number_has_two_digits_of_its_uncertainty(value, u, unit, text):
    """Oracle: the GUM's 7.2.6 by hand; angles in urad, shares in per cent."""
    assert rounding.value_text(value, u, unit=unit).replace("\u202f", " ") == text


@pytest.mark.parametrize(
    ("value", "text"), [(123.4, "120"), (0.0999, "0.10"), (9.96, "10"), (0.0, "0"), (1.0, "1.0"), (0.00123, "0.0012")]
)
def test_significant_digits_count_from_the_first(value, text):
    """Oracle: rounded by hand; 9.96 carries into a further digit."""
    assert rounding.significant(value) == text


def test_a_deviation_carries_its_sign():
    """Oracle: by hand; zero has none."""
    assert rounding.signed(3e-6, 1.083e-6, unit_s=1e-6) == "+3.0"
    assert rounding.signed(-2.021e-6, 1.137e-6, unit_s=1e-6) == "−2.0"
    assert rounding.signed(0.0, 1e-6, unit_s=1e-6) == "0.0"
