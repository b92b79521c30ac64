"""Options become records, and complaints about records name options."""

from dataclasses import dataclass

import pytest

from irtiming.cli.options import filled, in_options
from irtiming.errors import PlanError, UnitError


@dataclass(frozen=True, kw_only=True)
class Record:
    """Fields of every kind."""

    delay_s: float = 1.0
    start_s: tuple[float, ...] = ()
    body_k: float | None = None
    drift_dn_per_s: float = 0.0
    rows: int = 3
    name: str = ""

    def __post_init__(self):
        if self.rows == 0:
            raise PlanError(
                "{rows} with {delay_s}, {body_k} and {drift_dn_per_s}", "rows", "delay_s", "body_k", "drift_dn_per_s"
            )


def test_texts_are_read_in_the_unit_of_their_field_and_the_rest_has_its_default():
    """Oracle: by hand; 0 degrees Celsius are 273.15 K, and what is no field is left alone."""
    given = {
        "delay": "25 ms",
        "start": ["1 s", "2 min"],
        "body": "0 C",
        "drift_dn_per_s": -0.5,
        "other": 1,
        "rows": None,
    }
    assert filled(Record, given) == Record(delay_s=0.025, start_s=(1.0, 120.0), body_k=273.15, drift_dn_per_s=-0.5)


def test_what_is_given_besides_comes_before_the_option():
    """Oracle: by hand; also where it is None."""
    assert filled(Record, {"rows": 5, "body": "300 K"}, rows=7, body_k=None, name="a") == Record(rows=7, name="a")


def test_a_text_that_is_no_time_is_refused():
    """Oracle: the message of `units.seconds`."""
    with pytest.raises(UnitError, match="'soon' is not a time"):
        filled(Record, {"delay": "soon"})


def test_a_complaint_names_the_options():
    """Oracle: by hand; the command is otherwise itself."""

    @in_options
    def command(rows):
        """Say what is wanted."""
        return filled(Record, {"rows": rows})

    assert command(4).rows == 4
    assert (command.__name__, command.__doc__) == ("command", "Say what is wanted.")
    with pytest.raises(PlanError) as refused:
        command(0)
    assert str(refused.value) == "--rows with --delay, --body and --drift-dn-per-s"


@pytest.mark.parametrize("number", [float("nan"), float("inf")])
def test_a_number_that_is_none_is_refused(number):
    """Oracle: by hand; the option is named."""
    with pytest.raises(UnitError, match="--drift-dn-per-s is (nan|inf), must be a finite number"):
        filled(Record, {"drift_dn_per_s": number})
