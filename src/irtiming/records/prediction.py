"""What a measurement is foretold to be able to tell, and the angle errors that limit it."""

from dataclasses import dataclass
from typing import final

from irtiming.records.rig import WindowTail


@final
@dataclass(frozen=True, kw_only=True)
class AngleErrors:
    """Standard uncertainties of the rig's angles, rad, and of what comes after the window.

    ``common`` names what shifts all wheel edges alike, each with its size; ``edge_rad`` is that of one cutout edge by itself;
    ``window_tail`` is None where the window counts as known.
    """

    common: tuple[tuple[str, float], ...]
    edge_rad: float
    window_tail: WindowTail | None = None


@final
@dataclass(frozen=True, kw_only=True)
class PredictedPart:
    """What one source alone adds to a predicted uncertainty: the squares of all parts add up to its square."""

    source: str
    standard_uncertainty_s: float


@final
@dataclass(frozen=True, kw_only=True)
class PredictedUncertainty:
    """Standard uncertainty that a scheme or a set of recordings should reach for one parameter, and its parts."""

    name: str
    standard_uncertainty_s: float
    parts: tuple[PredictedPart, ...]

    @property
    def largest_part(self) -> PredictedPart:
        """What limits it."""
        return max(self.parts, key=lambda part: part.standard_uncertainty_s)


@final
@dataclass(frozen=True, kw_only=True)
class PredictedRelativeDelay:
    """The same for the mean delay of all runs with one set delay at one wheel speed, against those with the smallest, s."""

    nominal_s: float
    rotation_speed_hz: float
    standard_uncertainty_s: float


@final
@dataclass(frozen=True, kw_only=True)
class Prediction:
    """What recordings should tell by the information in them, from the noise of their frames alone and the rig's angles.

    Parameters
    ----------
    noise_to_contrast, opening_pixels
        The camera as the recordings show it, in the words of a camera's description.
    uncertainties
        Of the camera's parameters.
    relative_delays
        Of set delays against the smallest; none where all are the same.
    """

    noise_to_contrast: float
    opening_pixels: float
    uncertainties: tuple[PredictedUncertainty, ...]
    relative_delays: tuple[PredictedRelativeDelay, ...] = ()
