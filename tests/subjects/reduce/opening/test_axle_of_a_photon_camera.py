"""Axle and mask in the image of a photon camera, from frames rendered by brute force about a known axle."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from irtiming.estimate import shape, wheel_geometry
from irtiming.records.choices import Choices
from irtiming.records.rig import CameraOptics, Measured, Wheel
from irtiming.reduce import recipes

CLOCK_HZ = 49_152_000
DEG = float(np.radians(1))
FINE = {"sub": 16, "n_angles": 2880}
ABOUT = {
    "a known lens that distorts": ({"axle": (48.0, 40.3), "clockwise": False, "blur_px": 0.5, "distortion": -0.05} | FINE,
                                   Measured(-0.05 * 0.64, 1e-4 * 0.64)),  # 4 : 3, over half the width
    "an unknown lens": ({"axle": (47.37, 39.81), "blur_px": 1.0} | FINE, None),
}  # fmt: skip
BESIDE = (
    {"mask_centre": (0.0, 0.6)},
    {"mask_centre": (0.5, -0.4), "bisector_rad": -87 * DEG},
    {"mask_centre": (-0.7, 0.2), "bisector_rad": -95 * DEG, "clockwise": False},
)
"""Where the mask's own centre lies beside the axle, rows and columns, in a camera that may be rolled."""
BENT = [
    {"axle": (48.0, 34.6), "distortion": k, "bisector_rad": -87 * DEG, "clockwise": k < 0, "sub": 24, "n_angles": 5760}
    for k in (-0.1, 0.1)
]


@pytest.fixture(scope="module")
def reduced(paper_wheel, recorded, rig):
    """Reduce 500 frames of a camera and fit its contrast image: ``reduced(camera, spoil=..., **fields)``.

    Frames go through the whole recipe; those of a camera are rendered once, and unspoilt ones reduced once for a stated lens.
    """
    wheel = paper_wheel(duration_s=17.5)
    base = recorded(wheel, n_triggers=500)
    times = (base.camera_trigger_ticks - wheel.start) / CLOCK_HZ
    rendered = cache(lambda camera: camera.frames(wheel.theta, times))

    def run(camera, *, spoil=lambda frames: frames, lens=None, **fields):
        frames = spoil(rendered(camera).copy())
        own = replace(
            rig,
            wheel=Wheel(rotation="clockwise" if camera.clockwise else "counterclockwise"),
            camera=CameraOptics() if lens is None else CameraOptics(distortion=lens),
        )
        seen = recipes.reduce(recorded(wheel, n_triggers=500, frames=frames, **fields), own, choices=Choices())
        model = wheel_geometry.geometry([seen], own, slots="learned", off_axle_mask=False).model
        return shape.estimate([seen], model, rig=own)[0]

    plain = cache(run)

    def fitted(camera, *, lens=None, **options):
        return run(camera, lens=lens, **options) if options else plain(camera, lens=lens)

    return fitted


@cache
def _true_offset(camera):
    """Mean polar angle about the axle of the points that the mask lets through, minus the mask's own bisector."""
    row, column, through = replace(camera, sub=16).points()
    phi = np.arctan2(*camera.beside_axle(row[through], column[through]))
    return np.mean(np.angle(np.exp(1j * (phi - camera.bisector_rad))))


@pytest.mark.parametrize("name", ABOUT)
def test_axle_is_found_within_a_twentieth_of_a_pixel(reduced, paper_camera, name):
    """Oracle: the axle about which the wheel was rendered, turning either way.

    Behind a lens of which nobody knows how much it distorts, the axle is found within its uncertainty, which then is larger.
    """
    about, lens = ABOUT[name]
    view = reduced(paper_camera(**about), lens=lens).axle
    within = 0.05 if lens is not None else 3 * view.u_centre_px
    assert view.row_px == pytest.approx(about["axle"][0], abs=within)
    assert view.column_px == pytest.approx(about["axle"][1], abs=within)
    assert view.bisector_rad == pytest.approx(np.radians(-90), abs=2e-3)
    assert view.mean_angle_rad - view.bisector_rad == pytest.approx(0, abs=1.5e-3)
    assert 0 < view.u_centre_px < 0.05


