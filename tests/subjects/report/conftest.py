"""An analysis made by hand: five nominal delays, two runs each, with numbers that the tests can check on paper."""

import hashlib
from dataclasses import fields, replace

import numpy as np
import pytest

from irtiming.estimate.row_light import SHAPE_NUMBERS
from irtiming.physics.light_gates import gate_angles
from irtiming.physics.wheel import EDGE_SIGNS, exposed_fraction, slope_centres_rad, wheel_model
from irtiming.physics.wheel_harmonics import at_angles
from irtiming.records.analysis import Analysis, Published
from irtiming.records.arrays import Array
from irtiming.records.choices import Choices
from irtiming.records.estimate import EDGE_DELAYS, EdgeDelayFit, Estimate, PublishedFit, SlopeLine
from irtiming.records.exposed import ExposedFraction, ExposedRows
from irtiming.records.finding import Finding
from irtiming.records.lag_estimate import LagTiming, PublishedLagFit
from irtiming.records.reduced import (
    AxleView,
    ContrastImage,
    Histogram,
    Opening,
    PixelSums,
    ReducedRecording,
    RowSums,
    ShutterEvent,
)
from irtiming.records.result import Contribution, JointFit, Profile, RelativeDelay, Result
from irtiming.records.rig import LightGates, MaskOpening, Measured, Rig
from irtiming.records.row_timing import RowTimingFit, SectorFit, SectorShape
from irtiming.records.wheel_geometry import WheelGeometry, WheelModel
from irtiming.records.wheel_track import WheelTrack
from irtiming.report import sheet

TURN = 2 * np.pi
OMEGA = 3 * TURN
CLOCK_HZ = 49_152_000
EDGE_ANGLES = tuple(f"edge_angle_{edge}" for edge in range(4))
GATES = LightGates(half_separation_m=Measured(13e-3), height_difference_m=Measured(5.5e-3), whole_slots_between=9)


def _doubt(what: str, recording: str = "") -> Finding:
    return Finding(code="made-by-hand", severity="warning", what=what, recording=recording)


@pytest.fixture(scope="session")
def analysis() -> Analysis:
    """Trigger delay 400.0 us with u 30 us; relative delays 1, -2, 3, -4 us off, two runs 0.2 us apart, noise 0.3 us."""
    gates = gate_angles(0.5697, GATES)
    model = wheel_model(
        (0.0, 1.5717, 3.1421, 4.7125),
        gates.application_rad,
        opening_angle_rad=np.radians(75),
        centre_angle_rad=-np.pi / 2,
    )
    set_s = np.repeat([0.0, 0.025, 0.05, 0.075, 0.1], 2)
    rng = np.random.default_rng(5)
    names = [f"camera-{1e3 * delay:g}ms-r{k % 2}" for k, delay in enumerate(set_s)]
    geometry = WheelGeometry(
        model=model, gates=gates, angle_budget=(), u_edge_rad=1e-4, edges_from="rig.toml", camera_roll_rad=0.01, findings=()
    )  # fmt: skip
    return Analysis(
        camera_type="photon",
        readout_mode="snapshot",
        rig=Rig(light_gates=GATES, mask_opening=MaskOpening(
            opening_angle_rad=Measured(np.radians(75)), centre_angle_rad=Measured(-np.pi / 2)
        ), source="rig.toml", sha256="e" * 64),
        choices=Choices(),
        recordings=tuple(_recording(name, delay, rng) for name, delay in zip(names, set_s, strict=True)),
        geometry=geometry,
        sectors=(),
        fits=tuple(_edge_fit(name, delay, model, rng) for name, delay in zip(names, set_s, strict=True)),
        joint=_joint(len(names)),
        best=replace(
            _result("pixel-sum", names, set_s),
            findings=(_doubt("3 frames lost", "camera-0ms-r0"), _doubt("<b>not markup</b> & co")),
        ),
        published=Published(
            result=_result("published", names, set_s),
            fits=tuple(_published_fit(set_s[k], names[k : k + 2], model, rng) for k in range(0, 10, 2)),
            geometry=geometry,
        ),
        profiles=tuple(_profile(name, value, 30e-6) for name, value in (
            ("trigger_delay", 400e-6), ("exposure_midpoint_delay", 525e-6)
        )),
    )  # fmt: skip


