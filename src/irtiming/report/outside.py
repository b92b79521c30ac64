"""What the uncertainty of a number does not hold, in words: behind a number, and in a sentence about it."""

from collections.abc import Sequence

from irtiming.report.language import t


def behind(not_in_uncertainty: Sequence[str]) -> str:
    """What stands behind a number with its uncertainty; empty where that holds all.

    Parameters
    ----------
    not_in_uncertainty
        As a result has it, one thing each.
    """
    return t("not in u: {what}", what=listed(not_in_uncertainty)) if not_in_uncertainty else ""


def listed(not_in_uncertainty: Sequence[str]) -> str:
    """One thing after the other; empty where there is none."""
    return "; ".join(t(one) for one in not_in_uncertainty)
