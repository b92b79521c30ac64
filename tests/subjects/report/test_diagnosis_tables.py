"""What may stand behind residuals, as tables: numbers with the digits of their uncertainties."""

from types import SimpleNamespace

from irtiming.records.rig import Measured
from irtiming.report.sections import diagnosis


def test_a_defect_has_two_digits_of_its_uncertainty():
    """Oracle: by hand; the second blade's share of the walk through a report, -0.013498 with u of 0.000053."""
    one = SimpleNamespace(
        name="run: second blade", value=Measured(-0.013498, 0.000053), unit="1", from_none=-255.1, gained=65071.2
    )
    (row,) = diagnosis.fitted(SimpleNamespace(fitted=(one,))).rows
    assert row == ("run: second blade", "\N{MINUS SIGN}0.013498", "0.000053", "", "\N{MINUS SIGN}255.1", "65071.2")