def _recording(name: str, delay_s: float, rng: np.random.Generator) -> ReducedRecording:
    rows, columns = np.mgrid[0:60, 0:80]
    radius, polar = np.hypot(rows - 45, columns - 40), np.arctan2(rows - 45, columns - 40)
    mask = (radius > 12) & (radius < 38) & (np.abs(polar + np.pi / 2) < np.radians(37.5))
    frame = 4000 + 5000.0 * mask + rng.normal(0, 5, mask.shape)
    edges = np.arange(100 * 40)
    track = WheelTrack(
        edge_ticks=(edges * CLOCK_HZ / 300).astype(np.int64), edge_angle_rad=TURN * edges / 100,
        clock_frequency_hz=CLOCK_HZ, angular_frequency_rad_per_s=OMEGA, gate_separation_rad=0.5697,
        u_gate_separation_rad=1e-5, slot_deviation_rad=rng.normal(0, 3e-4, 100),
        u_slot_deviation_rad=np.full(100, 1e-5),
    )  # fmt: skip
    count, bins = np.histogram(frame[2:40, 5:75], 64)
    bad = np.zeros(mask.shape, bool)
    bad[20, 40] = True
    opening = Opening(
        roi=(2, 40, 5, 75), open_frame_dn=frame, covered_frame_dn=np.full(frame.shape, 4000.0), mask=mask,
        summed=mask, weight=mask.astype(float), border_px=4, bad=bad, blackbody_is_colder=False,
        histogram=Histogram(threshold_dn=6500.0, plate_dn=4000.0, blackbody_dn=9000.0, bin_edges_dn=bins,
                            count=count.astype(np.int64)),
    )  # fmt: skip
    return ReducedRecording(
        name=name, source=f"runs/{name}.nxs", sha256=hashlib.sha256(name.encode()).hexdigest(), n_frames=1000,
        camera_type="photon", readout_mode="snapshot", trigger_ticks=np.arange(1000) * 1_622_016,
        frame_index=np.arange(1000), segment=np.zeros(1000, np.int64),
        pixels=PixelSums(pixel_sum=np.ones(1000), pixel_count=np.ones(1000)),
        samples_per_turn=1000, track=track, equal_track=track, opening=opening,
        axle=AxleView(row_px=45, column_px=40, u_centre_px=0.05, bisector_rad=-np.pi / 2, u_bisector_rad=1e-4,
                      mean_angle_rad=-np.pi / 2, u_off_axle_rad=1e-4),
        integration_time_s=250e-6, trigger_delay_time_set_s=delay_s, rotation_speed_hz=3.0,
    )  # fmt: skip


def _edge_fit(name: str, delay_s: float, model: WheelModel, rng: np.random.Generator) -> EdgeDelayFit:
    angle = np.sort(rng.uniform(0, TURN, 400))
    residual = rng.normal(0, 2e-4, angle.size)
    return EdgeDelayFit(
        name=name, trigger_delay_time_set_s=delay_s, angular_frequency_rad_per_s=OMEGA,
        estimate=Estimate(
            names=(*EDGE_DELAYS, "opening_angle"), units=(*("s",) * 4, "rad"),
            values=np.array([*(525e-6 + np.array([1, -1, 2, -2]) * 1e-6), np.radians(75)]),
            covariance=np.diag([*(4 * (0.3e-6) ** 2,) * 4, 1e-10]),
        ),
        edge_delay_s=400e-6 + np.array([1, -1, 2, -2]) * 1e-6,
        start_delay_s=0.0, wheel_angle_rad=angle, fraction=exposed_fraction(angle, model) + residual, residual=residual,
        degrees_of_freedom=388, noise=2e-4, step=1.0, variance_inflation=1.0, n_dropped=0, kept=np.ones(1000, bool),
    )  # fmt: skip


