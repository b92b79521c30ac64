"""Laboratories at random: what is drawn, and what their owners know of it."""

import json
from dataclasses import fields, replace
from pathlib import Path

import numpy as np
import pytest

from irtiming.archive.rig_file import read_rig
from irtiming.records.rig import Measured
from irtiming.session.simulation import CameraOrder, SimulationOrder, simulate
from irtiming.twin import rig as twin
from irtiming.twin.defects import Defects, defects_of
from irtiming.twin.laboratory import Knowledge, draw_defects, in_laboratory, known
from irtiming.twin.random_laboratory import Wanted, alone, draw, groups, recordings
from irtiming.twin.scene import microbolometer_scene, paper_scene

_SMALL = {"rows": 60, "columns": 80, "frames": 40}


def _pull(stated: Measured | None, truth: float) -> float:
    assert stated is not None
    return (stated.value - truth) / stated.standard_uncertainty


def test_what_is_stated_is_off_by_what_is_stated_with_it() -> None:
    """Oracle: over 300 rigs, (stated - true) / u has mean 0 and spread 1, for each number that rig.toml holds."""
    pulls = []
    scene = paper_scene(64, 80)
    for seed in range(300):
        rig = in_laboratory(twin.draw(scene, seed=seed), seed=seed)
        beams, trigger, timing = rig.scene.beams, rig.scene.trigger, rig.scene.timing
        stated = rig.measured
        assert stated.latency is not None
        assert stated.clock is not None
        assert stated.camera.integration_time_u_s is not None
        pulls.append([
            _pull(stated.latency.application_gate_s, beams.late_application_gate_s),
            _pull(stated.latency.control_gate_s, beams.late_control_gate_s),
            _pull(stated.latency.trigger_s, trigger.late_trigger_s),
            _pull(stated.clock.relative_error, trigger.clock_relative_error),
            _pull(stated.light_gates.lateral_offset_m, beams.lateral_offset_m),
            timing.count_time_error_s / stated.camera.integration_time_u_s,
        ])  # fmt: skip
    table = np.array(pulls)
    assert np.abs(table.mean(axis=0)).max() < 4 / np.sqrt(300)
    assert table.std(axis=0) == pytest.approx(1, abs=0.17)
    assert np.abs(np.corrcoef(table.T) - np.eye(6)).max() < 0.25


def test_defects_have_their_usual_sizes() -> None:
    """Oracle: the sizes to expect in a laboratory; half of the cameras filter, or remember."""
    photon = [draw_defects(paper_scene(64, 80), seed=seed) for seed in range(200)]
    lagging = [draw_defects(microbolometer_scene(64, 80), seed=seed) for seed in range(200)]
    for one in photon + lagging:
        assert 1e-6 <= one.late_application_gate_s <= 20e-6
        assert abs(one.clock_relative_error) <= 50e-6
        assert 0.05e-3 <= abs(one.lateral_offset_m) <= 0.2e-3
        assert np.hypot(one.tilt_about_row_rad, one.tilt_about_column_rad) <= np.radians(1.5)
        assert 0.5 <= min(one.blur_rows_px, one.blur_columns_px) <= max(one.blur_rows_px, one.blur_columns_px) <= 1
        assert 0.01 <= one.glare_share <= 0.03
        assert 0.003 <= abs(one.blade_share) <= 0.015
    assert abs(np.mean([one.blur_turn_rad for one in photon + lagging])) < np.radians(8)
    assert 0.4 < np.mean([one.blur_growth for one in photon + lagging]) < 0.6
    assert max(abs(one.blur_turn_rad) for one in photon) == pytest.approx(np.radians(90), rel=0.05)
    assert 0.35 < np.mean([one.memory_share > 0 for one in photon]) < 0.65
    assert 0.35 < np.mean([one.filter_share > 0 for one in lagging]) < 0.65
    assert all(one.filter_share == 0 for one in photon)
    assert not any(one.has_window for one in lagging)


