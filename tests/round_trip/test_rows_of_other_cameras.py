"""From a simulated rolling photon camera, or a snapshot camera with lag, to the fits of its rows."""

from dataclasses import replace

import numpy as np
import pytest

from irtiming.estimate import rolling_camera
from irtiming.records.choices import Choices
from irtiming.reduce import recipes
from irtiming.twin import rig as twin
from irtiming.twin.scene import BolometerTiming, CameraTiming, microbolometer_scene, paper_scene, with_wheel_speed

WINDOW = with_wheel_speed(paper_scene(60, 80), 3.0, samples=400)
LAG = with_wheel_speed(microbolometer_scene(60, 80), 3.0, samples=400)
SCENES = {
    "rolling, long window": replace(
        WINDOW, timing=CameraTiming(trigger_delay_s=400e-6, integration_time_s=8e-3, row_delay_s=90e-6)
    ),
    "rolling, short window, last row first": replace(
        WINDOW, timing=CameraTiming(trigger_delay_s=6e-3, integration_time_s=200e-6, row_delay_s=-60e-6)
    ),
    "snapshot with lag": replace(LAG, timing=BolometerTiming(time_constant_s=6e-3, row_delay_s=None)),
}


@pytest.mark.parametrize("name", SCENES)
def test_truth_lies_within_the_uncertainty_of_the_fit(name):
    """Oracle: the scene; noise and the sector's shape for row delay and response, beside them angles of the rig for the delay.

    3.5 standard uncertainties; a delay of a window is that of its middle; 1 mrad stands for all angles of the rig.
    """
    rig = twin.draw(SCENES[name], seed=23)
    reduced = recipes.reduce(twin.simulate(rig.scene, seed=4), rig.measured, choices=Choices())
    found = rolling_camera.rows([reduced], rig.measured)
    timing, fit, sector = rig.scene.timing, found.fits[0], found.sectors[0]
    covariance = fit.estimate.covariance + fit.shape_effect @ sector.covariance @ fit.shape_effect.T
    u = dict(zip(fit.estimate.names, np.sqrt(np.diag(covariance)), strict=True))
    window_s = timing.integration_time_s if isinstance(timing, CameraTiming) else 0.0
    truth = {
        "row_delay": timing.row_delay_s, "integration_time": window_s,
        "time_constant": getattr(timing, "time_constant_s", None),
        "recursive_filter": 0.0, "pixel_memory": 0.0, "blade_share": 0.0, "blade_share_beside": 0.0,
    }  # fmt: skip
    for number in fit.estimate.names[4:]:
        assert abs(fit.timing[number] - truth[number]) < 3.5 * u[number], number
    assert ("row_delay" in fit.estimate) == (timing.row_delay_s is not None)
    off = float(fit.edge_delay_s.mean()) - timing.trigger_delay_s - window_s / 2
    assert abs(off) < 3.5 * np.hypot(1e-3 / fit.angular_frequency_rad_per_s, u["edge_delay_0"])
    assert fit.held == ({"integration_time": window_s} if "short" in name else {})
    assert fit.variance_inflation < 4