def _joint(n_fit: int) -> JointFit:
    """Middle at 525 us with u 30 us, 60 us after its start; edges 0.4 mrad early, u 0.1, prior 0.5 mrad, all in common."""
    u = np.array([30e-6, 0, 0, 0, 0, 1e-5, 10e-6, 2e-3, 2e-3])
    covariance = np.diag(u**2)
    covariance[1:5, 1:5] = 1e-8 + 1e-12 * np.eye(4)
    names = ("delay", *EDGE_ANGLES, "opening_angle", "integration_time", "lean_low", "lean_high")
    start = (465e-6, 0, 0, 0, 0, np.radians(75), 300e-6, 1e-3, -1e-3)
    return JointFit(
        parameters=Estimate(
            names=names, units=("s", *("rad",) * 5, "s", "rad", "rad"), covariance=covariance,
            values=np.array([525e-6, 4e-4, 4e-4, 4e-4, 4e-4, np.radians(75.01), 240e-6, 1e-3, -1e-3]),
        ),
        start=dict(zip(names, start, strict=True)),
        prior=Estimate(names=EDGE_ANGLES, units=("rad",) * 4, values=np.zeros(4), covariance=25e-8 + 1e-12 * np.eye(4)),
        reduced_chi_square=0.98, birge=1.23, whiteness=np.append(np.linspace(0.1, 0.9, n_fit - 1), 1e-5), n_steps=4,
        decrement=0.001, u_edge_rad=1e-4,
    )  # fmt: skip


def _profile(name: str, value: float, u: float) -> Profile:
    """A parabola: the deviation is the square of the distance in standard uncertainties."""
    at = np.arange(-2.0, 3.0)
    return Profile(
        name=name, unit="s", value=value, standard_uncertainty=u, values=value + at * u, deviation=at**2, lower=value - u,
        upper=value + u,
    )  # fmt: skip


def _published_fit(delay_s: float, names: list[str], model: WheelModel, rng: np.random.Generator) -> PublishedFit:
    angle = np.linspace(0, TURN, 400, endpoint=False)
    fraction = exposed_fraction(angle + OMEGA * delay_s, model) + rng.normal(0, 1e-3, angle.size)
    lines = []
    for edge, centre in enumerate(slope_centres_rad(model) - OMEGA * delay_s):
        slope = EDGE_SIGNS[edge] / model.opening_angle_rad
        at = np.mod(centre, TURN) + np.linspace(-0.5, 0.5, 60)
        lines.append(
            SlopeLine(
                edge=edge, centre_rad=float(np.mod(centre, TURN)), u_centre_rad=1e-5, slope_per_rad=slope,
                reduced_chi_square=1.0, angle_rad=at,
                fraction=0.5 + slope * (at - np.mod(centre, TURN)) + rng.normal(0, 1e-3, 60),
            )
        )  # fmt: skip
    data = ExposedFraction(
        trigger_delay_time_set_s=delay_s, rotation_speed_hz=3.0, angular_frequency_rad_per_s=OMEGA,
        names=tuple(names), files=tuple(names), wheel_angle_rad=angle,
        fraction=fraction, u_wheel_angle_rad=np.full(400, 1e-5), u_fraction=np.full(400, 7e-4),
        plateaus=((0.4, 0.6, 0), (2.0, 2.2, 1), (3.5, 3.7, 0), (5.1, 5.3, 1)),
    )  # fmt: skip
    return PublishedFit(data=data, lines=tuple(lines), angular_frequency_rad_per_s=OMEGA)


