r"""What one run of a photon camera can tell: derivatives of the pixel sum, each a closed form (Schatz 2023, eq. 1, figure 4b).

A frame's sum over the opening is  f = covered + step (F + bow U + skew S + plate P + blades B + beside B' + drift t)  with
shapes and slopes of `physics.light.pixel_sum`, averaged over the integration. Its parameters:

===================  =======================================================================================
name                 derivative, at step = 1
===================  =======================================================================================
trigger_delay        omega dF/dtheta: a later exposure sees the wheel further on
integration_time     omega (dF/dsweep + dF/dtheta / 2): the start is held, so that the middle is half as late
opening_angle        dF/dgamma
skew, bow, plate     S, U and P: light that is brighter towards one end, or both; a mask plate that shows around the opening
blades, beside       B and B': blades that are not equally warm, before the opening and before its border
pixel_memory         F(theta - turn of the wheel from frame to frame) - F: a share of the frame before
covered, step        1 and F
drift                time, from -1/2 to 1/2
edge_0 .. edge_3     dF by the edge that comes earlier; an angle error is u times one of them, or their sum
===================  =======================================================================================
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import final

import numpy as np

from irtiming.inference.information import without_own
from irtiming.physics.light import pixel_sum
from irtiming.physics.light.pixel_sum import Passing, shapes
from irtiming.physics.light.summed_region import border_rad
from irtiming.physics.response import pixel_memory
from irtiming.physics.response.integration_window import tail_delay_s, tails
from irtiming.plan.information import RunInformation, run_information
from irtiming.records import sources
from irtiming.records.arrays import Array
from irtiming.records.camera_description import PhotonCamera
from irtiming.records.prediction import AngleErrors
from irtiming.records.wheel_geometry import WheelModel

_PERIMETER = 4.07  # of the paper's mask opening, times the root of its area
_MEAN_RADIUS = 0.944  # the same
_BORDER_PX, _BORDER_OF = 6.0, 1200.0  # that the reduction draws around an opening of so many pixels; it grows slowly
_BORDER_GROWTH = 0.2
_TIMESTAMPS = 2 / 3  # mean square of the weights of the two slots that an angle lies between


@final
@dataclass(frozen=True, kw_only=True)
class Structure:
    """Which parameters each run has for itself and which all runs share; what stands in neither counts as known."""

    own: tuple[str, ...]
    shared: tuple[str, ...]


SHARED_SHAPE = Structure(
    own=("covered", "step", "drift", *pixel_sum.SMALL),
    shared=("trigger_delay", "integration_time", "opening_angle", pixel_memory.PARAMETER, "bow"),
)
"""All runs share opening, integration time, memory and bow, and none is known; each has its own levels, step and drift."""

KNOWN_WINDOW = Structure(
    own=SHARED_SHAPE.own, shared=tuple(name for name in SHARED_SHAPE.shared if name != "integration_time")
)
"""The same, but the integration time is known exactly."""

OWN_SHAPE = Structure(own=(*SHARED_SHAPE.own, "opening_angle"), shared=("trigger_delay", pixel_memory.PARAMETER, "bow"))
"""Each run has an opening of its own, and the integration time is known."""


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Sampling:
    """When a run looks at the wheel: its angle at the start of integration (n,), rad, and the time (n,), -1/2 .. 1/2.

    ``step_rad`` is by how much the wheel turns from frame to frame; ``weight`` is what each sample counts: 1 for a frame.
    """

    wheel_angle_rad: Array
    time: Array
    angular_frequency_rad_per_s: float
    step_rad: float
    weight: float = 1.0


@final
@dataclass(frozen=True, kw_only=True)
class FrameNoise:
    """Noise of a frame: ``share`` of the step, from the pixels, and ``jitter_s``, which acts on the slopes only.

    ``border_rad`` is the border of the summed region, as an angle about the axle.
    """

    share: float
    jitter_s: float
    integration_time_s: float
    border_rad: float


def frame_noise(camera: PhotonCamera) -> FrameNoise:
    """Noise of the sum over an opening of the paper's shape with the border that the reduction draws around it."""
    side = camera.opening_pixels**0.5
    return FrameNoise(
        share=camera.noise_to_contrast / contrast_per_noise(camera.opening_pixels),
        jitter_s=float(np.sqrt(_TIMESTAMPS * camera.gate_jitter_s**2 + camera.camera_jitter_s**2)),
        integration_time_s=camera.integration_time_s,
        border_rad=border_rad(_border_px(camera.opening_pixels), radii_px=_MEAN_RADIUS * side),
    )


