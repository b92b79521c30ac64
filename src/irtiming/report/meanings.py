"""What each parameter means: the event that it counts to and its sign, by its name and by the camera's response and readout."""

from dataclasses import dataclass
from typing import final

from irtiming.records.analysis import Analysis
from irtiming.records.choices import Method
from irtiming.records.result import Bound, Result
from irtiming.report.language import decimal, language, t, with_unit
from irtiming.report.rounding import time_unit

SIGN = "positive: after the trigger edge that the camera accepts"
RELATIVE_SIGN = "positive: later"
METHOD_NAMES = {"pixel-sum": "pixel sums", "row-sum": "row sums", "published": "as published (Schatz 2023)"}
SYMBOLS = {"trigger_delay": "t_delay", "time_constant": "τ", "row_delay": "t_row", "integration_time": "T",
           "recursive_filter": "k", "pixel_memory": "s"}  # fmt: skip
_SIGNS = {
    "integration_time": None,
    "time_constant": "never negative",
    "recursive_filter": None,
    "pixel_memory": None,
    "row_delay": "positive: rows are read from the top down; negative: from the bottom up",
}
_EVENTS = {  # by response: a window integrates (eq. 1), a lagging pixel is read (eq. 2)
    "photon": {
        "trigger_delay": "start of integration{row}",
        "exposure_midpoint_delay": "middle of integration{row}",
        "trigger_delay_falling": "start of integration{row}, falling slopes only",
        "trigger_delay_rising": "start of integration{row}, rising slopes only",
        "integration_time": "length of the integration window",
        "pixel_memory": "share of the frame before that a pixel keeps",
        "row_delay": "from the integration of one image row to that of the row below it",
    },
    "microbolometer": {
        "trigger_delay": "reading of {image}",
        "time_constant": "63 % response of a pixel to a step of the scene",
        "recursive_filter": "share of the frame before in each frame, by the camera’s noise filter",
        "row_delay": "from the reading of one image row to that of the row below it",
    },
}
_OF_ROWS = {
    "photon": " (y = 0); that of row y comes y · row_delay later",
    "microbolometer": " (y = 0); row y is read at trigger_delay + y · row_delay",
}


@final
@dataclass(frozen=True, kw_only=True)
class Meaning:
    """What happens at the end of the time that a parameter tells, and what its sign means; None for a length."""

    event: str
    sign: str | None


def has_lag(analysis: Analysis) -> bool:
    """Whether pixels lag behind the scene (eq. 2) or integrate it over a window (eq. 1)."""
    return analysis.camera_type == "microbolometer"


def has_pixel_sums(analysis: Analysis) -> bool:
    """Whether all pixels were summed to one number per frame, or row by row."""
    return analysis.recordings[0].pixels is not None


def several_speeds(analysis: Analysis) -> bool:
    """Whether recordings at more than one wheel speed tell angles from delays."""
    return len({round(recording.rotation_speed_hz, 6) for recording in analysis.recordings}) > 1


def delay_name(result: Result) -> str:
    """Of the delay to report first: to the start of integration, where its length is known, else its middle; to the reading."""
    names = {*result.estimate.names, *(bound.name for bound in result.bounds)}
    middle = "exposure_midpoint_delay"
    leads = result.midpoint_leads or "trigger_delay" not in names
    return middle if middle in names and leads else "trigger_delay"


def edge_delay_name(analysis: Analysis) -> str:
    """What delays by wheel edge count to: of a window whose length no recording states, and of rows through one, its middle."""
    known = has_pixel_sums(analysis) and analysis.recordings[0].integration_time_s is not None
    return "trigger_delay" if has_lag(analysis) or known else "exposure_midpoint_delay"


def headline(analysis: Analysis, result: Result) -> tuple[str, ...]:
    """Parameters that the verdict states: delay, time constant, row delay, as far as the camera has them."""
    names = {*result.estimate.names, *(bound.name for bound in result.bounds)}
    lag = ("time_constant",) if has_lag(analysis) else ()
    rows = ("row_delay",) if analysis.readout_mode == "rolling" else ()
    return (delay_name(result), *(name for name in (*lag, *rows) if name in names or not names))


def event(name: str, analysis: Analysis) -> str:
    """In few words; the name itself where nothing more is known of it."""
    return t(event_in_english(name, analysis))


def event_in_english(name: str, analysis: Analysis) -> str:
    """The same as the catalogue of translations knows it."""
    rolling = analysis.readout_mode == "rolling"
    text = _EVENTS[analysis.camera_type].get(name, name)
    return text.format(row=" of image row 0" if rolling else "", image="image row 0" if rolling else "the image")


def meaning(name: str, analysis: Analysis) -> Meaning:
    """Event and sign of a parameter."""
    is_of_a_row = analysis.readout_mode == "rolling" and name == "trigger_delay"
    sign = _SIGNS.get(name, SIGN)
    return Meaning(
        event=t(event_in_english(name, analysis) + (_OF_ROWS[analysis.camera_type] if is_of_a_row else "")),
        sign=None if sign is None else t(sign),
    )


def relative_event(analysis: Analysis) -> str:
    """What relative delays count from and to."""
    first = event_in_english("trigger_delay", analysis).removeprefix("start of ")
    return t(f"{first}, counted from that of the smallest set delay")


def unit_of(name: str, result: Result) -> str:
    """Of a determined parameter: "s", or "1" of a share."""
    return result.estimate.units[result.estimate.names.index(name)]


def words(name: str) -> str:
    """A parameter's name as people write it."""
    return t(name.replace("_", " "))


def label(name: str) -> str:
    """A parameter's name in a table: as result files have it; in other languages as people write it."""
    return name if language() == "en" else words(name)


def method_name(method: Method) -> str:
    """A method as tables and figures name it."""
    return t(METHOD_NAMES[method])


def bound_text(bound: Bound) -> str:
    """What is known of a parameter that is not determined, in words."""
    if bound.lower is not None and bound.upper is not None:
        return f"{_short(bound.lower)} … {_short(bound.upper)}"
    if bound.upper is not None:
        return t("below {limit}", limit=_short(bound.upper))
    return t("not determined") if bound.lower is None else t("above {limit}", limit=_short(bound.lower))


def _short(value_s: float) -> str:
    factor, unit = time_unit(value_s)
    return with_unit(decimal(f"{value_s / factor:.3g}"), unit)
