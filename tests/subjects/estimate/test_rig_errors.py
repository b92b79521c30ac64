"""Latencies, clock and what rig.toml leaves out: effects by hand and by brute force, pulls of joint fits, findings."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from irtiming.estimate import joint, rig_errors, shared_numbers, timing
from irtiming.physics import latency
from irtiming.physics.light_gates import gate_angles
from irtiming.physics.wheel import wheel_model
from irtiming.records.estimate import EDGE_DELAYS, EdgeDelayFit, Estimate
from irtiming.records.rig import CameraOptics, Clock, Latency, LightGates, MaskOpening, Measured, Rig, WindowTail
from irtiming.records.wheel_geometry import WheelGeometry

TURN = 2 * np.pi
U_GATE, U_SLOT, U_TRIGGER, U_CLOCK = 3e-6, 2e-6, 1.5e-6, 29e-6
U_MASK, NOISE_S, TRUE_S, SEPARATION = 5e-4, 0.3e-6, 4.7e-4, 0.5697
BEAMS = LightGates(
    half_separation_m=Measured(13e-3, 5e-5),
    height_difference_m=Measured(5.5e-3, 5e-5),
    whole_slots_between=9,
    lateral_offset_m=Measured(0.0, 6e-5),
)
RIG = Rig(
    light_gates=BEAMS,
    mask_opening=MaskOpening(opening_angle_rad=Measured(1.3), centre_angle_rad=Measured(-np.pi / 2, U_MASK)),
    latency=Latency(
        application_gate_s=Measured(4e-6, U_GATE),
        control_gate_s=Measured(2e-6, U_SLOT),
        trigger_s=Measured(1e-6, U_TRIGGER),
    ),
    clock=Clock(relative_error=Measured(0.0, U_CLOCK)),
)


def _geometry():
    gates = gate_angles(SEPARATION, BEAMS)
    model = wheel_model(
        (0.0, 1.57, 3.15, 4.71), gates.application_rad, opening_angle_rad=1.3, centre_angle_rad=-np.pi / 2
    )
    return WheelGeometry(
        model=model, gates=gates, angle_budget=(("mask centre angle phi_M", "B", U_MASK),), u_edge_rad=1e-6,
        edges_from="rig.toml", camera_roll_rad=None, findings=(),
    )  # fmt: skip


def _recordings(rates_hz, *, register_hz=None, late_s=0.0):
    """Of one slot table; the application gate is ``late_s`` later than the control gate."""
    register = None if register_hz is None else TURN * register_hz
    return [
        SimpleNamespace(
            track=SimpleNamespace(
                angular_frequency_rad_per_s=TURN * hz, register_rad_per_s=register, slot_deviation_rad=np.zeros(100),
                gate_separation_rad=SEPARATION + TURN * hz * late_s,
            ),
            integration_time_s=0.4e-3, camera_type="photon", events=None,
        )
        for hz in rates_hz
    ]  # fmt: skip


def _fits(delays_s, rates_hz, *, set_s=None):
    """Recordings whose four edges see one delay each, with white noise of `NOISE_S` of their mean."""
    base = np.random.default_rng(0).normal(0, 1e-3, 600)
    return [
        EdgeDelayFit(
            name=f"run {k}", trigger_delay_time_set_s=0.0 if set_s is None else set_s[k],
            angular_frequency_rad_per_s=TURN * hz,
            estimate=Estimate(
                names=(*EDGE_DELAYS, "opening_angle"), units=("s",) * 4 + ("rad",), values=np.array([delay] * 4 + [1.3]),
                covariance=np.diag([4 * NOISE_S**2] * 4 + [1e-8]),
            ),
            edge_delay_s=np.full(4, delay), start_delay_s=0.0, wheel_angle_rad=TURN * (np.arange(600) + 0.5) / 600,
            fraction=np.zeros(600), residual=base * (-1) ** k, degrees_of_freedom=588, step=1.0, noise=1e-3,
            variance_inflation=1.0, n_dropped=0, kept=np.ones(600, bool),
        )
        for k, (delay, hz) in enumerate(zip(delays_s, rates_hz, strict=True))
    ]  # fmt: skip


def _found(fits, recordings, rig=RIG):
    geometry = _geometry()
    errors = rig_errors.of(recordings, fits, rig=rig, geometry=geometry)
    own = [shared_numbers.same("opening_angle", fits, unit="rad", start=1.3)]
    models = [joint.parabola(fit.estimate) for fit in fits]
    return timing.of_pixel_fits(fits, geometry, models=models, own=own, stated_s=None, rig=errors)


def _drawn(random, rates_hz, *, register_hz=None):
    """Delays that recordings show: latencies in the timestamps, gates and mask off, a clock that is off, noise.

    By geometry, not by derivatives: the gates' angle of the distance that the timestamps show.
    """
    late_a, late_c, late_t = random.normal(0, (U_GATE, U_SLOT, U_TRIGGER))
    clock, mask = random.normal(0, (U_CLOCK, U_MASK))
    omegas = TURN * np.array(rates_hz)
    register = omegas if register_hz is None else np.full(omegas.size, TURN * register_hz)
    seen = SEPARATION + register * (late_a - late_c)
    turned = gate_angles(float(seen.mean()), BEAMS).application_rad - gate_angles(SEPARATION, BEAMS).application_rad
    lag = late_c + register / omegas * (late_a - late_c)
    delays = TRUE_S + late_t + lag - (turned + mask) / omegas
    return delays * (1 + clock) + random.normal(0, NOISE_S, omegas.size)


@pytest.mark.parametrize(
    ("rates_hz", "register_hz"), [((3.0,), None), ((3.0, 8.0), 5.0), ((3.0, 5.0, 8.0, 12.0), None)]
)
def test_pulls_of_delays_with_drawn_latencies(rates_hz, register_hz):
    """Oracle: 200 draws of everything that rig.toml states; pulls have mean 0 and rms 1 within three of their own u."""
    random = np.random.default_rng(5)
    recordings = _recordings(rates_hz, register_hz=register_hz)
    pulls = []
    for _ in range(200):
        fits = _fits(_drawn(random, rates_hz, register_hz=register_hz), rates_hz)
        found = _found(fits, recordings).result.estimate
        name = "exposure_midpoint_delay"
        pulls.append((found.value(name) - TRUE_S) / found.u(name))
    assert abs(np.mean(pulls)) < 3 / np.sqrt(200)
    assert np.sqrt(np.mean(np.square(pulls))) == pytest.approx(1.0, abs=3 / np.sqrt(400))


def test_one_speed_by_hand():
    """Oracle: by hand; the mask's angle over omega, half of each gate, all of the trigger path, the clock's share, noise."""
    omega, s = TURN * 3, gate_angles(SEPARATION, BEAMS).sensitivity[0]
    found = _found(_fits([TRUE_S], (3.0,)), _recordings((3.0,))).result
    lines = {line.source: line for line in found.budget}
    expected = {
        "mask centre angle phi_M": U_MASK / omega,
        "latency of the application gate": (1 - s) * U_GATE,
        "latency of the control gate": s * U_SLOT,
        "latency of the trigger path": U_TRIGGER,
        "clock of the trigger generator": TRUE_S * U_CLOCK,
        "noise of the frames": NOISE_S,
    }
    name = "exposure_midpoint_delay"
    for source, size in expected.items():
        assert lines[source].standard_uncertainty[name] == pytest.approx(size, rel=1e-3), source
    assert {line.kind for source, line in lines.items() if source.startswith(("latency", "clock"))} == {"B"}
    assert lines["latency of the trigger path"].measured == (U_TRIGGER, "s")
    total = np.sqrt(sum(line.standard_uncertainty[name] ** 2 for line in found.budget))
    assert total == pytest.approx(found.estimate.u(name), rel=1e-6)


def test_what_both_gates_have_in_common_is_in_the_delay_whole():
    """Oracle: by hand; L_a = k and L_c = k - d, so the delay's error k - s d, of which each gate alone would know too little."""
    u_known, u_apart, s = 5e-6, 0.5e-6, gate_angles(SEPARATION, BEAMS).sensitivity[0]
    late = Latency(
        application_gate_s=Measured(0.0, u_known), control_gate_s=Measured(0.0, np.hypot(u_known, u_apart)),
        gates_common_u_s=u_known,
    )  # fmt: skip
    found = _found(_fits([TRUE_S], (3.0,)), _recordings((3.0,)), rig=replace(RIG, latency=late)).result
    lines = {line.source: line.standard_uncertainty["exposure_midpoint_delay"] for line in found.budget}
    assert lines["latency of both light gates"] == pytest.approx(u_known, rel=1e-6)
    assert lines["latency of the control gate"] == pytest.approx(s * u_apart, rel=1e-6)
    assert "latency of the application gate" not in lines


