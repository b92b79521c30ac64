"""What noise alone lets all recordings say together."""

from types import SimpleNamespace

import numpy as np
import pytest

from irtiming.records.estimate import EDGE_DELAYS, Estimate
from irtiming.report import camera_noise

MEMORY = "frame_memory"


def _fit(u_edge_s, u_lag_s, *, coupling=0.0, u_memory=0.01):
    """Four edges, a time constant, and what a frame keeps of the one before, which moves the time constant."""
    covariance = np.diag([*[u_edge_s**2] * 4, u_lag_s**2 + coupling**2 * u_memory**2, u_memory**2])
    covariance[4, 5] = covariance[5, 4] = coupling * u_memory**2
    return SimpleNamespace(
        estimate=Estimate(
            names=(*EDGE_DELAYS, "time_constant", MEMORY), units=("s",) * 5 + ("1",),
            values=np.array([4e-3] * 4 + [5e-3, 0.1]), covariance=covariance,
        )
    )  # fmt: skip


def _noise(monkeypatch, *fits):
    monkeypatch.setattr(camera_noise, "camera", lambda *_: SimpleNamespace(memory=SimpleNamespace(PARAMETER=MEMORY)))
    monkeypatch.setattr(camera_noise, "delay_name", lambda _: "trigger_delay")
    return camera_noise.noise(SimpleNamespace(fits=fits, best=None, camera_type="", readout_mode=""))


def test_recordings_are_weighed_by_their_noise(monkeypatch):
    """Oracle: by hand; 4 and 40 us of four edges are 2 and 20 us, together 1.990 us; the mean of both would have 10.05 us."""
    found = _noise(monkeypatch, _fit(4e-6, 30e-6), _fit(40e-6, 40e-6))
    assert found.names == ("trigger_delay", "time_constant")
    assert found.u("trigger_delay") == pytest.approx(1e-6 / np.sqrt(1 / 2**2 + 1 / 20**2))
    assert found.u("time_constant") == pytest.approx(24e-6)
    np.testing.assert_allclose(found.values, [4e-3, 5e-3])


def test_what_a_frame_keeps_is_one_number_in_all_recordings(monkeypatch):
    """Oracle: by hand; one recording knows it ten times better, and so the time constant of the other, too."""
    sure, unsure = _fit(4e-6, 30e-6, coupling=1e-3, u_memory=1e-3), _fit(4e-6, 3e-6, coupling=1e-3, u_memory=1e-1)
    found = _noise(monkeypatch, sure, unsure)
    memory = 1 / (1 / 1e-3**2 + 1 / 1e-1**2)
    lag = 1 / (1 / 30e-6**2 + 1 / 3e-6**2) + (1e-3) ** 2 * memory
    assert found.u("time_constant") == pytest.approx(np.sqrt(lag), rel=1e-6)
    assert found.u("time_constant") < 0.1 * unsure.estimate.u("time_constant")