def test_what_is_asked_for_is_not_drawn() -> None:
    """Oracle: the asked numbers in the scene, the others as without asking."""
    rig = twin.draw(microbolometer_scene(64, 80), seed=3)
    drawn = defects_of(in_laboratory(rig, seed=3).scene)
    asked = defects_of(in_laboratory(rig, seed=3, asked={"filter_share": 0.42}).scene)
    assert asked == replace(drawn, filter_share=0.42)


def test_an_owner_may_know_nothing() -> None:
    """Oracle: None where nothing is stated; the scene is the same."""
    knowledge = Knowledge(u_latency_s=None, u_clock=None, u_lateral_offset_m=None)
    rig = twin.draw(paper_scene(64, 80), seed=1)
    measured = known(rig, seed=1, knowledge=knowledge).measured
    assert measured.latency is None
    assert measured.clock is None
    assert measured.light_gates.lateral_offset_m is None
    assert measured.camera.integration_time_u_s is None


@pytest.mark.parametrize("camera", ["photon", "microbolometer"])
def test_a_defect_comes_alone(camera: str) -> None:
    """Oracle: fields of the other groups are as in a scene without defects; each group of the camera has some of its own."""
    kind = Wanted(camera=camera, **_SMALL)
    none = defects_of(draw(replace(kind, only="none"), seed=1).scene)
    for group in groups(camera):
        found = defects_of(draw(replace(kind, only=group), seed=1).scene)
        moved = {field.name for field in fields(Defects) if getattr(found, field.name) != getattr(none, field.name)}
        wanted = alone(draw_defects(draw(kind, seed=1).scene, seed=1, always=True), group)
        assert moved <= {
            field.name for field in fields(Defects) if getattr(wanted, field.name) != getattr(Defects(), field.name)
        }
        assert bool(moved) == (group not in ("none", "shutter")), group


def test_a_pincushion_is_the_same_laboratory_with_the_other_distortion() -> None:
    """Oracle: every other defect is equal; r_d = r_u (1 + k r_u^2) shows corners further out where k > 0."""
    kind = Wanted(camera="microbolometer", **_SMALL)
    barrel, pincushion = (defects_of(draw(replace(kind, lens=lens), seed=1).scene) for lens in ("barrel", "pincushion"))
    assert barrel.distortion < 0
    assert pincushion == replace(barrel, distortion=-barrel.distortion)


def test_a_laboratory_is_recorded_at_each_speed() -> None:
    """Oracle: names, rates and frames; the same seed gives the same frames, another seed others."""
    kind = Wanted(camera="microbolometer", wheel_hz=(3.0, 5.0), **_SMALL)
    first, again, other = (list(recordings(draw(kind, seed=seed), kind, seed=seed)) for seed in (1, 1, 2))
    assert [one.rotation_speed_hz for one in first] == pytest.approx([3, 5], rel=1e-4)
    assert first[0].frames.shape == (40, 60, 80)
    assert np.array_equal(first[1].frames.pick([5]), again[1].frames.pick([5]))
    assert not np.array_equal(first[1].frames.pick([5]), other[1].frames.pick([5]))
    assert not np.array_equal(first[0].control_slot_ticks[:50], first[1].control_slot_ticks[:50])


def test_a_simulated_laboratory_says_everything_in_its_truth(tmp_path: Path) -> None:
    """Oracle: rig.toml read back; truth.json against the record's fields; without the option there is no new section."""
    order = SimulationOrder(
        folder=tmp_path / "lab", camera=CameraOrder(rows=60, columns=80), frames=20, seed=4, laboratory=True
    )
    made = simulate(order)
    rig, truth = read_rig(made.rig), json.loads(made.truth.read_text())
    assert rig.latency is not None
    assert rig.clock is not None
    assert rig.light_gates.lateral_offset_m is not None
    assert rig.camera.integration_time_u_s is not None
    assert {field.name for field in fields(Defects)} <= set(truth)
    assert truth["late_application_gate_s"] == pytest.approx(rig.latency.application_gate_s.value, abs=2e-6)
    plain = simulate(replace(order, folder=tmp_path / "plain", laboratory=False))
    assert "[latency]" not in plain.rig.read_text()
    assert "lateral" not in plain.rig.read_text()
