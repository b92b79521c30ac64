"""A simulated readout with two taps: the map finds it, and the fit of row sums has one delay all the same."""

from dataclasses import replace

import numpy as np

from irtiming.measurement import analyse
from irtiming.twin import rig as twin
from irtiming.twin.scene import microbolometer_scene, with_wheel_speed
from irtiming.twin.taps import Taps


def test_columns_that_are_read_later_are_found_with_their_size():
    """Oracle: the twin, which shows odd columns at another moment; and every other column as it was."""
    later_s = 60e-6
    scene = with_wheel_speed(microbolometer_scene(72, 96), 3.0, samples=400)
    scene = replace(
        scene,
        optics=replace(scene.optics, wheel_centre_row_px=scene.optics.wheel_centre_row_px + 3),
        taps=Taps(odd_columns_later_s=later_s),
    )
    drawn = twin.draw(scene, seed=22)
    maps = analyse([twin.simulate(drawn.scene, seed=22)], drawn.measured, extras=("maps",)).maps
    assert maps is not None
    found = {one.name: one for one in maps.patterns}["odd columns"]
    assert abs(found.later_s - later_s) < 4 * found.u_later_s
    assert "taps-apart" in {one.code for one in maps.findings}
    assert "row-clock-not-even" not in {one.code for one in maps.findings}
    columns = maps.columns
    odd = columns.line_px % 2 == 1
    weight = 1 / columns.u_delay_s**2
    apart = np.average(columns.deviation_s[odd], weights=weight[odd]) - np.average(
        columns.deviation_s[~odd], weights=weight[~odd]
    )
    assert abs(apart - later_s) < 5 * found.u_later_s


def test_taps_are_times_of_rows_and_columns():
    """Oracle: the definition, by hand."""
    taps = Taps(odd_columns_later_s=1.0, right_half_later_s=10.0, middle_rows_later_s=3.0)
    np.testing.assert_array_equal(taps.columns_later_s(4), [0, 1, 10, 11])
    np.testing.assert_allclose(taps.rows_later_s(5), [0, 2.25, 3, 2.25, 0])