def _result(method: str, names: list[str], set_s: np.ndarray) -> Result:
    shift = np.array([1.0, 1.0, 1.0, 1.0])
    own = np.diag([0.0, 0.0, 4e-6**2, 3e-6**2])
    off = {0.0: 0.0, 0.025: 1e-6, 0.05: -2e-6, 0.075: 3e-6, 0.1: -4e-6}
    relative = []
    for k, (name, delay) in enumerate(zip(names, set_s, strict=True)):
        run = (0.1e-6 if k % 2 else -0.1e-6) if delay and method == "pixel-sum" else 0.0
        u = 0.0 if delay == 0 else 1e-6 if method == "published" else np.sqrt(1.5) * 0.3e-6
        relative.append(
            RelativeDelay(
                file=f"runs/{name}.nxs",
                nominal_s=delay,
                value_s=delay + off[delay] + run,
                standard_uncertainty_s=float(u),
            )
        )
    told = ("trigger_delay", "exposure_midpoint_delay", "trigger_delay_falling", "trigger_delay_rising")
    return Result(
        method=method,
        estimate=Estimate(
            names=told,
            units=("s",) * 4,
            values=np.array([400e-6, 525e-6, 401e-6, 399e-6]),
            covariance=np.outer(shift, shift) * 30e-6**2 + own,
        ),
        relative_delays=tuple(relative),
        budget=(
            Contribution(
                source="mask centre angle phi_M", kind="B", standard_uncertainty=dict.fromkeys(told, 24e-6)
            ),
            Contribution(
                source="noise of the frames", kind="A", standard_uncertainty=dict.fromkeys(told, 18e-6), degrees_of_freedom=400.0
            ),
        ),
        edge_delay_s=400e-6 + np.array([1, -1, 2, -2]) * 1e-6,
        u_edge_delay_s=np.full(4, 0.3e-6),
    )  # fmt: skip


NOTHING = Estimate(names=(), units=(), values=np.zeros(0), covariance=np.zeros((0, 0)))
ROLLING_DELAY_S, TAU_S, ROW_S = 4e-3, 5e-3, 40e-6
ROLLING_NAMES = (*(f"edge_delay_{edge}" for edge in range(4)), "time_constant", "row_delay")
ROW_LATE_US = 100.0
"""By how much the fifth row of the first recording is later than its line."""


@pytest.fixture(scope="session")
def rolling(analysis: Analysis) -> Analysis:
    """Delay 4 ms with u 30 us, tau 5 ms with 4 us, row delay 40 us with 0.2 us; noise alone correlates the first two by 0.96."""
    rng = np.random.default_rng(7)
    names, set_s = ("bolo-0ms", "bolo-10ms"), (0.0, 0.01)
    numbers, u = ("delay", "time_constant", "row_delay"), np.array([30e-6, 4e-6, 0.2e-6])
    return Analysis(
        camera_type="microbolometer",
        readout_mode="rolling",
        rig=analysis.rig,
        choices=Choices(),
        recordings=tuple(_rows(analysis, name, delay) for name, delay in zip(names, set_s, strict=True)),
        geometry=analysis.geometry,
        sectors=(_sector(), _sector()),
        fits=tuple(_row_fit(name, delay, rng) for name, delay in zip(names, set_s, strict=True)),
        joint=JointFit(
            parameters=Estimate(
                names=numbers, units=("s",) * 3, values=np.array([ROLLING_DELAY_S, TAU_S, ROW_S]), covariance=np.diag(u**2)
            ),
            start=dict(zip(numbers, (3.9e-3, 5.1e-3, 41e-6), strict=True)),
            prior=NOTHING,
            reduced_chi_square=1.0, birge=1.0, whiteness=np.array([0.4, 0.02]), n_steps=4, decrement=0.001,
            u_edge_rad=1e-4,
        ),
        best=replace(
            _rolling_result("row-sum", names),
            findings=(_doubt("the shutter is closed in frames 100 to 119", "bolo-0ms"), _doubt("<i>no markup</i>")),
        ),
        published=Published(
            result=_rolling_result("published", names),
            fits=tuple(_published_lag(name, delay, rng) for name, delay in zip(names, set_s, strict=True)),
            geometry=analysis.geometry,
        ),
        profiles=(
            _profile("trigger_delay", ROLLING_DELAY_S, 30e-6),
            _profile("time_constant", TAU_S, 4e-6),
            _profile("row_delay", ROW_S, 0.2e-6),
        ),
    )  # fmt: skip


