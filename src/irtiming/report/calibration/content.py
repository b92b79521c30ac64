"""What stands on a certificate, without any layout: who, what, when, and each result with its whole uncertainty budget."""

from collections.abc import Sequence
from dataclasses import dataclass
from datetime import date, datetime, timedelta
from typing import final

from irtiming.archive.certificate_file import CertificateFile, Item
from irtiming.archive.result_model import Input, Result
from irtiming.errors import ArchiveError
from irtiming.records.choices import Language
from irtiming.report.calibration import measurands
from irtiming.report.calibration.measurands import Measurand

NAMED = ("manufacturer", "model", "serial_number", "firmware")
"""What identifies a camera, in the order in which it is listed."""

_TIME_ZONES = timedelta(days=1)
"""By as much the day of a recording, in UTC or of another computer's clock, may be another than the laboratory's."""


@final
@dataclass(frozen=True, kw_only=True)
class ResultFile:
    """A result with the name and checksum of its file."""

    name: str
    sha256: str
    content: Result


@final
@dataclass(frozen=True, kw_only=True)
class CalibratedItem:
    """One camera.

    ``words`` has manufacturer, model, serial number and firmware, None where neither recordings nor laboratory say.
    ``stated`` are those that the laboratory states because the recordings lack them.
    """

    words: dict[str, str | None]
    stated: tuple[str, ...]
    form: Item

    @property
    def name(self) -> str:
        """Manufacturer, model and serial number in one line, as far as they are known."""
        return " ".join(word for name in NAMED[:3] if (word := self.words[name]))


@final
@dataclass(frozen=True, kw_only=True)
class MeasuredItem:
    """One result: which of the certificate's cameras it is of, what was measured, and the file behind it."""

    item: int
    file: ResultFile
    measurands: tuple[Measurand, ...]

    @property
    def result(self) -> Result:
        """All that the file says."""
        return self.file.content

    @property
    def headline(self) -> tuple[Measurand, ...]:
        """What a reader wants to know first."""
        return tuple(one for one in self.measurands if one.leads)


@final
@dataclass(frozen=True, kw_only=True)
class Sheet:
    """Everything on a certificate."""

    form: CertificateFile
    items: tuple[CalibratedItem, ...]
    results: tuple[MeasuredItem, ...]
    first_day: date
    last_day: date
    days_stated: bool

    @property
    def language(self) -> Language:
        """Of the certificate."""
        return self.form.certificate.language

    @property
    def is_simulated(self) -> bool:
        """Whether any of it stands on frames that no camera made."""
        return any(one.result.simulated for one in self.results)

    @property
    def inputs(self) -> tuple[Input, ...]:
        """All recordings."""
        return tuple(each for one in self.results for each in one.result.inputs)


def collect(files: Sequence[ResultFile], form: CertificateFile, *, called: str = "certificate.toml") -> Sheet:
    """What to print.

    Parameters
    ----------
    files
        Results, of one camera or several.
    form
        certificate.toml.
    called
        Name of that file, for whoever reads of an error.

    Raises
    ------
    ArchiveError
        If laboratory and recordings contradict each other, the date is not stated, or a limit is of no camera or nothing
        measured.
    """
    items: list[CalibratedItem] = []
    results: list[MeasuredItem] = []
    several = len({_key(file.content) for file in files}) > 1
    for file in files:
        item = _item(file, form, several=several, called=called)
        if item not in items:
            items.append(item)
        measured = tuple(measurands.of(file.content, form, serial_number=item.words["serial_number"]))
        results.append(MeasuredItem(item=items.index(item), file=file, measurands=measured))
    first, last = _days(files, form, called=called)
    _require_calibrated(form, last, called=called)
    sheet = Sheet(
        form=form, items=tuple(items), results=tuple(results), first_day=first, last_day=last,
        days_stated=bool(form.dates.measured),
    )  # fmt: skip
    _check_limits(sheet, called=called)
    return sheet


def _key(result: Result) -> tuple[str | None, ...]:
    """What differs between two cameras, as far as results tell."""
    return (*(getattr(result.item, name) for name in NAMED), result.camera, result.readout_mode)


