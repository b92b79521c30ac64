"""In which order recordings are taken, whatever the order of their files: the first one's opening is that of all."""

from collections.abc import Iterable
from typing import TypeVar

from irtiming.records.recording import Recording
from irtiming.records.reduced import ReducedRecording

One = TypeVar("One", Recording, ReducedRecording)


def in_order(recordings: Iterable[One]) -> list[One]:
    """Slow wheels first, then short delays, then cold blackbodies; runs alike in all these by name and checksum."""
    return sorted(
        recordings,
        key=lambda one: (
            one.rotation_speed_hz,
            one.trigger_delay_time_set_s,
            one.blackbody_temperature_k or 0.0,
            one.name,
            one.sha256,
        ),
    )
