"""What a run of a camera whose rows are summed can tell, against brute force."""

from dataclasses import replace

import numpy as np
import pytest

from irtiming.physics import blurred_sector, sector_points, wheel_harmonics
from irtiming.physics.response import first_order_lag
from irtiming.physics.warp import WARP_NUMBERS
from irtiming.physics.wheel import wheel_model
from irtiming.plan import information, rolling_information
from irtiming.plan.rolling_information import IMAGE, RollingRun
from irtiming.records.blur import Blur
from irtiming.records.camera_description import Microbolometer, PhotonCamera
from irtiming.records.prediction import AngleErrors

NAMES = ("trigger_delay", "time_constant", "row_delay")
TURN = 2 * np.pi
MODEL = wheel_model(
    (0.0, TURN / 4, TURN / 2, 3 * TURN / 4), 0.2682, opening_angle_rad=np.radians(75), centre_angle_rad=-np.pi / 2
)
CAMERA = Microbolometer(opening_pixels=600.0)
OTHERS = (
    Microbolometer(opening_pixels=600.0, row_delay_s=None),
    PhotonCamera(opening_pixels=600.0, integration_time_s=4e-3, row_delay_s=20e-6),
)
CALIBRATED = np.eye(len(WARP_NUMBERS)) * 1e12  # px^-2: a lens without errors
ANGLES = AngleErrors(common=(("mask", 5e-4),), edge_rad=1e-4)


@pytest.fixture(scope="module")
def sector():
    """Opening of 600 pixels."""
    return rolling_information.sector_of(CAMERA, float(np.radians(75)))


@pytest.fixture(scope="module")
def run(sector):
    """One run of 1000 frames at 5 Hz."""
    rows = rolling_information.rows_of(sector, n_harmonics=64)
    return RollingRun(camera=CAMERA, rows=rows, angular_frequency_rad_per_s=TURN * 5, n_frames=1000, step_rad=0.622)


@pytest.fixture(scope="module")
def image(sector):
    """Its image."""
    return rolling_information.sector_image(sector)


def _row(run, y, numbers, shape=None):
    """One row over 1000 even wheel angles, wave by wave: four delays, the numbers of response, memory and blade, row delay."""
    omega, light = run.angular_frequency_rad_per_s, run.rows.harmonics[y] if shape is None else shape
    n = light.size - 1
    edges = wheel_harmonics.open_harmonics(MODEL, n)
    waves = sum(
        step * edge * wheel_harmonics.later(omega * (delay + numbers[7] * run.rows.row_px[y]), n_harmonics=n)
        for edge, delay, step in zip(edges, numbers[:4], (1, 1, 1 - numbers[6], 1 - numbers[6]), strict=True)
    )
    order = np.arange(n + 1) * omega
    if isinstance(run.camera, PhotonCamera):
        waves = waves * light * np.sinc(order * numbers[4] / TURN)
    else:
        waves = waves * light * first_order_lag.transfer(omega, numbers[4], n_harmonics=n)
    angle, share = TURN / 1000 * np.arange(1000), numbers[5]
    now, before = (wheel_harmonics.at_angles(waves, angle - late) for late in (0.0, run.step_rad))
    return (1 - share) * now + share * before


def _errors(run, image, *, lens=CALIBRATED):
    """Errors of the image of one run."""
    return rolling_information.image_errors([run], image, model=MODEL, lens=lens)[0]