def test_relative_delays_hold_the_clock_in_si_seconds_only():
    """Oracle: by hand; 100 ms times 29e-6 are 2.9 us, and a generator that is 1e-4 fast makes 100 ms to 99.990 ms."""
    rig = replace(RIG, clock=Clock(relative_error=Measured(1e-4, 29e-6)))
    fits = _fits([TRUE_S, TRUE_S + 2e-6], (3.0, 3.0), set_s=[0.0, 0.1])
    first, second = _found(fits, _recordings((3.0, 3.0)), rig=rig).result.relative_delays
    assert second.nominal_s == 0.1
    assert second.value_s == pytest.approx(0.1 / 1.0001 + 2e-6, abs=1e-12)
    assert second.standard_uncertainty_s == pytest.approx(np.hypot(np.sqrt(2) * NOISE_S, 2.9e-6), rel=1e-3)
    assert second.deviation_s == pytest.approx(2e-6 * 1.0001, rel=1e-6)
    assert second.u_deviation_s == pytest.approx(np.sqrt(2) * NOISE_S, rel=1e-3)
    assert first.standard_uncertainty_s == pytest.approx(0.0, abs=1e-12)


def test_without_a_section_a_crystal_is_in_the_budget():
    """Oracle: 50 ppm, rectangular: 50e-6 / sqrt(3)."""
    errors = rig_errors.of(
        _recordings((3.0,)), _fits([TRUE_S], (3.0,)), rig=replace(RIG, clock=None), geometry=_geometry()
    )
    assert errors.clock == latency.USUAL_CLOCK
    (clock,) = [one for one in errors.shared if one.name == "clock_error"]
    assert clock.u == pytest.approx(50e-6 / np.sqrt(3))
    assert clock.effects[0]["edge_delay_0"] == pytest.approx(TRUE_S)