@pytest.fixture(scope="session")
def rolling_photon(rolling: Analysis) -> Analysis:
    """The same rows through a window of 2 ms: its start is read 3 ms after the edge, its middle 4 ms, u 30 us."""
    names = ("trigger_delay", "exposure_midpoint_delay", "row_delay")
    mix = np.array([[1.0, 0], [1, 0], [0, 1]])
    covariance = mix @ np.diag([30e-6**2, 0.2e-6**2]) @ mix.T
    estimate = Estimate(names=names, units=("s",) * 3, values=np.array([3e-3, 4e-3, ROW_S]), covariance=covariance)
    return _other(rolling, "photon", "rolling", estimate=estimate, local=(*EDGE_DELAYS, "row_delay"))


@pytest.fixture(scope="session")
def snapshot_lag(rolling: Analysis) -> Analysis:
    """The same lag, all rows read at once."""
    local = (*EDGE_DELAYS, "time_constant")
    estimate = rolling.best.estimate.pick("trigger_delay", "time_constant")
    return _other(rolling, "microbolometer", "snapshot", estimate=estimate, local=local)


@pytest.fixture(scope="session", params=["analysis", "rolling", "rolling_photon", "snapshot_lag"])
def any_camera(request: pytest.FixtureRequest) -> Analysis:
    """All four, one after the other."""
    return request.getfixturevalue(request.param)


def _other(rolling: Analysis, camera: str, readout: str, *, estimate: Estimate, local: tuple[str, ...]) -> Analysis:
    """Another response and readout, with what fits, result and profiles of the rolling microbolometer then have."""
    kept = [name for name in ("delay", "time_constant", "row_delay") if name == "delay" or name in local]
    budget = tuple(
        replace(part, standard_uncertainty={name: part.standard_uncertainty.get(name, part.standard_uncertainty["trigger_delay"])
                                            for name in estimate.names})
        for part in rolling.best.budget
    )  # fmt: skip
    return replace(
        rolling,
        camera_type=camera,
        readout_mode=readout,
        recordings=tuple(
            replace(one, camera_type=camera, readout_mode=readout, integration_time_s=2e-3 if camera == "photon" else None)
            for one in rolling.recordings
        ),
        fits=tuple(
            replace(fit, estimate=fit.estimate.pick(*local), start={name: fit.start[name] for name in local})
            for fit in rolling.fits
        ),
        joint=replace(rolling.joint, parameters=rolling.joint.parameters.pick(*kept)),
        best=replace(rolling.best, estimate=estimate, budget=budget),
        published=None,
        profiles=tuple(profile for profile in rolling.profiles if profile.name in estimate),
    )  # fmt: skip


ROW_PX = np.arange(7, 33)


def _row_fit(name: str, delay_s: float, rng: np.random.Generator) -> RowTimingFit:
    angle = rng.permutation(np.linspace(0, TURN, 380, endpoint=False))
    orders = np.arange(0, 16)
    harmonics = np.zeros((ROW_PX.size, 16), complex)
    harmonics[:, 0], harmonics[:, 2], harmonics[:, 6] = 0.5, 0.45, 0.05
    harmonics = harmonics * np.exp(1j * orders * OMEGA * (ROW_PX[:, None] * ROW_S))
    late = np.zeros(ROW_PX.size)
    late[4] = 1e-6 * ROW_LATE_US if delay_s == 0 else 0.0
    model = at_angles(harmonics, angle).T
    seen = at_angles(harmonics * np.exp(1j * orders * OMEGA * late[:, None]), angle).T
    residual = seen - model + rng.normal(0, 1e-3, model.shape)
    covariance = np.diag([0.0, 0, 0, 0, 0, 1e-16])
    covariance[:5, :5] = 24e-12
    covariance[:5, :5] += np.diag([4e-12] * 4 + [1e-12])
    return RowTimingFit(
        name=name, trigger_delay_time_set_s=delay_s, angular_frequency_rad_per_s=OMEGA,
        estimate=Estimate(
            names=ROLLING_NAMES, units=("s",) * 6, covariance=covariance,
            values=np.array([*(ROLLING_DELAY_S + np.array([1, -1, 2, -2]) * 1e-6), TAU_S, ROW_S]),
        ),
        held={}, step_rad=0.622, undone=0.0, blades_apart=False, kept=np.ones(angle.size, bool),
        start=dict(zip(ROLLING_NAMES, (0.0, 0.0, 0.0, 0.0, 3e-3, 60e-6), strict=True)), n_steps=9,
        shape_effect=np.zeros((6, 0)), row_px=ROW_PX,
        wheel_angle_rad=angle, fraction=model + residual, model=model, residual=residual, noise=residual.std(axis=0),
        harmonics=harmonics, gain_dn=-1e4 * np.linspace(1, 2, ROW_PX.size), contrast_dn=np.full(1, -300.0),
        variance_inflation=2.25,
    )  # fmt: skip


