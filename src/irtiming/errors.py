"""Every error that irtiming raises on purpose.

IrTimingError
    UnitError            a number or unit that cannot be read
    PlanError            no trigger scheme meets the wishes
    GeometryError        a rig whose numbers cannot be
    InstrumentError      a device that cannot be used
        InstrumentSilent     it does not answer, or its line is gone
        InstrumentRefused    it answers, but will not or must not do what is asked
    GatewareError        a circuit that cannot be described, translated or simulated
    ArchiveError         a file that cannot be read or written
    ReductionError       a recording that cannot be reduced
    EstimationError      reduced data that do not determine the measurand
    ConditionError       a result that does not hold for what it should be applied to

A message says what is, what must be and what to do, in one line. The command line prints it and exits with 2.
"""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager

_LONGEST, _HEAD, _TAIL = 2000, 1400, 500


def one_line(text: str) -> str:
    """A message as a person can read it, whatever a hostile file put into it: one line, no control characters, not too long.

    What is cut is the middle: a message begins with what is wrong and ends with what to do.
    """
    line = "".join(letter if letter.isprintable() else "\ufffd" for letter in " ".join(text.split()))
    return line if len(line) <= _LONGEST else f"{line[:_HEAD]} [...] {line[-_TAIL:]}"


class IrTimingError(Exception):
    """Root of all errors that a user can cause and cure.

    Parameters
    ----------
    what
        What is, what must be and what to do.
    fields
        Fields of a record whose names stand in braces in ``what``: a door to the program may call them by its own names.
    where
        What it is about, such as a file; stands before ``what``.
    """

    def __init__(self, what: str = "", *fields: str, where: str = "") -> None:
        self.where, self._form, self._fields = where, what, fields
        super().__init__()
        self.call_fields(str)

    def call_fields(self, name: Callable[[str], str]) -> None:
        """Say the same with other names for the fields."""
        self.what = self._form
        for field in self._fields:
            self.what = self.what.replace(f"{{{field}}}", name(field))
        self.args = (one_line(f"{self.where}: {self.what}" if self.where else self.what),)


def listed(fields: Sequence[str]) -> str:
    """All ``fields`` as they stand in the text of an error: ``"{one}, {other}"``."""
    return ", ".join(f"{{{field}}}" for field in fields)


class UnitError(IrTimingError):
    """A number or unit that cannot be read."""


class PlanError(IrTimingError):
    """No trigger scheme meets the wishes."""


class GeometryError(IrTimingError):
    """A rig whose numbers cannot be."""


class InstrumentError(IrTimingError):
    """A device that cannot be used."""


class InstrumentSilent(InstrumentError):  # noqa: N818 - says what the instrument did
    """A device that does not answer, or whose line is gone."""


class InstrumentRefused(InstrumentError):  # noqa: N818 - says what the instrument did
    """A device that answers, but will not or must not do what is asked of it."""


class GatewareError(IrTimingError):
    """A circuit that cannot be described, translated or simulated."""


class ArchiveError(IrTimingError):
    """A file that cannot be read or written."""


class ReductionError(IrTimingError):
    """A recording that cannot be reduced."""


class EstimationError(IrTimingError):
    """Reduced data that do not determine the measurand."""


class ConditionError(IrTimingError):
    """A result that does not hold for what it should be applied to."""


@contextmanager
def about(where: object) -> Iterator[None]:
    """What is raised here is about this, such as a file, where it does not say so itself.

    Raises
    ------
    IrTimingError
        That which was raised.
    """
    try:
        yield
    except IrTimingError as error:
        if not error.where and str(where) not in error.what:
            error.where = str(where)
            error.call_fields(str)
        raise


@contextmanager
def computing(names: str) -> Iterator[None]:
    """Numbers that no wheel before a camera makes break a computation here or there: that refuses the recordings of these names.

    Raises
    ------
    EstimationError
        In place of what numpy and scipy raise.
    """
    try:
        yield
    except (ValueError, ArithmeticError) as error:
        if isinstance(error, IrTimingError):
            raise
        raise EstimationError(
            f"{names}: frames and timestamps fit no wheel before a camera ({type(error).__name__}: {error}); look at the frames, "
            "and check rig.toml and frame_number against the recording"
        ) from error