@pytest.mark.parametrize("beside", BESIDE)
def test_mask_beside_the_axle(reduced, paper_camera, beside):
    """Oracle: sums over a million points of the mask; 0.6 px at 26 px are 20 mrad of mean angle, and 0 of bisector."""
    camera = paper_camera(**beside)
    view = reduced(camera).axle
    assert view.row_px == pytest.approx(camera.axle[0], abs=0.05)
    assert view.column_px == pytest.approx(camera.axle[1], abs=0.05)
    assert view.bisector_rad == pytest.approx(camera.bisector_rad, abs=2.5e-3)
    assert view.mean_angle_rad - view.bisector_rad == pytest.approx(_true_offset(camera), abs=2e-3)


@pytest.mark.parametrize("bent", BENT)
def test_a_lens_that_distorts_is_told_and_taken_out(reduced, paper_camera, bent):
    """Oracle: the lens, axle and mask that were rendered; the axle a quarter of the image beside its middle.

    Rendered finely: points an eighth of a pixel and a quarter of a degree apart look like a tilt by a degree, and move the axle.
    """
    camera = paper_camera(**bent)
    view = reduced(camera).axle
    assert view.distortion == pytest.approx(camera.distortion, abs=0.01)
    assert abs(view.distortion - camera.distortion) < 4 * view.u_distortion < 0.1
    assert view.row_px == pytest.approx(48.0, abs=0.05)
    assert view.column_px == pytest.approx(34.6, abs=0.05)
    assert view.bisector_rad == pytest.approx(camera.bisector_rad, abs=2.5e-3)
    assert view.mean_angle_rad - view.bisector_rad == pytest.approx(_true_offset(camera), abs=2e-3)


def test_a_lens_that_rig_toml_states_is_taken(reduced, paper_camera):
    """Oracle: the number stated, with an uncertainty far below what the frames tell."""
    about, lens = ABOUT["a known lens that distorts"]
    view = reduced(paper_camera(**about), lens=lens).axle
    assert view.distortion == pytest.approx(-0.05, abs=2e-4)
    assert view.u_distortion == pytest.approx(1e-4, rel=0.1)
    assert view.row_px == pytest.approx(48.0, abs=0.05)


def test_uneven_light_does_not_turn_the_mask(reduced, paper_camera):
    """Oracle: the mask that was rendered; towards one end of it the wheel looks up to 8 % of the contrast colder.

    What that adds has angles of its own, on the right, where wheel coordinates are less if it turns clockwise.
    """
    camera = paper_camera(**BESIDE[0])
    row, column = np.mgrid[: camera.rows, : camera.columns]
    spot = np.exp(-((row - 28) ** 2 + (column - 54) ** 2) / (2 * 8.0**2))

    def spoil(frames):
        wheel = (6000.0 - frames) / 1050
        return np.clip(np.rint(frames - 80 * spot * wheel), 0, 16383).astype(np.uint16)

    even, uneven = reduced(camera).axle, reduced(camera, spoil=spoil).axle
    assert uneven.bisector_rad == pytest.approx(even.bisector_rad, abs=2e-3)
    assert uneven.mean_angle_rad == pytest.approx(even.mean_angle_rad, abs=2e-3)
    beside, of_spot = (
        float(np.array(one.uneven_share) @ np.convolve(one.beside_ends_rad, [0.5, 0.5], "valid"))
        for one in (even, uneven)
    )
    assert of_spot < -2e-4 < beside


def test_stated_uncertainties_of_bisector_and_mean_angle_are_those_of_the_errors(reduced, paper_camera):
    """Oracle: seven masks rendered at known places; errors over stated uncertainties are about one, neither more nor less."""
    pulls = []
    for about, lens in [*ABOUT.values(), *((one, None) for one in (*BESIDE, *BENT))]:
        camera = paper_camera(**about)
        view = reduced(camera, lens=lens).axle
        off = view.mean_angle_rad - view.bisector_rad - _true_offset(camera)
        pulls.append([(view.bisector_rad - camera.bisector_rad) / view.u_bisector_rad, off / view.u_off_axle_rad])
    spread = np.sqrt(np.mean(np.square(pulls), axis=0))
    assert np.all((spread > 0.4) & (spread < 1.6)), spread