def _rows(analysis: Analysis, name: str, delay_s: float) -> ReducedRecording:
    given = analysis.recordings[0]
    mask, kept = given.opening.mask, np.delete(np.arange(400), np.arange(100, 120))
    summed = np.zeros(mask.shape, bool)
    summed[2:40, 5:75] = True
    return ReducedRecording(
        name=name, source=f"runs/{name}.nxs", sha256=hashlib.sha256(name.encode()).hexdigest(), n_frames=400,
        camera_type="microbolometer", readout_mode="rolling", trigger_ticks=kept * 1_622_016, frame_index=kept,
        segment=(kept >= 120).astype(np.int64),
        rows=RowSums(
            row_px=ROW_PX, row_sum_dn=np.zeros((380, ROW_PX.size)), mask_row_sum_dn=np.zeros((380, ROW_PX.size)),
            drift_dn=0.01 * kept, edge_frame_dn=(4000 - 400 * mask).astype(np.uint16), edge_frame=17,
        ),
        samples_per_turn=1000, track=given.track, equal_track=given.track,
        opening=Opening(
            roi=(2, 40, 5, 75), open_frame_dn=4000 - 800.0 * mask, covered_frame_dn=np.full(mask.shape, 4000.0),
            mask=mask, summed=summed, weight=summed.astype(float), border_px=4,
            bad=np.zeros(mask.shape, bool), blackbody_is_colder=True,
        ),
        contrast=ContrastImage(
            projection_dn=np.zeros((38, 70), complex), frame_weight=np.zeros(380, complex), u_dn=1.0,
            good=np.ones((38, 70), bool), roi=(2, 40, 5, 75),
        ),
        shutter_events=(ShutterEvent(first_frame=100, end_frame=120, kind="closed"),),
        trigger_delay_time_set_s=delay_s, rotation_speed_hz=3.0, axle=given.axle,
    )  # fmt: skip


def _sector() -> SectorFit:
    """The numbers and images that the report shows; whatever else the fit tells is the same everywhere."""
    rows, columns = np.mgrid[2:40, 5:75]
    angle = np.mod(np.arctan2(rows - 45.0, columns - 40.0) + np.pi / 2 + np.pi, TURN) - np.pi
    even = np.ones((38, 70))
    shown = {
        "shape": SectorShape(
            axle_row_px=45.0, axle_column_px=40.0, offset_row_px=0.1, offset_column_px=0.0, inner_radius_px=12.0,
            outer_radius_px=38.0, bisector_rad=-np.pi / 2, opening_angle_rad=np.radians(75), blur_px=0.7,
        ),
        "names": SHAPE_NUMBERS, "covariance": np.eye(len(SHAPE_NUMBERS)) * 1e-6,
        "contrast": even, "model_contrast": 0.98 * even, "excess": 0.01 * even,
        "excess_angle_rad": angle, "row_delay_s": ROW_S, "u_row_delay_s": 1e-7, "reduced_chi_square": 2.0,
        "roi": (2, 40, 5, 75),
    }  # fmt: skip
    same = {Array: 0.01 * even, float: 0.01, int: 2}
    return SectorFit(**{field.name: shown.get(field.name, same.get(field.type)) for field in fields(SectorFit)})


