"""Words for what a delay counts from: where a camera runs free, a strobe or a stamp stands in the place of the trigger.

The estimation knows one event per frame, whatever it was, and calls its delay that of the trigger. What a person or another
program reads passes through here and gets the event's own name.
"""

import re
from typing import Any

from irtiming.records.analysis import Analysis
from irtiming.records.choices import Language
from irtiming.records.frame_events import DELAYS, NOUNS, FrameEvent
from irtiming.report.language import language

_WAYS = {
    "strobe": ("latency of the camera input", "camera input"),
    "stamp": ("relation of the stamps' clock to the counter", "stamps' clock"),
    "arrival": ("relation of the computer's clock to the counter", "computer's clock"),
}
_GERMAN = {
    "strobe": ("der Flanke des Strobe-Signals", "Strobe-Verzögerung", "Latenz des Kameraeingangs", "Kameraeingang"),
    "stamp": (
        "dem Zeitstempel des Bildes (Median)", "Zeitstempelverzögerung", "Bezug der Uhr der Zeitstempel zum Zähler",
        "Uhr der Zeitstempel",
    ),
    "arrival": (
        "der Ankunft des Bildes (Median)", "Zeitstempelverzögerung", "Bezug der Uhr des Rechners zum Zähler",
        "Uhr des Rechners",
    ),
}  # fmt: skip
_AS_THEY_ARE = ("file", "sha256", "recording")


def event_of(analysis: Analysis) -> FrameEvent:
    """What the delays of an analysis count from."""
    events = analysis.recordings[0].events
    return "trigger" if events is None else events.kind


def text(said: str, event: FrameEvent, *, said_in: Language | None = None) -> str:
    """The same text with the event's own words.

    Parameters
    ----------
    said
        Plain text or HTML, which speaks of triggers.
    event
        What the delays count from.
    said_in
        Language of the text; that in which is written here, where none is given.
    """
    if event == "trigger":
        return said
    for pattern, words in _german(event) if (said_in or language()) == "de" else _english(event):
        said = re.sub(pattern, words, said)
    return said


def _english(event: FrameEvent) -> tuple[tuple[str, str], ...]:
    """What is said of a trigger, and what of the event."""
    name = DELAYS[event]
    way, short = _WAYS[event]
    return (
        (r"the trigger edge that the\s+camera accepts|the trigger edge", NOUNS[event]),
        (r" The delay set in the trigger generator is taken off\.", ""),
        (r"their triggers are skipped", "their places are left out"),
        (r"at the trigger\b", "at the event"),
        (r"\bthat were triggered earlier", "whose event came earlier"),
        (r"latency of the trigger path", way),
        (
            r"(and trigger path|latency of trigger path): by what edges are late the delay is too long",
            r"\1: by what the wheel's edges are late the delay is too long, by what the event's are too short",
        ),
        (r"\btrigger path\b", short),
        (r"\btrigger_delay(?!_time)", name),
        (r"\btrigger delay(?!s? set)", name.replace("_", " ")),
        (r"\bTrigger delay(?!s? set)", name.replace("_", " ").capitalize()),
    )


def _german(event: FrameEvent) -> tuple[tuple[str, str], ...]:
    """The same in German, where the trigger edge always stands in the dative."""
    noun, name, way, short = _GERMAN[event]
    return (
        (r"der Triggerflanke(, die die\s+Kamera annimmt)?", noun),
        (r" Die im Triggergenerator eingestellte Verzögerung ist abgezogen\.", ""),
        (r"ihre Trigger sind übersprungen", "ihre Plätze sind ausgelassen"),
        (r"beim Trigger\b", "beim Ereignis"),
        (r"\bdie früher ausgelöst wurden", "deren Ereignis früher kam"),
        (r"Latenz des Triggerwegs", way),
        (r"\bTriggerweg\b", short),
        (r"\bTriggerverzögerung\b", name),
    )


def data(said: Any, event: FrameEvent) -> Any:
    """The same plain data, keys and texts with the event's own words; names of files stay as they are.

    Parameters
    ----------
    said
        Mappings, lists, texts and numbers.
    event
        What the delays count from.
    """
    if event == "trigger":
        return said
    if isinstance(said, dict):
        return {text(key, event): value if key in _AS_THEY_ARE else data(value, event) for key, value in said.items()}
    if isinstance(said, list | tuple):
        return [data(one, event) for one in said]
    return text(said, event) if isinstance(said, str) else said
