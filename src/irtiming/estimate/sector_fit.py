"""The opening's place and shape from the contrast image: where the axle lies, which way the mask points, how sharp it is.

Each pixel of the opening is covered and uncovered in its own time. So the phases of the contrast image tell polar angles
about the axle, and its amplitudes tell the mask: an annular sector, blurred, whose own centre need not be the axle. What a
pixel's projection would be is computed with the very weights that made it, so that missing frames do no harm.

Two things spoil amplitudes and leave phases alone: pixels differ in gain, and the solid wheel mirrors the camera unevenly.
So a pixel's deviation is split along and across its phase; only along it may differ by the pixels' gain scatter. What is left
along it counts as light, noise and all: the same noise is in the row sums, where it then does less harm than the doubt.

A lens that distorts moves the phases where the axle is not in the middle of the image, and a tilted camera moves the mask's arcs.
Where the image says nothing of lens and tilt they hardly matter; then what rig.toml states holds, or what no camera exceeds.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from scipy import ndimage

from irtiming.estimate import sector_best, sector_guess, sector_images, sector_limits, sector_weighed
from irtiming.estimate.row_light import SHAPE_NUMBERS, STEP_OF, Variations
from irtiming.estimate.sector_best import Best
from irtiming.estimate.sector_image import SeenContrast, View
from irtiming.estimate.sector_images import FIRST_SCATTER, Images, border_weight, numbers_of
from irtiming.estimate.sector_search import BETWEEN, FIRST, LAST, Slopes
from irtiming.inference import clustered, in_threads
from irtiming.inference.weighed_lens import SLIGHT
from irtiming.physics.camera import camera
from irtiming.physics.light.row_sum import Timing
from irtiming.records.arrays import Array, Mask
from irtiming.records.reduced import ReducedRecording
from irtiming.records.rig import Rig
from irtiming.records.row_timing import SectorFit
from irtiming.records.wheel_geometry import WheelModel

_WELL_INSIDE = 0.99  # of full contrast
_FEWEST_PIXELS = 30
_BORDER = 0.35  # about half of full contrast
_ODD = 10  # times the standard deviation
_NEIGHBOURS = np.array([[1, 1, 1], [1, 0, 1], [1, 1, 1]], bool)
_STARTS = 3  # fits: seen with timing and noise that are not known yet, an image may look like any lens
_BESIDE_PLACE = (
    "blur_ellipticity", "blur_correlation", "blur_growth", "glare", "glare_px", "ring_inner_px", "ring_outer_px",
    "plate_reflection",
)  # left alone while the place is looked for  # fmt: skip
_RING_MARGINS_PX = (0.5, 1.0, 1.5, 2.5, 4.0, 6.0, 9.0, 13.0, 20.0, 30.0)  # beside the opening
_LINEAR, _MOST_WEIGHINGS = 4.0, 4  # sum of squares by which an image may be bent; searches anew


def fit(
    recordings: Sequence[ReducedRecording], wheel: WheelModel, *, rig: Rig, timing: Timing, start: SectorFit | None = None,
    slopes: Slopes | None = None,
) -> SectorFit:  # fmt: skip
    """Sector fitted to the contrast images of all recordings; the first fits are but starts, for which any lens will do.

    Parameters
    ----------
    recordings
        Of one camera in one place.
    wheel
        Geometry of wheel and gates.
    rig
        Which way the wheel turns, and what is known of the lens.
    timing
        As known so far.
    start
        An earlier fit; without one it starts at what the image shows.
    slopes
        Of the fits before of the same images, with which it begins; the covariance is theirs then. A fit without a start has
        its own and leaves none.

    Raises
    ------
    EstimationError
        If the image shows no sector.
    """
    images = sector_images.of(recordings, wheel, rig=rig, timing=timing, known=start)
    is_first = start is None or start.n_rounds < _STARTS
    best = _from(images, held=_held(recordings[0]), slopes=slopes, is_first=is_first)
    return _as_it_is(images, best, start=start)


def half_way(
    recordings: Sequence[ReducedRecording], wheel: WheelModel, *, rig: Rig, timing: Timing, start: SectorFit,
    slopes: Slopes | None = None,
) -> SectorFit:  # fmt: skip
    """The middle between an earlier fit and the one from there on: images and rows that go to and fro meet there; see `fit`."""
    images = sector_images.of(recordings, wheel, rig=rig, timing=timing, known=start)
    best = _from(images, held=_held(recordings[0]), slopes=slopes)
    middle = {name: (images.begin[name] + value) / 2 for name, value in best.numbers.items()}
    return _as_it_is(images, replace(best, numbers=middle), start=start)


def settled(
    recordings: Sequence[ReducedRecording], wheel: WheelModel, *, rig: Rig, timing: Timing, start: SectorFit,
    slopes: Slopes | None = None,
) -> SectorFit:  # fmt: skip
    """The last fit: with lens and tilt weighed (`sector_weighed`), for which fits before are but starts; see `fit`.

    Where the weighed ones lie so far from the best that the image is bent between both, a search begins there anew.
    """
    images = sector_images.of(recordings, wheel, rig=rig, timing=timing, known=start)
    held = _held(recordings[0])
    best = _from(images, held=held, slopes=slopes, gain=LAST)
    last = sector_weighed.weighed(images, best)
    if last.beside_linear > _LINEAR:
        begin = best.numbers | {name: last.camera.value(name) for name in SLIGHT}
        for _ in range(_MOST_WEIGHINGS):
            best = sector_best.searched(images, begin=begin, held=(*SLIGHT, *held), gain=LAST)
            last = sector_weighed.weighed(images, best)
            if last.beside_linear <= _LINEAR:
                break
            begin = last.numbers
    told = _told(images, last.numbers, names=last.names, covariance=last.covariance, chi_square=best.chi_square)
    return replace(told, n_rounds=start.n_rounds + 1, gained=best.gained, camera=last.camera)


def fit_row_by_row(
    recordings: Sequence[ReducedRecording], wheel: WheelModel, *, rig: Rig, timing: Timing, start: SectorFit,
    slopes: Slopes | None = None,
) -> SectorFit:  # fmt: skip
    """The same with a row delay of its own, of a camera that is said to read all rows at once; see `fit`.

    A search as rough as a first one, from where all else is settled: it is asked whether rows differ, and a step tells.
    """
    images = sector_images.of(recordings, wheel, rig=rig, timing=timing, known=start)
    return _as_it_is(images, _from(images, held=(), slopes=slopes, gain=FIRST), start=start)


def _held(recording: ReducedRecording) -> tuple[str, ...]:
    """Numbers that this kind of camera has not."""
    return () if camera(recording.camera_type, recording.readout_mode).readout.PARAMETERS else ("row_delay_s",)


def _from(
    images: Images, *, held: tuple[str, ...], slopes: Slopes | None, is_first: bool = False, gain: float = BETWEEN
) -> Best:
    """Best numbers from an earlier fit on; from what the image shows without one, and then without lens and tilt.

    One of the first fits may have any lens.
    """
    if not images.begin:
        return _first(images, held=(*SLIGHT, *held))
    best = sector_best.searched(images, begin=images.begin, held=held, gain=gain, slopes=slopes)
    if "distortion" in best.free and not is_first:
        sector_limits.check_lens(
            best.numbers, images.lens.start, name=images.name, columns=images.view.image[1], sense=images.sense
        )
    return best


def _first(images: Images, *, held: tuple[str, ...]) -> Best:
    """From what the image shows on: its place first, for blur and ring mean nothing elsewhere."""
    begin = _first_guess(images, held=held)
    place = sector_best.searched(images, begin=begin, held=(*held, *_BESIDE_PLACE), gain=FIRST)
    return sector_best.searched(images, begin=_ring_tried(images, place.numbers), held=held, gain=FIRST)


def _ring_tried(images: Images, numbers: dict[str, float]) -> dict[str, float]:
    """The numbers with those radii of the ring, of some, that suit the images best: slopes tell no more than the next pixel."""
    sharp, best = images.sharp(numbers), dict(numbers)
    for name, border, way in (("ring_outer_px", "outer_radius_px", 1), ("ring_inner_px", "inner_radius_px", -1)):
        tried = [best | {name: max(best[border] + way * margin, 0.0)} for margin in _RING_MARGINS_PX]
        left = [float(np.sum(images.residuals(one, sharp) ** 2)) for one in tried]
        best = tried[int(np.argmin(left))]
    return best


def _first_guess(images: Images, *, held: tuple[str, ...]) -> dict[str, float]:
    first, *others = images.seen
    guess = sector_guess.first_guess(first, images.view, is_rolling="row_delay_s" not in held)
    return sector_images.turned(others, guess | images.lens.start, view=images.view)


def _as_it_is(images: Images, best: Best, *, start: SectorFit | None) -> SectorFit:
    covariance = clustered.covariance(best.slopes, best.residual, clusters=best.clusters)
    told = _told(images, best.numbers, names=best.free, covariance=covariance, chi_square=best.chi_square)
    return replace(told, n_rounds=1 if start is None else start.n_rounds + 1, gained=best.gained)


def guess(recordings: Sequence[ReducedRecording], wheel: WheelModel, *, rig: Rig, timing: Timing) -> SectorFit:
    """The sector with which a search would begin, for a first look at the rows; its covariance is zero.

    Parameters as for `fit`.
    """
    images = sector_images.of(recordings, wheel, rig=rig, timing=timing, known=None)
    told = _told(
        images, _first_guess(images, held=_held(recordings[0])), names=(), covariance=np.zeros((0, 0)), chi_square=1.0
    )
    return replace(told, n_rounds=0)


def variations(
    recordings: Sequence[ReducedRecording], wheel: WheelModel, *, rig: Rig, timing: Timing, found: SectorFit
) -> Variations:
    """The fitted sector with each number of its shape a little larger, and what the same images then leave over.

    Pixels of the contrast image show their own amount of light, so a number that is off changes little but where that light
    lies. Parameters as for `fit`, which gave ``found``.
    """
    images = sector_images.of(recordings, wheel, rig=rig, timing=timing, known=found)
    numbers = {**images.begin, **numbers_of(found)}
    steps = tuple(STEP_OF[name] for name in found.names)
    moved = [numbers | {name: numbers[name] + step} for name, step in zip(found.names, steps, strict=True)]
    at, *beside = in_threads.mapped(
        lambda one: replace(found, **_light(images.contrast(one), one, view=images.view)), [numbers, *moved]
    )
    return Variations(at=at, beside=tuple(beside), steps=steps)


def _told(
    images: Images,
    numbers: Mapping[str, float],
    *,
    names: Sequence[str],
    covariance: Array,
    chi_square: float,
) -> SectorFit:
    """The measured contrast, split into sector, plate and excess, with what is known of the numbers and how well all fits."""
    view, seen = images.view, images.contrast(numbers)
    inside = view.good & (seen.sharp > _WELL_INSIDE)
    border = view.good & (np.abs(seen.sharp - 0.5) < _BORDER)
    weight = border_weight(seen.sharp, numbers["blur_px"])
    gains = _scatter(seen.residual[inside], seen.u)
    burrs = _scatter((seen.residual / weight)[border], seen.u)
    of_shape = [k for k, name in enumerate(names) if name in SHAPE_NUMBERS]
    variance = dict(zip(names, np.diag(covariance).tolist(), strict=True))
    return SectorFit(
        **_light(seen, numbers, view=view),
        names=tuple(names[k] for k in of_shape),
        covariance=covariance[np.ix_(of_shape, of_shape)],
        contrast=seen.model + seen.residual,
        model_contrast=seen.light,
        unevenness=seen.unevenness,
        field_height=seen.field_height,
        gain_scatter=gains,
        border_scatter=burrs,
        summed=view.summed,
        odd=_odd(seen, weight, gain_scatter=gains, border_scatter=burrs),
        turn_rad=numbers["turn_rad"],
        ring_radii_px=(numbers["ring_inner_px"], numbers["ring_outer_px"]),
        plate_reflection=numbers["plate_reflection"],
        row_delay_s=numbers["row_delay_s"],
        u_row_delay_s=float(np.sqrt(variance.get("row_delay_s", 0.0))),
        reduced_chi_square=chi_square,
        roi=view.roi,
        n_rounds=1,
        gained=0.0,
    )


def _light(seen: SeenContrast, numbers: Mapping[str, float], *, view: View) -> dict[str, Any]:
    """Where the light comes from: the fields of a `SectorFit` that say so."""
    summed = np.where(view.summed, 1.0, 0.0)
    return {
        "shape": view.shape(numbers),
        "plate": seen.plate,
        "ring": seen.over_ring * summed,
        "swept": seen.ring * summed,
        "ring_angle_rad": seen.ring_angle_rad,
        "borrowed": _borrowed(seen.model, view) * summed,
        "borrowed_angle_rad": seen.light_angle_rad,
        "excess": seen.residual * summed,
        "excess_angle_rad": np.where(seen.light > 0.5, seen.light_angle_rad, seen.centre_angle_rad),
    }


def _borrowed(light: Array, view: View) -> Array:
    """What dead pixels do not show of the light, and what their stand-ins show in their place."""
    out = np.zeros(light.shape)
    for row, column, beside in view.stand_ins:
        out[row, column] -= light[row, column]
        out[row, beside] += light[row, beside] / len(beside)
    return out


def _scatter(residual: Array, u: float) -> float:
    """Standard deviation beyond the noise."""
    beyond = float(np.mean(residual**2)) - u**2 if residual.size > _FEWEST_PIXELS else FIRST_SCATTER**2
    return float(np.sqrt(max(beyond, 0.0)))


def _odd(seen: SeenContrast, border: Array, *, gain_scatter: float, border_scatter: float) -> Mask:
    """Pixels that stray from the model far more than noise, gains and the border's weight (roi rows, roi columns) let them.

    A dead pixel beside the opening strays by little, but alone: there no gain acts on light, so neighbours tell.
    """
    burrs = border_scatter * border
    usual = np.hypot(np.hypot(seen.u, gain_scatter), burrs)
    beside = seen.residual - ndimage.median_filter(seen.residual, footprint=_NEIGHBOURS)
    alone = np.hypot(np.hypot(seen.u, gain_scatter * np.clip(seen.light, 0, 1)), burrs)
    return np.asarray((np.abs(seen.residual) > _ODD * usual) | (np.abs(beside) > _ODD * alone))
