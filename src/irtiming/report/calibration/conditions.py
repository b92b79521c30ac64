"""Conditions of measurement, and the sentences that a certificate says of method, traceability and decision rule."""

from collections.abc import Callable, Iterable
from typing import Any

from irtiming.archive.result_model import Input
from irtiming.records.choices import Language
from irtiming.report.calibration.content import MeasuredItem, Sheet
from irtiming.report.calibration.numbers import plain, stated, with_unit
from irtiming.report.language import localised, translated
from irtiming.report.rounding import fixed, places
from irtiming.units import ZERO_CELSIUS_K

_NORMAL_K = 2.0
PLACES = {
    "laboratory": "in the laboratory",
    "customer": "at the customer's",
    "laboratoryBranch": "in a branch of the laboratory",
    "customerBranch": "in a branch of the customer",
    "other": "elsewhere",
}
METHODS = {
    "published": (
        "Chopper wheel before a blackbody, light gates and time-stamped triggers; by the procedure of V. Schatz, Meas. Sci. "
        "Technol. 34 (2023) 055407, step by step."
    ),
    "": (
        "Chopper wheel before a blackbody, light gates and time-stamped triggers, after V. Schatz, Meas. Sci. Technol. 34 (2023) "
        "055407; the frames are fitted together without any threshold."
    ),
}
TRACEABILITY = (
    "All times are counts of the trigger generator's clock, angles follow from the wheel's geometry. They are traceable to the "
    "SI as far as the equipment listed here is calibrated; what was not calibrated stands in the uncertainty budget with what is "
    "assumed of it."
)
NOT_TRACEABLE = "None: the frames were simulated."
KINDS = {"photon": "photon detector", "microbolometer": "microbolometer"}


def method(sheet: Sheet) -> str:
    """In one sentence, in English."""
    methods = {one.result.method for one in sheet.results}
    return METHODS["published" if methods == {"published"} else ""]


def of(sheet: Sheet, one: MeasuredItem) -> list[tuple[str, str]]:
    """Label and text of each condition of one result; empty text where the recordings do not say."""
    result, inputs, language = one.result, one.result.inputs, sheet.language

    def t(text: str) -> str:
        return translated(text, language)

    def numbers(values: Iterable[float | None], unit: str) -> str:
        return _each(values, lambda value: plain(value, unit, language=language))

    mode = t(result.readout_mode or "mode not stated")
    settings = sheet.items[one.item].form.settings
    return [
        ("camera type and mode", "; ".join([f"{t(KINDS[result.camera])}, {mode}", *([settings] if settings else [])])),
        ("image, rows × columns", _each([i.image for i in inputs], lambda image: f"{image.rows} × {image.columns}")),
        ("region of interest, rows; columns", _each([tuple(i.roi) for i in inputs], _region)),
        ("frame rate", numbers([1 / i.frame_period if i.frame_period else None for i in inputs], "Hz")),
        ("integration time as stated", _window(one, sheet)),
        ("bits per pixel", _each([i.bit_depth for i in inputs], str)),
        ("blackbody", _each([i.blackbody_temperature for i in inputs], lambda k: _celsius(k, sheet))),
        ("chopper wheel", numbers([i.rotation_speed for i in inputs], "Hz")),
        ("delays set in the trigger generator", _each([i.trigger_delay_time_set for i in inputs], lambda s: _set(s, sheet))),
        ("recordings; frames used", f"{len(inputs)}; {sum(_used(i) for i in inputs)}"),
    ]  # fmt: skip


def _window(one: MeasuredItem, sheet: Sheet) -> str:
    """That of a photon camera, with the expanded uncertainty where rig.toml states a standard one."""
    if one.result.camera != "photon":
        return "–"
    stated_u = [each.value for each in one.result.rig.values if each.name == "camera.integration_time_u"]
    expanded = max((_NORMAL_K * u for u in stated_u if isinstance(u, float)), default=0.0)

    def text(window_s: float) -> str:
        if expanded <= 0:
            return plain(window_s, "s", language=sheet.language)
        return f"{' ± '.join(stated(window_s, expanded, language=sheet.language))} (k = {_NORMAL_K:g})"

    return _each([each.integration_time for each in one.result.inputs], text)


def environment(sheet: Sheet) -> str:
    """Air around the rig, with expanded uncertainties where standard ones are stated: k = 2, as of a normal distribution."""
    place, texts = sheet.form.place, []
    if place.temperature is not None:
        celsius = float(f"{place.temperature - ZERO_CELSIUS_K:.6f}")
        texts.append(_with_expanded(celsius, place.temperature_u_k, unit="°C", language=sheet.language))
    if place.humidity_percent is not None:
        share = _with_expanded(place.humidity_percent, place.humidity_u_percent, unit="%", language=sheet.language)
        texts.append(f"{share} {translated('relative humidity', sheet.language)}")
    return ", ".join([*texts, *([place.other] if place.other else [])])


def _with_expanded(value: float, u: float | None, *, unit: str, language: Language) -> str:
    """Value ± U, both to the second digit of U; the value as stated where no uncertainty is."""
    if not u:
        return with_unit(localised(f"{value:.4g}", language), unit)
    expanded = _NORMAL_K * u
    both = " ± ".join(fixed(one, places(expanded)) for one in (value, expanded))
    return f"{with_unit(f'({localised(both, language)})', unit)} (k = {_NORMAL_K:g})"


def _each(values: Iterable[Any], written: Callable[[Any], str]) -> str:
    """Each value once; empty where one is missing."""
    each = _once(values)
    return "" if not each or None in each else ", ".join(written(value) for value in each)


def _once(values: Iterable[Any]) -> list[Any]:
    once: list[Any] = []
    for value in values:
        if value not in once:
            once.append(value)
    return once


def _region(roi: tuple[int, ...]) -> str:
    return f"{roi[0]}–{roi[1] - 1}; {roi[2]}–{roi[3] - 1}" if len(roi) == 4 else "–"


def _celsius(kelvin: float, sheet: Sheet) -> str:
    return with_unit(localised(f"{kelvin - ZERO_CELSIUS_K:.2f}", sheet.language), "°C")


def _set(delay_s: float, sheet: Sheet) -> str:
    return plain(delay_s, "s", language=sheet.language) if delay_s else "0"


def _used(one: Input) -> int:
    return one.frames if one.frames_used is None else one.frames_used