@pytest.mark.parametrize("camera", [CAMERA, *OTHERS], ids=lambda c: f"{c.readout_mode} {c.camera_type}")
def test_information_on_all_numbers_is_that_of_all_frames(run, camera):
    """Oracle: central differences of each row's 1000 samples; gain and offset of the row taken out by least squares."""
    run, rolls = replace(run, camera=camera), camera.row_delay_s is not None
    response_s = camera.integration_time_s if isinstance(camera, PhotonCamera) else camera.time_constant_s
    at = np.array([0.0, 0, 0, 0, response_s, 0.0, 0.0, camera.row_delay_s or 0.0])
    steps = np.array([1e-7] * 4 + [1e-7, 1e-5, 1e-5, 1e-9])
    k = 8 if rolls else 7
    normal, pull = np.zeros((k, k)), np.zeros((k, 22))
    sums = run.rows.harmonics[:, 0].real + 10.0
    for y, summed in enumerate(sums):
        columns = [
            (_row(run, y, at + step * unit) - _row(run, y, at - step * unit)) / (2 * step)
            for step, unit in zip(steps[:k], np.eye(8)[:k], strict=True)
        ]
        columns += [_row(run, y, at, shape=change) for change in run.rows.changes[:, y]]
        own = np.stack([np.ones(1000), _row(run, y, at)], axis=1)
        free = np.array(columns).T
        free = free - own @ np.linalg.lstsq(own, free, rcond=None)[0]
        free /= camera.noise_to_contrast * np.sqrt(summed)
        normal += free[:, :k].T @ free[:, :k]
        pull -= free[:, :k].T @ free[:, k:]
    found, effect = rolling_information.normal_and_effect(run, MODEL)
    scale = np.sqrt(np.diag(normal))
    np.testing.assert_allclose(found / np.outer(scale, scale), normal / np.outer(scale, scale), atol=1e-5)
    np.testing.assert_allclose(effect, np.linalg.solve(normal, pull), rtol=1e-3, atol=1e-9)


@pytest.mark.parametrize(
    ("camera", "knows", "names"),
    [
        (OTHERS[0], False, ("trigger_delay", "time_constant", "recursive_filter")),
        (OTHERS[1], False, ("trigger_delay", "integration_time", "pixel_memory", "row_delay")),
        (OTHERS[1], True, ("trigger_delay", "pixel_memory", "row_delay")),
    ],
)
def test_a_run_tells_what_its_camera_has(run, image, camera, knows, names):
    """Oracle: by hand; a window that is known adds nothing to its start, and costs its middle nothing."""
    other = replace(run, camera=camera, knows_response=knows)
    assert rolling_information.timing_names(other) == names
    errors = _errors(other, image)
    told = rolling_information.one_run(other, model=MODEL, angles=ANGLES, image=errors)
    assert told.names[: len(names)] == names
    weights = {"trigger_delay": {"trigger_delay": 1.0}}
    if "integration_time" in names:
        weights["middle"] = {"trigger_delay": 1.0, "integration_time": 0.5}
    found = {one.name: one.standard_uncertainty_s for one in information.uncertainties(told, weights)}
    assert 0 < found["trigger_delay"] < 1e-3
    assert found.get("middle", 0) < found["trigger_delay"]


def test_the_image_and_its_derivatives_are_those_of_points_of_light(sector, image):
    """Oracle: all light points of a sector, not its border alone, and differences over ten times the step; else by hand."""
    roi = rolling_information._around(sector)

    def seen(shape):
        points = sector_points.light_points(shape)
        value = np.exp(-2j * (points.angle_rad + shape.bisector_rad))
        sharp = blurred_sector.image(points, value, blur=shape.blur, roi=roi)
        wide = Blur(*np.hypot(shape.blur[:2], shape.glare_px))
        return (1 - shape.glare) * sharp + shape.glare * blurred_sector.image(points, value, blur=wide, roi=roi)

    angle, _ = blurred_sector.pixel_places(sector, roi=roi)
    phase = np.exp(-2j * (angle + sector.bisector_rad))
    light = seen(sector)
    np.testing.assert_allclose(image.light, np.clip(np.abs(light), 0, 1).ravel(), atol=2e-3)
    names = ("axle_row_px", "axle_column_px", "offset_row_px", "offset_column_px", "inner_radius_px", "outer_radius_px",
             "bisector_rad", "opening_angle_rad", "blur_px", "blur_ellipticity", "blur_correlation", "blur_growth",
             "glare")  # fmt: skip
    for name, column in zip(names, image.columns, strict=False):
        step = 1e-3 if name.endswith("rad") else 1e-2
        ahead, behind = (seen(replace(sector, **{name: getattr(sector, name) + sign * step})) for sign in (1, -1))
        expected = ((ahead - behind) / (2 * step) * phase.conj()).ravel()
        assert np.linalg.norm(column - expected) < 0.02 * np.linalg.norm(expected), name
    rows = np.linspace(-1, 1, roi[1] - roi[0])[:, None]
    turned = light * phase.conj()
    for column, expected in zip(
        image.columns[13:17], (1j * rows * turned, 1j * turned, turned, 1 - turned), strict=True
    ):
        np.testing.assert_allclose(column, expected.ravel(), atol=3e-3)