def _published_lag(name: str, delay_s: float, rng: np.random.Generator) -> PublishedLagFit:
    angle = np.linspace(0, TURN, 380, endpoint=False)
    rows = np.ones((ROW_PX.size, 380))
    tau = np.linspace(4.5e-3, 5.7e-3, 11)
    parabola = np.array([0.005 + 1e3 * 5.1e-3**2, -2e3 * 5.1e-3, 1e3])
    timing = LagTiming(trigger_delay_s=4.1e-3, row_delay_s=41e-6, time_constant_s=5.1e-3)
    return PublishedLagFit(
        data=ExposedRows(
            trigger_delay_time_set_s=delay_s, rotation_speed_hz=3.0, angular_frequency_rad_per_s=OMEGA,
            names=(name,), files=(name,),
            wheel_angle_rad=angle, fraction=rows[0], u_fraction=None, row_px=ROW_PX, row_fraction=rows,
            u_row_fraction=None, mask=np.ones((60, 80), bool),
        ),
        timing=timing, u_timing=LagTiming(trigger_delay_s=40e-6, row_delay_s=2e-6, time_constant_s=3e-6),
        initial_timing=LagTiming(trigger_delay_s=0.0, row_delay_s=275e-6, time_constant_s=5.6e-3), time_constants_s=tau,
        rms=parabola[0] + parabola[1] * tau + parabola[2] * tau**2, parabola=parabola, row_px=ROW_PX,
        delay_of_row_s=4.1e-3 + 41e-6 * ROW_PX + rng.normal(0, 50e-6, ROW_PX.size), simulated_fraction=rows[0],
        simulated_row_fraction=rows, deviation_rms=0.005, n_simulations=92,
    )  # fmt: skip


def _rolling_result(method: str, names: tuple[str, ...]) -> Result:
    ours = method == "row-sum"
    u = np.array([30e-6, 4e-6, 0.2e-6]) if ours else np.array([40e-6, 3e-6, 2e-6])
    values = np.array([ROLLING_DELAY_S, TAU_S, ROW_S]) if ours else np.array([4.1e-3, 5.1e-3, 41e-6])
    told = ("trigger_delay", "time_constant", "row_delay")
    parts = (
        Contribution(
            source="mask centre angle phi_M", kind="B", standard_uncertainty=dict(zip(told, (24e-6, 0.0, 0.0), strict=True))
        ),
        Contribution(
            source="noise of the frames", kind="A", standard_uncertainty=dict(zip(told, (18e-6, 4e-6, 0.2e-6), strict=True))
        ),
    )  # fmt: skip
    return Result(
        method=method,
        estimate=Estimate(
            names=told,
            units=("s",) * 3,
            values=values,
            covariance=np.diag(u**2),
        ),
        relative_delays=(
            RelativeDelay(file=f"runs/{names[0]}.nxs", nominal_s=0.0, value_s=0.0, standard_uncertainty_s=0.0),
            RelativeDelay(file=f"runs/{names[1]}.nxs", nominal_s=0.01, value_s=0.010001, standard_uncertainty_s=2e-6),
        ),
        budget=parts if ours else parts[1:],
        edge_delay_s=values[0] + np.array([1, -1, 2, -2]) * 1e-6 if ours else np.full(4, np.nan),
        u_edge_delay_s=np.full(4, 5e-6) if ours else np.full(4, np.nan),
    )


@pytest.fixture
def sketched(monkeypatch) -> None:
    """Pages whose figures are made but not turned into SVG, which takes seconds: for tests of what is written around them."""
    monkeypatch.setattr(sheet, "svg", lambda drawn, *, title: f'<svg role="img" aria-label="{title}"></svg>')