@pytest.mark.parametrize("beside", BESIDE[1:])
def test_edges_miss_the_axle_as_the_mask_lies_beside_it(reduced, paper_camera, beside):
    """Oracle: the distance of the axle from each edge's straight line, which goes through the mask's own centre."""
    camera = paper_camera(**beside)
    view = reduced(camera).axle
    ends = camera.bisector_rad + np.array([-0.5, 0.5]) * camera.opening_rad
    miss = np.cos(ends) * camera.mask_centre[0] - np.sin(ends) * camera.mask_centre[1]
    assert view.edge_miss_px == pytest.approx(miss, abs=4 * view.u_edge_miss_px)
    assert 0 < view.u_edge_miss_px < 0.1


@pytest.fixture(scope="module")
def spoilt(reduced, paper_camera):
    """A screw that swings by 30 % of the contrast, a pixel 20 % too little; ten frames of five hundred are blank."""

    def spoil(frames):
        swing = (frames.astype(float) - 4950) / 1050
        screw = 300 * (swing[:, 20, 40] > 0.5)
        frames[:, 7:10, 39:42] += screw.astype(np.uint16)[:, None, None]
        frames[:, 25, 40] -= np.rint(200 * np.clip(swing[:, 25, 40], 0, 1)).astype(np.uint16)
        frames[100:110] = 0
        return frames

    return reduced(paper_camera(**BESIDE[0]), spoil=spoil)


def test_a_screw_beside_the_opening_and_a_bad_pixel_in_it_do_not_turn_the_mask(reduced, paper_camera, spoilt):
    """Oracle: the same mask without them."""
    clean = reduced(paper_camera(**BESIDE[0])).axle
    assert spoilt.axle.bisector_rad == pytest.approx(clean.bisector_rad, abs=5e-4)
    assert spoilt.axle.row_px == pytest.approx(clean.row_px, abs=0.02)


def test_blank_frames_do_not_move_the_axle(reduced, paper_camera, spoilt):
    """Oracle: the axle found without them; they are dropped and told."""
    clean = reduced(paper_camera(**BESIDE[0])).axle
    assert spoilt.axle.row_px == pytest.approx(clean.row_px, abs=0.02)
    assert spoilt.axle.column_px == pytest.approx(clean.column_px, abs=0.02)
    assert spoilt.pixels.pixel_sum.size == 490
    assert any(
        "10 frames dropped: more than half of the pixels are at zero" in finding.what for finding in spoilt.findings
    )


def test_dead_pixels_do_not_turn_the_mask(reduced, paper_camera, flat_reference):
    """Oracle: the same mask on a detector without dead pixels; eight of 1400 pixels of the opening are dead."""
    camera = paper_camera(**BESIDE[0])
    gain = np.ones((60, 80))
    dead = [(22, 42), (25, 44), (20, 48), (27, 41), (30, 43), (18, 44), (33, 45), (24, 52)]

    def spoil(frames):
        for pixel in dead:
            frames[(slice(None), *pixel)] = 200
        return frames

    clean = reduced(camera).axle
    for pixel in dead:
        gain[pixel] = 0
    view = reduced(camera, spoil=spoil, nonuniformity=flat_reference(gain, np.zeros((60, 80)))).axle
    assert view.row_px == pytest.approx(clean.row_px, abs=0.01)
    assert view.column_px == pytest.approx(clean.column_px, abs=0.01)
    assert view.bisector_rad == pytest.approx(clean.bisector_rad, abs=4e-4)
    assert view.mean_angle_rad == pytest.approx(clean.mean_angle_rad, abs=4e-4)


def test_frames_outside_the_edges_do_not_move_the_axle(reduced, paper_camera, paper_wheel):
    """Oracle: the axle found without them; the first eighth of the slots is not recorded, the turn unevenly sampled."""
    slots = paper_wheel(duration_s=17.5).control_slot_ticks()
    camera = paper_camera(**BESIDE[0])
    whole, late = reduced(camera), reduced(camera, control_slot_ticks=slots[600:])
    assert late.axle.row_px == pytest.approx(whole.axle.row_px, abs=0.07)
    assert late.axle.column_px == pytest.approx(whole.axle.column_px, abs=0.07)
    assert any(
        "frames dropped: triggered where no control slots were recorded" in finding.what for finding in late.findings
    )
    assert 430 < late.pixels.pixel_sum.size < 460