def _item(file: ResultFile, form: CertificateFile, *, several: bool, called: str) -> CalibratedItem:
    """The camera of a result with what the laboratory says of it."""
    said = {name: getattr(file.content.item, name) for name in NAMED}
    forms = [one for one in form.item if not several or one.serial_number == said["serial_number"]]
    if len(forms) > 1:
        raise ArchiveError(
            f"{called} has {len(forms)} [[item]] for {file.name}, of one camera; leave one, or give each the "
            "serial_number that the recordings name"
        )
    if several and said["serial_number"] is None:
        raise ArchiveError(
            f"{file.name} names no serial number, and the results are of several cameras; make a certificate for each"
        )
    mine = forms[0] if forms else Item()
    for name in NAMED:
        ours, theirs = getattr(mine, name), said[name]
        if ours and theirs and ours != theirs:
            raise ArchiveError(
                f"{called} says [item] {name} = '{ours}', the recordings of {file.name} say '{theirs}'; correct it, or "
                "give the result of that camera"
            )
    stated = tuple(name for name in NAMED if not said[name] and getattr(mine, name))
    return CalibratedItem(words={name: said[name] or getattr(mine, name) for name in NAMED}, stated=stated, form=mine)


def _days(files: Sequence[ResultFile], form: CertificateFile, *, called: str) -> tuple[date, date]:
    """First and last day of measurement."""
    days, starts = form.dates.measured, [one.start_time for file in files for one in file.content.inputs]
    if not days and (not starts or None in starts):
        raise ArchiveError(
            f"the recordings do not say when they were made; state [dates] measured in {called}, such as 2026-11-23"
        )
    if not days:
        days = sorted(_day(start, called=called) for start in starts if start)
    elif known := sorted(day for start in starts if start and (day := _day_or_none(start))):
        _require_days_of(known, form, is_all=len(known) == len(starts), called=called)
    first, last = days[0], days[-1]
    for earlier, later, words in (
        (first, last, "the first day of [dates] measured"),
        (last, form.certificate.issued, "the last day of measurement"),
        (form.dates.received or first, first, "[dates] received"),
    ):
        if earlier > later:
            raise ArchiveError(f"{words}, {earlier}, is later than {later}; correct the dates in {called}")
    return first, last


def _require_calibrated(form: CertificateFile, last: date, *, called: str) -> None:
    """Refuse equipment whose calibration was due before the last day of measurement: results are traceable by it no more."""
    for one in form.equipment:
        if one.due is not None and one.due < last:
            raise ArchiveError(
                f"[[equipment]] {one.name} was due for calibration on {one.due}, before the last day of measurement, {last}; "
                f"state its later calibration in {called}, or leave due out and say among the remarks why it held"
            )


def _require_days_of(known: Sequence[date], form: CertificateFile, *, is_all: bool, called: str) -> None:
    """The days that are stated are those of the recordings, as far as these say; so the certificate is issued after them.

    Parameters
    ----------
    known
        Days of the recordings that say when they were made, in order; at least one.
    form, called
        certificate.toml and its name.
    is_all
        Whether all of them say so: then no day before or after them was one of measurement.

    Raises
    ------
    ArchiveError
        If they contradict each other by more than time zones can.
    """
    first, last = form.dates.measured[0], form.dates.measured[-1]
    holds_them = first - _TIME_ZONES <= known[0] and known[-1] <= last + _TIME_ZONES
    is_theirs = known[0] - _TIME_ZONES <= first and last <= known[-1] + _TIME_ZONES
    if not holds_them or (is_all and not is_theirs):
        raise ArchiveError(
            f"[dates] measured says {first} to {last}, the recordings were made from {known[0]} to {known[-1]}, which must be "
            f"the days of measurement; correct it in {called}, or leave it out"
        )


def _day(start: str, *, called: str) -> date:
    day = _day_or_none(start)
    if day is None:
        raise ArchiveError(
            f"a recording says that it was made at '{start:.40}', which is no time of ISO 8601; state [dates] measured in "
            f"{called}"
        )
    return day


def _day_or_none(start: str) -> date | None:
    try:
        return datetime.fromisoformat(start).date()
    except ValueError:
        return None


def _check_limits(sheet: Sheet, *, called: str) -> None:
    for limit in sheet.form.limit:
        serial = limit.serial_number
        known = [item.words["serial_number"] for item in sheet.items]
        if serial not in (None, *known):
            raise ArchiveError(
                f"{called} has a [[limit]] of the camera with serial_number = '{serial}', which the certificate is not of; "
                f"it is of {', '.join(one or 'one without a serial number' for one in known)}: correct it, or state "
                "[item] serial_number"
            )
        measured = {
            one.name for result in sheet.results for one in result.measurands if serial in (None, known[result.item])
        }
        if limit.parameter not in measured:
            raise ArchiveError(
                f"{called} has a [[limit]] of '{limit.parameter}', which was not measured; there are "
                f"{', '.join(sorted(measured))}"
            )
