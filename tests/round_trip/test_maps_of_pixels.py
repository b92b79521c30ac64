"""From a simulated camera with known truth to maps of every pixel: the twin and the estimator share no formula."""

from dataclasses import replace

import h5py
import numpy as np
import pytest

from irtiming.interface import measuring
from irtiming.twin import rig as twin
from irtiming.twin.cameras import camera_scene
from irtiming.twin.defects import Defects, with_defects
from irtiming.twin.scene import Faults, microbolometer_scene, with_wheel_speed


@pytest.fixture(scope="module")
def mapped():
    """A rolling microbolometer camera with dead pixels, 400 frames of which 12 are lost, and its true timing."""
    scene = with_wheel_speed(microbolometer_scene(72, 96), 3.0, samples=400)
    scene = replace(
        scene,
        optics=replace(scene.optics, wheel_centre_row_px=scene.optics.wheel_centre_row_px + 3),
        faults=Faults(lost_frames=12),
        detector=replace(scene.detector, dead_pixels=12),
    )
    drawn = twin.draw(scene, seed=21)
    result = measuring.analyse(twin.simulate(drawn.scene, seed=21), drawn.measured, maps=True)
    return result, drawn.scene.timing


def test_pulls_of_all_pixels_against_the_truth_are_about_one(mapped):
    """Oracle: the twin's truth, the same for every pixel but for its row; what all have in common is in no pixel's u."""
    result, true = mapped
    record = result.maps.record
    rows = np.arange(*record.roi[:2])[:, None]
    for image, u, truth in (
        (record.delay_s, np.hypot(record.u_delay_s, record.u_shape_s), true.trigger_delay_s + rows * true.row_delay_s),
        (record.time_constant_s, record.u_time_constant_s, true.time_constant_s),
    ):
        off = image - truth
        seen = np.isfinite(off)
        common = np.average(off[seen], weights=1 / u[seen] ** 2)
        assert 0.9 < np.std((off - common)[seen] / u[seen]) < 1.1
    assert record.n_pixels > 700


def test_the_row_delay_of_the_map_is_that_of_the_fit(mapped):
    """Oracle: the fit of row sums, which asks no single pixel, within both uncertainties; and the truth."""
    result, true = mapped
    record, fitted = result.maps.record, result["row_delay"]
    assert abs(record.row_delay_s - fitted.value) < 2 * np.hypot(fitted.u, record.u_row_delay_s)
    assert abs(record.row_delay_s - true.row_delay_s) < 4 * record.u_row_delay_s


def test_what_all_pixels_have_in_common_is_the_result(mapped):
    """Oracle: the fit of row sums; the map's mean time constant is the result's, with its u, as is a middle row's delay."""
    result, _ = mapped
    record = result.maps.record
    constant, delay, row_delay = result["time_constant"], result["trigger_delay"], result["row_delay"]
    assert record.u_common_time_constant_s == pytest.approx(constant.u)
    told = np.isfinite(record.time_constant_s)
    mean = np.average(record.time_constant_s[told], weights=1 / record.u_time_constant_s[told] ** 2)
    assert mean == pytest.approx(constant.value, abs=4 * constant.u)
    rows = np.arange(*record.roi[:2])[:, None] * np.ones(record.delay_s.shape)
    seen = np.isfinite(record.delay_s)
    np.testing.assert_allclose(record.expected_delay_s[seen], (delay.value + rows * row_delay.value)[seen], rtol=1e-9)
    assert record.u_common_delay_s == pytest.approx(delay.u, rel=0.05)


def test_what_is_dead_and_unseen_is_told_and_nothing_else(mapped):
    """Oracle: the rows and pixels themselves; the simulated readout has neither taps nor another clock."""
    result, _ = mapped
    record, opening = result.maps.record, result.analysis.recordings[0].opening
    codes = {one.code for one in result.maps.findings}
    assert "rows-unseen" in codes
    assert not codes & {"taps-apart", "row-clock-not-even", "map-not-explained"}
    assert ("pixels-dead" in codes) == bool((opening.bad & opening.mask).any())
    seen = np.flatnonzero(np.isfinite(record.delay_s).any(axis=1)) + record.roi[0]
    assert set(seen) | set(record.unseen_row_px) == set(range(72))


def test_maps_go_into_a_file_and_a_table(mapped, tmp_path):
    """Oracle: the maps in memory; NXdata names its signal and axes, and a picture stands beside the file."""
    result, _ = mapped
    maps = result.maps
    with pytest.raises(ValueError, match="read-only"):
        maps["delay_s"][0, 0] = 0.0
    with pytest.raises(KeyError, match="is not among delay_s"):
        maps["delay"]
    assert len(repr(maps)) < 300
    table = maps.to_pandas()
    assert len(table) == maps.record.n_pixels
    first = table.iloc[0]
    place = int(first.row_px) - maps.record.roi[0], int(first.column_px) - maps.record.roi[2]
    assert maps["delay_s"][place] == first.delay_s
    maps.write(tmp_path / "maps.h5")
    assert (tmp_path / "maps.png").read_bytes().startswith(b"\x89PNG")
    with h5py.File(tmp_path / "maps.h5") as file:
        data = file[f"{file.attrs['default']}/{file[file.attrs['default']].attrs['default']}"]
        assert list(data.attrs["axes"]) == ["row", "column"]
        np.testing.assert_array_equal(data[data.attrs["signal"]], maps["delay_s"])
        np.testing.assert_array_equal(data[f"{data.attrs['signal']}_errors"], maps["u_delay_s"])
        assert data["row"][0] == maps.record.roi[0]
        assert data["delay"].attrs["units"] == "s"


def test_levels_that_sway_are_no_noise_of_a_pixel():
    """Oracle: the twin's noise of a pixel, and its delay, the same for all; levels sway by a tenth of the contrast."""
    scene = with_wheel_speed(camera_scene("photon", rows=60, columns=80), 3.0, samples=400)
    scene = replace(scene, optics=replace(scene.optics, rays_along_pixel=32))
    scene = with_defects(scene, Defects(sway_share=0.1))
    drawn = twin.draw(scene, seed=5)
    record = measuring.analyse(twin.simulate(drawn.scene, seed=5), drawn.measured, maps=True).maps.record
    assert np.nanmedian(record.noise_dn) == pytest.approx(drawn.scene.detector.noise_dn, rel=0.05)
    off, u = record.delay_s - np.nanmean(record.delay_s), np.hypot(record.u_delay_s, record.u_shape_s)
    assert 0.85 < np.nanstd(off / u) < 1.15
