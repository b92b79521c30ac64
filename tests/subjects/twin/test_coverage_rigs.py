"""Random rigs of the benchmark of coverage: possible cameras of every kind, and errors counted against their truth."""

import argparse
import importlib.util
import sys
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from irtiming.twin import rig as twin
from irtiming.twin.readout import refuse_slow_readout, rows_at_s
from irtiming.twin.scene import CameraTiming

_SPEC = importlib.util.spec_from_file_location(
    "rolling_coverage", Path(__file__).parents[3] / "benchmarks" / "rolling_coverage.py"
)
coverage = importlib.util.module_from_spec(_SPEC)
sys.modules["rolling_coverage"] = coverage
_SPEC.loader.exec_module(coverage)

KINDS = [
    coverage.Kind(camera=camera, readout=readout)
    for camera in ("photon", "microbolometer")
    for readout in ("rolling", "snapshot")
]


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: f"{kind.camera} {kind.readout}")
def test_rigs_are_possible_and_differ(kind):
    """Oracle: no row before its trigger, none after the next; the same seed, the same rig; every variety among 40."""
    scenes = [coverage.draw(kind, seed).scene for seed in range(40)]
    for seed, scene in enumerate(scenes):
        refuse_slow_readout(scene)
        assert scene.timing.trigger_delay_s + rows_at_s(scene).min() >= -1e-12
        assert (scene.timing.row_delay_s is None) == (kind.readout == "snapshot")
        assert isinstance(scene.timing, CameraTiming) == (kind.camera == "photon")
        assert scene == coverage.draw(kind, seed).scene
    assert len({scene.timing for scene in scenes}) == 40
    assert {scene.wheel.rotation for scene in scenes} == {"clockwise", "counterclockwise"}
    if kind.readout == "rolling":
        assert {scene.timing.row_delay_s > 0 for scene in scenes} == {True, False}
    if kind.camera == "photon":
        assert {scene.radiance.reference_frames for scene in scenes} == {0, 50}
        assert not any(scene.correction.events for scene in scenes)


def test_the_mask_is_off_by_what_rig_toml_states():
    """Oracle: (measured - true) / u of 100 rigs: spread 1 within 4 standard errors, mean 0 likewise."""
    rigs = [coverage.draw(KINDS[0], seed) for seed in range(100)]
    told = [rig.measured.mask_opening.centre_angle_rad for rig in rigs]
    pulls = np.array(
        [
            (one.value - rig.scene.mask.centre_angle_rad) / one.standard_uncertainty
            for one, rig in zip(told, rigs, strict=True)
        ]
    )
    assert abs(pulls.mean()) < 0.4
    assert pulls.std() == pytest.approx(1, abs=0.28)


def test_recordings_are_of_one_camera_at_several_speeds(monkeypatch):
    """Oracle: counting: two speeds, two delays each; the camera's own timing is the same in all."""
    scenes = []
    monkeypatch.setattr(coverage.twin, "simulate", lambda scene, *, seed: scenes.append((scene, seed)))
    rig = coverage.draw(KINDS[0], 3)
    list(coverage.recordings(rig.scene, argparse.Namespace(speeds=2, delays_ms="0,25"), 3))
    assert len({seed for _, seed in scenes}) == 4
    assert {scene.timing for scene, _ in scenes} == {rig.scene.timing}
    speeds = [round(scene.trigger.wheel_hz, 6) for scene, _ in scenes]
    assert speeds[0] == speeds[1] == round(rig.scene.trigger.wheel_hz, 6) != speeds[2] == speeds[3]
    assert [scene.trigger.trigger_delay_time_set_s for scene, _ in scenes] == [0, 0.025, 0, 0.025]


@pytest.mark.parametrize("kind", KINDS, ids=lambda kind: f"{kind.camera} {kind.readout}")
def test_errors_are_estimate_minus_truth(monkeypatch, kind):
    """Oracle: estimates that are the truth plus one standard uncertainty; names that the truth does not know are left out."""
    truth = twin.truth(coverage.draw(kind, 1).scene)
    own = "integration_time" if kind.camera == "photon" else "time_constant"
    names = ("trigger_delay", own, "trigger_delay_falling", *(("row_delay",) if kind.readout == "rolling" else ()))
    values = np.array([truth.get(f"{name}_s", 0.0) + 1e-6 for name in names])
    estimate = SimpleNamespace(names=names, values=values, standard_uncertainties=np.full(len(names), 1e-6))
    monkeypatch.setattr(
        coverage,
        "analyse",
        lambda recordings, rig, extras: SimpleNamespace(best=SimpleNamespace(estimate=estimate), published=None),
    )
    options = argparse.Namespace(camera=kind.camera, readout=kind.readout, speeds=1, delays_ms="0")
    seed, found = coverage.one_rig(options, 1)
    assert seed == 1
    assert [name for name, _ in found] == [name for name in names if name != "trigger_delay_falling"]
    for pairs in found.values():
        assert pairs == [(pytest.approx(1e-6), 1e-6)]
    row = coverage.table_row("row_delay", "row sums", [(1e-6, 1e-6), (-3e-6, 1.5e-6), (0.0, 1e-6)])
    assert row == "| row delay, row sums | 1.826 | 3.000 | 1.190 | 1.29 | 33% | 67% |"