@pytest.mark.parametrize(
    ("change", "rates_hz", "codes", "not_held"),
    [
        ({}, (3.0,), [], ()),
        ({"latency": None}, (3.0,), ["latency-not-stated"], ("latency of application gate, control gate and trigger path",)),
        ({"latency": Latency(control_gate_s=Measured(1e-6, 1e-7), trigger_s=Measured(0.0, 1e-7))}, (3.0,),
         ["latency-not-stated"], ("latency of application gate",)),
        ({"latency": replace(RIG.latency, trigger_s=Measured(1e-6))}, (3.0,), ["latency-without-uncertainty"], ()),
        ({"clock": None}, (3.0,), ["clock-not-stated"], ()),
        ({"clock": Clock(relative_error=Measured(1e-5))}, (3.0,), ["clock-without-uncertainty"], ()),
        ({"light_gates": replace(BEAMS, lateral_offset_m=None)}, (3.0,), ["lateral-offset-not-stated"],
         ("lateral offset of the beams",)),
        ({"light_gates": replace(BEAMS, lateral_offset_m=None)}, (3.0, 8.0), ["lateral-offset-not-stated"], ()),
        ({"light_gates": replace(BEAMS, lateral_offset_m=Measured(1e-4))}, (3.0,), ["lateral-offset-without-uncertainty"], ()),
    ],
)  # fmt: skip
def test_what_rig_toml_leaves_out_is_said(change, rates_hz, codes, not_held):
    """Oracle: the rule; what is in no uncertainty is a doubt and is named beside the result."""
    fits = _fits([TRUE_S] * len(rates_hz), rates_hz)
    found = rig_errors.of(_recordings(rates_hz), fits, rig=replace(RIG, **change), geometry=_geometry())
    assert [one.code for one in found.findings] == codes
    assert found.not_held == not_held
    assert all((one.severity == "doubt") == bool(not_held) for one in found.findings)
    assert _found(fits, _recordings(rates_hz), rig=replace(RIG, **change)).result.not_in_uncertainty == not_held