def test_glare_growth_and_shape_of_the_blur_are_known_beforehand(image):
    """Oracle: by hand; 0.03 and 1.5 (k = 1), and four exchanges of pixels in units of what is known of them; nothing else."""
    told = {11: 1 / 1.5**2, 12: 1 / 0.03**2, **dict.fromkeys(range(22, 26), 1.0)}
    np.testing.assert_allclose(image.known, [told.get(k, 0.0) for k in range(35)], rtol=1e-12)


def test_the_images_errors_are_those_of_least_squares(run, image):
    """Oracle: 300 images with noise and gains drawn at random, each fitted; variances known to a twelfth (k = 1)."""
    found = _errors(run, image)
    point = wheel_harmonics.open_harmonics(MODEL, 2).sum(axis=0)[2]
    point *= first_order_lag.transfer(TURN * 5, CAMERA.time_constant_s, n_harmonics=2)[2]
    noise = CAMERA.noise_to_contrast * np.sqrt(2 / 1000) / abs(point)
    border = 4 * image.light * (1 - image.light)
    scatter = np.hypot(CAMERA.gain_scatter * image.light, CAMERA.border_scatter * border)
    along, columns = np.hypot(noise, scatter), image.columns[:26]
    design = np.concatenate([columns.real / along, columns.imag / noise, np.diag(np.sqrt(image.known[:26]))], axis=1).T
    scale = np.linalg.norm(design, axis=0)
    random = np.random.default_rng(3)
    drawn = random.normal(size=(300, len(design)))
    fitted = np.linalg.lstsq(design / scale, drawn.T, rcond=None)[0][:13] / scale[:13, None]
    expected = np.sqrt(np.mean(fitted**2, axis=1))
    np.testing.assert_allclose(np.sqrt(np.diag(found.noise + found.stays))[:13], expected, rtol=0.15)


def _equal(run):
    """The same with pixels of one gain and a mask without burrs."""
    return replace(run, camera=replace(CAMERA, gain_scatter=0.0, border_scatter=0.0))


def test_equal_pixels_leave_noise_alone(run, image):
    """Oracle: without scatter of gains, burrs and priors there is no such error, and noise goes with the root of the frames."""
    even, image = _equal(run), replace(image, known=0 * image.known)
    found = _errors(even, image)
    longer = _errors(replace(even, n_frames=4000), image)
    assert np.abs(found.stays[:13, :13]).max() < 1e-9
    np.testing.assert_allclose(np.diag(found.noise)[:13], 4 * np.diag(longer.noise)[:13], rtol=1e-6)


def _predicted(run, image, *, n_runs=1, angles=ANGLES):
    errors = _errors(run, image)
    told = rolling_information.one_run(run, model=MODEL, angles=angles, image=errors).times(n_runs)
    found = information.uncertainties(told, {name: {name: 1.0} for name in NAMES})
    return {each.name: each for each in found}