def _border_px(opening_pixels: float) -> float:
    return float(_BORDER_PX * (opening_pixels / _BORDER_OF) ** _BORDER_GROWTH)


def contrast_per_noise(opening_pixels: float) -> float:
    """By how much better the sum over the opening with its border is than one pixel: opening over the root of what is summed."""
    of_border = _PERIMETER * opening_pixels**0.5 * _border_px(opening_pixels)
    return float(opening_pixels / (opening_pixels + of_border) ** 0.5)


def one_run(
    sampling: Sampling,
    noise: FrameNoise,
    *,
    model: WheelModel,
    angles: AngleErrors,
    structure: Structure = SHARED_SHAPE,
) -> RunInformation:
    """Information of one run on the shared parameters and the angle errors.

    Parameters
    ----------
    sampling
        Wheel angles of its frames.
    noise
        Of each frame.
    model
        Wheel and opening.
    angles
        Their sizes; an error of an angle acts as that angle over omega on the delay.
    structure
        What is the run's own and what is shared.
    """
    parts = [] if angles.window_tail is None else [*tails(angles.window_tail).values()]
    slopes = derivatives(sampling, noise, model=model, fades_s=[part.time_constant_s for part in parts])
    by_edge = np.array([slopes[f"edge_{k}"] for k in range(4)])
    errors = [(source, u * by_edge.sum(axis=0)) for source, u in angles.common]
    errors += [(sources.EDGES, angles.edge_rad * edge) for edge in by_edge]
    late_s = [
        part.share.standard_uncertainty * tail_delay_s(noise.integration_time_s, part.time_constant_s) for part in parts
    ]
    errors += [
        (sources.TAIL, late * slopes["trigger_delay"] + part.share.standard_uncertainty * slopes[f"tail_{k}"])
        for k, (late, part) in enumerate(zip(late_s, parts, strict=True))
    ]
    sigma = np.hypot(noise.share, noise.jitter_s * slopes["trigger_delay"])
    shared = np.stack([slopes[name] for name in structure.shared] + [column for _, column in errors], axis=1)
    own = np.stack([slopes[name] for name in structure.own], axis=1)
    left = without_own(shared / sigma[:, None], own / sigma[:, None])
    run = run_information(structure.shared, [source for source, _ in errors], matrix=sampling.weight * left.T @ left)
    names = run.frames.names[len(run.frames.names) - len(parts) :]
    return replace(run, centre=dict(zip(names, late_s, strict=True)))


def derivatives(
    sampling: Sampling, noise: FrameNoise, *, model: WheelModel, fades_s: Sequence[float] = ()
) -> dict[str, Array]:
    """Derivative of a frame's sum to each parameter at step 1, by name; shapes (n,), per second, per rad or per 1.

    ``fades_s`` are time constants of what comes after the window.
    """
    omega, sweep = sampling.angular_frequency_rad_per_s, sampling.angular_frequency_rad_per_s * noise.integration_time_s
    passing = Passing(
        wheel=model, middle_rad=sampling.wheel_angle_rad + sweep / 2, edges_early_rad=np.zeros(4),
        opening_angle_rad=model.opening_angle_rad, swept_rad=sweep, border_rad=noise.border_rad,
        tails=tuple((0.0, omega * fade_s) for fade_s in fades_s),
    )  # fmt: skip
    made, slopes = shapes(passing), pixel_sum.slopes(passing)
    before = shapes(replace(passing, middle_rad=passing.middle_rad - sampling.step_rad))
    turned = np.sum([slopes[f"edge_{k}"] for k in range(4)], axis=0)
    return {
        **slopes,
        "trigger_delay": omega * turned,
        "integration_time": omega * (slopes["swept"] + turned / 2),
        **{name: getattr(made, name) for name in pixel_sum.SMALL},
        pixel_memory.PARAMETER: before.fraction - made.fraction,
        "covered": np.ones_like(made.fraction),
        "step": made.fraction,
        "drift": sampling.time,
    }