@pytest.mark.parametrize(
    ("late_s", "stated", "gate"),
    [
        (13e-6, None, "application gate"), (-5e-6, None, "control gate"), (13e-6, RIG.latency, None),
        (15e-6, RIG.latency, "application gate"),
    ],
)  # fmt: skip
def test_gates_that_are_late_apart_show_at_several_speeds(late_s, stated, gate):
    """Oracle: by hand; dbeta + omega (L_a - L_c): its slope, against 4 times the 3.6 us that both gates are known to.

    Recordings of one speed, of gates that share a distance, and of unlike slot tables say nothing of it.
    """
    rig, rates_hz = replace(RIG, latency=stated), (3.0, 5.0, 8.0)
    fits = _fits([TRUE_S] * 3, rates_hz)
    found = rig_errors.of(_recordings(rates_hz, late_s=late_s), fits, rig=rig, geometry=_geometry()).findings
    texts = [one.what for one in found if one.code == "gates-late-apart"]
    assert len(texts) == (gate is not None)
    assert all(f"edges of the {gate} are {1e6 * abs(late_s):.2g} µs later" in text for text in texts)
    one = rig_errors.of(_recordings((3.0,), late_s=late_s), fits[:1], rig=rig, geometry=_geometry()).findings
    common = _recordings(rates_hz, late_s=late_s, register_hz=5.0)
    pooled = rig_errors.of(common, fits, rig=rig, geometry=_geometry()).findings
    unlike = _recordings(rates_hz, late_s=late_s)
    unlike[1].track.slot_deviation_rad = unlike[1].track.slot_deviation_rad + 1e-6
    tables = rig_errors.of(unlike, fits, rig=rig, geometry=_geometry()).findings
    assert "gates-late-apart" not in [each.code for each in (*one, *pooled, *tables)]


@pytest.mark.parametrize(
    ("slots", "between", "other"), [(9.004, 9, "8"), (8.995, 8, "9"), (9.02, 9, None), (8.98, 8, None)]
)
def test_beams_a_whole_number_of_slots_apart_need_a_ruler(slots, between, other):
    """Oracle: by hand; within a hundredth of a slot of nine, which of two numbers was counted is doubted; a ruler tells."""
    beams = replace(BEAMS, whole_slots_between=between)
    recordings = _recordings((3.0,))
    recordings[0].track.gate_separation_rad = slots * TURN / 100
    found, ruled = (
        rig_errors.of(
            recordings, _fits([TRUE_S], (3.0,)), rig=replace(RIG, light_gates=one), geometry=_geometry()
        ).findings
        for one in (beams, replace(beams, height_m=0.047))
    )
    texts = [one.what for one in found if one.code == "gates-near-whole-slots"]
    assert len(texts) == (other is not None)
    assert all(f"so near to a whole number that {other} may be right" in text for text in texts)
    assert "gates-near-whole-slots" not in [one.code for one in ruled]


def test_the_uncertainty_of_the_integration_time_goes_with_the_rig():
    """Oracle: the record."""
    rig = replace(RIG, camera=CameraOptics(integration_time_u_s=1e-6))
    assert rig_errors.of(_recordings((3.0,)), _fits([TRUE_S], (3.0,)), rig=rig, geometry=_geometry()).u_window_s == 1e-6


def _of_window(camera, *, window_s=0.4e-3):
    recordings = _recordings((3.0,))
    for one in recordings:
        one.integration_time_s = window_s
    rig = replace(RIG, camera=camera)
    return rig_errors.of(recordings, _fits([TRUE_S], (3.0,)), rig=rig, geometry=_geometry())


def test_who_vouches_for_the_length_of_a_window_gets_a_usual_tail():
    """Oracle: the rule: +-4 %, rectangular, over 0.2 ms; it is said, but where the start counts on a length taken on trust."""
    vouched, trusted, by_frames, vouched_by_frames = (
        _of_window(CameraOptics(integration_time_u_s=u_s), window_s=window_s)
        for u_s, window_s in ((1e-6, 0.4e-3), (None, 0.4e-3), (None, None), (1e-6, None))
    )
    for one in (vouched, trusted, by_frames, vouched_by_frames):
        assert one.window_tail.share.standard_uncertainty == pytest.approx(0.04 / np.sqrt(3))
        assert one.window_tail.time_constant_s == 0.2e-3
        assert one.is_window_on_trust == (one is trusted)
        assert [found.code for found in one.findings] == ([] if one is trusted else ["window-tail-not-stated"])


def test_a_tail_that_is_stated_stands():
    """Oracle: the record."""
    tail = WindowTail(share=Measured(0.02, 0.004), time_constant_s=0.1e-3)
    found = _of_window(CameraOptics(integration_time_u_s=1e-6, window_tail=tail))
    assert found.window_tail == tail
    assert found.findings == ()