def test_many_runs_leave_the_angles_and_the_pixels_gains(run, image):
    """Oracle: by hand, 0.5 mrad and half of 0.1 mrad over omega; time constant and row delay know no angles."""
    found = _predicted(run, image, n_runs=10**8)
    angle = np.sqrt(5e-4**2 + 1e-4**2 / 4) / (TURN * 5)
    assert found["trigger_delay"].standard_uncertainty_s == pytest.approx(angle, rel=0.05)
    for name in ("time_constant", "row_delay"):
        parts = {part.source: part.standard_uncertainty_s for part in found[name].parts}
        assert parts[IMAGE] == pytest.approx(found[name].standard_uncertainty_s, rel=0.01)
        assert parts["mask"] < 1e-3 * parts[IMAGE]


def test_noise_falls_with_the_root_of_the_runs(run, image):
    """Oracle: the law of means, where no pixel differs from another, nothing else tells the image, and all angles are known."""
    even, image = _equal(run), replace(image, known=0 * image.known)
    exact = AngleErrors(common=(), edge_rad=0.0)
    one, many = (_predicted(even, image, n_runs=n, angles=exact) for n in (1, 25))
    for name in NAMES:
        assert one[name].standard_uncertainty_s == pytest.approx(5 * many[name].standard_uncertainty_s, rel=1e-3)


def test_rows_that_stand_for_others_tell_what_all_would(sector, run, monkeypatch):
    """Oracle: all rows of the opening, one by one; some of them stand for the rest within a tenth."""
    monkeypatch.setattr(rolling_information, "_ROWS", 8)
    fewer = replace(run, rows=rolling_information.rows_of(sector, n_harmonics=64))
    assert fewer.rows.weight == run.rows.row_px.size // 8
    every, _ = rolling_information.normal_and_effect(run, MODEL)
    some, _ = rolling_information.normal_and_effect(fewer, MODEL)
    np.testing.assert_allclose(np.diag(np.linalg.inv(some)), np.diag(np.linalg.inv(every)), rtol=0.1)


@pytest.mark.parametrize("distortion", [-0.05, 0.0, 0.3])
def test_a_lens_that_draws_the_opening_larger_hides_no_row(monkeypatch, distortion):
    """Oracle: the image of all rows; those with the light of three pixels or more, of an opening of 6000."""
    monkeypatch.setattr(rolling_information, "_SHAPE", ("blur_px",))  # whose changes are made: one is enough
    bent = replace(rolling_information.sector_of(Microbolometer(opening_pixels=6000.0), 1.309), distortion=distortion)
    points, columns = sector_points.light_points(bent), (-bent.image_columns, 2 * bent.image_columns)
    lit = blurred_sector.image(
        points, np.ones(points.row_px.size, complex), blur=bent.blur, roi=(0, bent.image_rows, *columns)
    )
    expected = np.flatnonzero(lit.real.sum(axis=1) > 3.0)
    assert rolling_information.rows_of(bent, n_harmonics=4).row_px.tolist() == expected.tolist()


def test_each_number_leaves_a_row_as_much_light_as_the_image_shows(run):
    """Oracle: a law; the light of each summed pixel is in the contrast image, so that order 0 of a row's light stays."""
    light = run.rows.harmonics[:, 0].real
    changes = {name: run.rows.changes[k, :, 0].real for k, name in enumerate(rolling_information._SHAPE)}
    assert np.abs(changes["glare"] / light).max() < 1e-6
    assert max(np.abs(change).max() for change in changes.values()) < 1e-4 * light.max()


def test_numbers_of_very_unequal_size_keep_their_covariance():
    """Oracle: the covariance that the columns add up to by what they are; standard deviations of 1e6, 1 and 1e-6, correlated."""
    size = np.array([1e6, 1.0, 1e-6])
    covariance = np.outer(size, size) * (0.5 + 0.5 * np.eye(3))
    root = rolling_information._root(covariance)
    np.testing.assert_allclose(root @ root.T, covariance, rtol=1e-9)
