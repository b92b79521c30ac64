"""What must be known of a camera before it is measured, to foretell how well it can be."""

import math
from dataclasses import dataclass
from typing import TypeAlias, final

from irtiming.errors import PlanError
from irtiming.records.recording import CameraType, ReadoutMode


@final
@dataclass(frozen=True, kw_only=True)
class PhotonCamera:
    """A photon camera; the defaults are the camera of Schatz 2023, section 3.1, with 38 mK of noise and 9 K of contrast.

    Parameters
    ----------
    noise_to_contrast
        Standard deviation of one pixel from frame to frame over the difference between blackbody and wheel; both in DN or both
        in K.
    opening_pixels
        Pixels within the image of the mask opening.
    integration_time_s
        T_int.
    gate_jitter_s, camera_jitter_s
        Standard deviations of one timestamp of the control gate and of the camera's delay from frame to frame; of a snapshot.
    row_delay_s
        t_row, roughly, of a rolling camera; None for a snapshot.
    gain_scatter, border_scatter
        Standard deviations of the pixels' gains and, as a share of the contrast, of pixels that the mask's border halves: masks
        have burrs. They matter where rows are summed.
    """

    noise_to_contrast: float = 0.0042
    opening_pixels: float = 21_800.0
    integration_time_s: float = 250e-6
    gate_jitter_s: float = 0.3e-6
    camera_jitter_s: float = 0.05e-6
    row_delay_s: float | None = None
    gain_scatter: float = 0.01
    border_scatter: float = 0.01

    def __post_init__(self) -> None:
        _check(
            ("noise over contrast", self.noise_to_contrast),
            ("number of pixels in the opening", self.opening_pixels),
            ("integration time in seconds", self.integration_time_s),
        )

    @property
    def camera_type(self) -> CameraType:
        """What its pixels do."""
        return "photon"

    @property
    def readout_mode(self) -> ReadoutMode:
        """How they are read."""
        return _readout(self.row_delay_s)


@final
@dataclass(frozen=True, kw_only=True)
class Microbolometer:
    """A microbolometer; the defaults are the camera of Schatz 2023, section 3.2, with 62 mK of noise and 8 K of contrast.

    Parameters
    ----------
    noise_to_contrast, opening_pixels
        As for a photon camera.
    time_constant_s, row_delay_s
        tau and t_row, roughly; no row delay makes it a snapshot camera.
    gain_scatter, border_scatter
        As for a photon camera.
    """

    noise_to_contrast: float = 0.0078
    opening_pixels: float = 33_100.0
    time_constant_s: float = 4.8e-3
    row_delay_s: float | None = 38.8e-6
    gain_scatter: float = 0.01
    border_scatter: float = 0.01

    def __post_init__(self) -> None:
        _check(
            ("noise over contrast", self.noise_to_contrast),
            ("number of pixels in the opening", self.opening_pixels),
            ("time constant in seconds", self.time_constant_s),
        )

    @property
    def camera_type(self) -> CameraType:
        """What its pixels do."""
        return "microbolometer"

    @property
    def readout_mode(self) -> ReadoutMode:
        """How they are read."""
        return _readout(self.row_delay_s)


Camera: TypeAlias = PhotonCamera | Microbolometer


def _readout(row_delay_s: float | None) -> ReadoutMode:
    return "snapshot" if row_delay_s is None else "rolling"


def _check(*numbers: tuple[str, float]) -> None:
    for name, number in numbers:
        if not (number > 0 and math.isfinite(number)):
            raise PlanError(f"the {name} is {number:g}, but must be greater than 0 and finite; correct it")
