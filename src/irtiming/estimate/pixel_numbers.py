"""Numbers of opening, window and pixels that all pixel sums of a camera share, and where their search begins."""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from irtiming.estimate import integration_time, opening_in_image, pixel_sums, shared_numbers
from irtiming.estimate.measurands import UNKNOWN_S, WINDOW
from irtiming.estimate.shared_numbers import SharedNumber
from irtiming.records import sources
from irtiming.records.estimate import EdgeDelayFit
from irtiming.records.reduced import ReducedRecording
from irtiming.records.wheel_geometry import WheelGeometry

_OFF_ZERO = 0.1  # standard uncertainties: sums are even in an edge misalignment, a search from zero stays there
_LEAST_U_RAD = 1e-5


def opening_and_window(
    recordings: Sequence[ReducedRecording], fits: Sequence[EdgeDelayFit], *, geometry: WheelGeometry
) -> list[SharedNumber]:
    """Opening, window and edge misalignments that all recordings share, beginning at rig.toml, one sample, and the images.

    Parameters
    ----------
    recordings, fits
        In the same order.
    geometry
        The wheel as drawn.
    """
    clockwise = geometry.rotation == "clockwise"
    in_image = [opening_in_image.edge_misalignments(one, turns_clockwise=clockwise) for one in recordings]
    misalignments = np.mean([angle for angle, _ in in_image], axis=0)
    u_misalignment = max(_LEAST_U_RAD, float(np.mean([u for _, u in in_image])))
    windows_s = [integration_time.starts_s(one, geometry.model) for one in recordings]
    stated_s = recordings[0].integration_time_s
    other_s = max(long_s for _, long_s in windows_s) if stated_s is None else stated_s
    memory, bow = (
        float(np.mean([fit.estimate.value(name) for fit in fits])) for name in (pixel_sums.MEMORY, pixel_sums.BOW)
    )
    return [
        shared_numbers.same("opening_angle", fits, unit="rad", start=geometry.model.opening_angle_rad),
        replace(
            shared_numbers.same(WINDOW, fits, start=min(short_s for short_s, _ in windows_s), u=UNKNOWN_S),
            other_starts=(other_s,),
        ),
        *(
            replace(
                shared_numbers.same(name, fits, unit="rad", start=float(angle), u=u_misalignment),
                start=math.copysign(max(abs(float(angle)), _OFF_ZERO * u_misalignment), angle),
                source=sources.IMAGE,
            )
            for name, angle in zip(("lean_low", "lean_high"), misalignments, strict=True)
        ),
        *_glare(recordings, fits),
        shared_numbers.uneven_edges(fits),
        shared_numbers.memory(pixel_sums.MEMORY, fits, start=memory),
        shared_numbers.same(pixel_sums.BOW, fits, unit="1", start=bow),
    ]


def _glare(recordings: Sequence[ReducedRecording], fits: Sequence[EdgeDelayFit]) -> list[SharedNumber]:
    """The share of the light that goes astray, as the images know it; none where they were not looked at."""
    shares = [opening_in_image.glare(one) for one in recordings if opening_in_image.lost(one) is not None]
    if not shares:
        return []
    glare, u_glare = np.mean(shares, axis=0).tolist()
    number = shared_numbers.same(pixel_sums.GLARE, fits, unit="1", start=glare, u=u_glare)
    return [replace(number, source=sources.IMAGE)]
