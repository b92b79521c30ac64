"""Times of frames and rows: against events that are played through one by one, for random cameras of the four kinds."""

import numpy as np
import pytest
from made_up_result import BOLOMETER, COOLED, made_up_result
from moving_scene import ROWS, FilmedBy, film

from irtiming.apply import camera_timing, frame_times, stamps
from irtiming.apply.camera_timing import Conditions
from irtiming.apply.conditions import require
from irtiming.apply.stamps import EventTimes, Generator, Latency
from irtiming.archive.result_model import DelayScatter
from irtiming.errors import ConditionError, EstimationError

KINDS = [("photon", "snapshot"), ("photon", "rolling"), ("microbolometer", "snapshot"), ("microbolometer", "rolling")]


def _played(truth, trigger_s, row):
    """Events of a row as the camera goes through them, one after the other."""
    now = trigger_s + truth["trigger_delay"]
    for _ in range(row):
        now += truth.get("row_delay", 0.0)
    if "time_constant" in truth:
        return {"reading": now, "effective": now - truth["time_constant"]}
    window = 2 * (truth["exposure_midpoint_delay"] - truth["trigger_delay"])
    return {"start": now, "middle": now + window / 2, "end": now + window, "effective": now + window / 2}


def _drawn(kind, rng):
    """True numbers, their stated covariance, and the numbers that a measurement found."""
    camera, readout = kind
    truth = {"trigger_delay": rng.uniform(2e-4, 6e-3)}
    if camera == "photon":
        truth["exposure_midpoint_delay"] = truth["trigger_delay"] + rng.uniform(5e-5, 4e-3)
    else:
        truth["time_constant"] = rng.uniform(3e-3, 1.5e-2)
    if readout == "rolling":
        truth["row_delay"] = rng.choice([-1, 1]) * rng.uniform(1e-5, 2e-4)
    n = len(truth)
    mixing = rng.normal(size=(n, n)) * np.array([1e-7 if name == "row_delay" else 2e-5 for name in truth])[:, None]
    found = np.array(list(truth.values())) + mixing @ rng.normal(size=n)
    return truth, mixing @ mixing.T, found


def test_times_of_100_random_cameras_miss_by_what_is_stated():
    """Oracle: `_played`; each camera's numbers miss the truth as their covariance says, its clock and its ticks as well."""
    rng, pulls = np.random.default_rng(21), {}
    for camera in range(100):
        kind = KINDS[camera % 4]
        truth, covariance, found = _drawn(kind, rng)
        u = np.sqrt(np.diag(covariance))
        numbers = dict(zip(truth, zip(found, u, strict=True), strict=True))
        timing = camera_timing.of_result(made_up_result(*kind, numbers, matrix=(covariance / np.outer(u, u)).tolist()))
        clock_error = rng.normal(0, 3e-5)
        true_s = 10 + 0.03 * np.arange(5) + rng.uniform(0, 1e-3)
        ticks = np.rint(true_s * 1e5).astype(np.int64)  # a coarse clock, so that its ticks count
        triggers = stamps.from_ticks(ticks, clock_frequency_hz=1e5, generator=Generator(u_relative_error=3e-5))
        times = frame_times.apply(timing, triggers, rows_px=np.array([0.0, 7.0, 119.0]))
        for frame in range(5):
            for place, row in enumerate(times.rows_px):
                played = _played(truth, 0.0, int(row))
                for name, after in played.items():
                    there = true_s[frame] + after * (1 + clock_error)
                    pull = (times.time_s(name)[frame, place] - there) / times.u_s(name)[place]
                    pulls.setdefault(name, []).append(pull)
    everything = np.concatenate([np.array(one) for one in pulls.values()])
    assert set(pulls) == {"start", "middle", "end", "reading", "effective"}
    assert np.sqrt(np.mean(everything**2)) == pytest.approx(1, abs=0.15)
    assert np.mean(np.abs(everything) < 2) > 0.9


def test_a_scatter_from_frame_to_frame_is_each_frames_own():
    """Oracle: by hand; the result's 31 us and the stamp's tick beside 200 us, of which two frames have the first in common."""
    u, scatter_s = 31e-6, 200e-6
    plain = made_up_result("photon", "snapshot", {"trigger_delay": (4e-4, u)})
    scattering = plain.model_copy(
        update={"delay_scatter": DelayScatter(
            standard_deviation=scatter_s, standard_uncertainty=8e-6, upper_limit=2.2e-4, unit="s"
        )}
    )  # fmt: skip
    unsure = plain.model_copy(
        update={
            "delay_scatter": DelayScatter(
                standard_deviation=None, standard_uncertainty=None, upper_limit=9e-6, unit="s"
            )
        }
    )
    events = EventTimes(time_s=np.arange(3.0), u_own_s=2e-5, scale="s")
    times, calm = (frame_times.apply(camera_timing.of_result(one), events) for one in (scattering, unsure))
    name = times.moments[0].name
    assert calm.u_s(name)[0] == pytest.approx((u**2 + 2e-5**2) ** 0.5)
    assert times.u_s(name)[0] == pytest.approx((u**2 + 2e-5**2 + scatter_s**2) ** 0.5)
    assert times.correlation(name)[0] == pytest.approx(u**2 / (u**2 + 2e-5**2 + scatter_s**2))


def test_correlations_are_those_of_errors_that_are_drawn():
    """Oracle: 40 000 cameras drawn from the covariance, and ticks drawn beside them."""
    rng = np.random.default_rng(8)
    covariance = np.array([[9e-10, -3e-11, -2e-12], [-3e-11, 4e-11, 1e-13], [-2e-12, 1e-13, 4e-14]])
    u = np.sqrt(np.diag(covariance))
    names = ("trigger_delay", "time_constant", "row_delay")
    numbers = dict(zip(names, zip((4e-3, 5e-3, 4e-5), u, strict=True), strict=True))
    matrix = (covariance / np.outer(u, u)).tolist()
    timing = camera_timing.of_result(made_up_result("microbolometer", "rolling", numbers, matrix=matrix))
    triggers = EventTimes(time_s=np.arange(3.0), u_own_s=2e-5, u_common_s=1e-5, scale="s")
    times = frame_times.apply(timing, triggers, rows_px=np.array([0.0, 100.0]))
    n = 40_000
    error = rng.multivariate_normal(np.zeros(3), covariance, n)
    own, common = rng.normal(0, 2e-5, (n, 2)), rng.normal(0, 1e-5, n)
    late = [error[:, 0] - error[:, 1] + row * error[:, 2] + common for row in (0, 100)]
    frames = np.corrcoef(late[1] + own[:, 0], late[1] + own[:, 1])[0, 1]
    rows = np.corrcoef(late[0] + own[:, 0], late[1] + own[:, 0])[0, 1]
    assert times.u_s("effective")[1] == pytest.approx(np.std(late[1] + own[:, 0]), rel=0.02)
    assert times.correlation("effective")[1] == pytest.approx(frames, abs=0.01)
    assert times.correlation_of_rows("effective") == pytest.approx([1.0, rows], abs=0.01)


@pytest.mark.parametrize(
    "camera",
    [
        FilmedBy(window_s=4e-3),
        FilmedBy(tau_s=6e-3),
        FilmedBy(tau_s=5e-3, share=0.2),
        FilmedBy(row_delay_s=3e-4, tau_s=4e-3),
    ],
    ids=["photon", "lag", "filter", "rolling"],
)
def test_the_effective_moment_is_when_the_scene_was_like_the_frame(camera):
    """Oracle: films of a scene that changes slowly; the time at which it was what a frame shows, looked up on a fine grid."""
    filmed = film(camera, n_frames=24)
    numbers = {"trigger_delay": (camera.delay_s, 1e-9)}
    if camera.tau_s:
        numbers |= {"time_constant": (camera.tau_s, 1e-9)}
    else:
        numbers |= {"exposure_midpoint_delay": (camera.delay_s + camera.window_s / 2, 1e-9)}
    if camera.row_delay_s:
        numbers |= {"row_delay": (camera.row_delay_s, 1e-9)}
    if camera.share:
        numbers |= {"recursive_filter": (camera.share, 1e-6)}
    kind = ("microbolometer" if camera.tau_s else "photon", "rolling" if camera.row_delay_s else "snapshot")
    timing = camera_timing.of_result(made_up_result(*kind, numbers, rows=ROWS))
    times = frame_times.apply(timing, EventTimes(time_s=filmed.trigger_s, scale="s"))
    row = ROWS - 1 if camera.row_delay_s else 0
    steady = np.abs(np.cos(2 * np.pi * 2 * filmed.trigger_s + 0.4)) > 0.9  # where the sine goes nearly straight
    for frame in np.flatnonzero(steady)[-4:]:
        there = times.time_s("effective")[frame, row]
        grid = there + np.linspace(-0.02, 0.02, 20001)
        matching = grid[np.argmin(np.abs(filmed.warmth(grid) - filmed.frames[frame, row, -1]))]
        shift = abs(there - filmed.trigger_s[frame] - camera.delay_s - camera.row_delay_s * row)
        assert matching == pytest.approx(there, abs=max(0.2 * shift, 3e-5))


def test_the_events_of_a_photon_camera_are_in_order():
    """Oracle: by hand; 400 µs, 525 µs and so 650 µs after the edge, and the uncertainty of 2 m - s."""
    timing = camera_timing.of_result(made_up_result("photon", "snapshot", COOLED, matrix=[[1.0, 0.5], [0.5, 1.0]]))
    times = frame_times.apply(timing, EventTimes(time_s=np.array([1.0, 2.0]), scale="s"))
    assert times.time_s("start")[1, 0] == pytest.approx(2.0004)
    assert times.time_s("end")[0, 0] == pytest.approx(1.00065)
    assert times.u_s("end")[0] == pytest.approx(np.sqrt(4 * 9 + 4 - 4 * 0.5 * 6) * 1e-7)
    with pytest.raises(EstimationError, match="no moment 'reading'; it has start, middle, end, effective"):
        times.time_s("reading")


def test_a_tail_makes_the_middle_later_and_not_the_end():
    """Oracle: by hand; a window of 250 us from 400 us on, whose tail has its middle 8 us later: it ends at 650 us, not at 666."""
    numbers = {
        "trigger_delay": (400e-6, 2e-7),
        "exposure_midpoint_delay": (533e-6, 3e-7),
        "integration_time": (250e-6, 4e-7),
    }
    timing = camera_timing.of_result(made_up_result("photon", "snapshot", numbers))
    times = frame_times.apply(timing, EventTimes(time_s=np.array([1.0]), scale="s"))
    assert times.time_s("end")[0, 0] == pytest.approx(1.00065, abs=1e-9)


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"serial_number": "8"}, "its serial number is 8, the result was measured with 7"),
        ({"rows": 240}, "its image size is 240 x 160"),
        ({"window_s": 3e-4}, "its integration time is 300.000 µs, the result was measured with 250.000 µs"),
        ({"camera": "microbolometer"}, "its detector is microbolometer"),
        ({"readout_mode": "rolling"}, "its readout mode is rolling"),
    ],
)
def test_a_result_for_other_conditions_is_refused(change, said):
    """Oracle: one thing changed; the words that name both."""
    held = camera_timing.of_result(made_up_result("photon", "snapshot", COOLED, window_s=2.5e-4)).conditions
    given = {"camera": "photon", "readout_mode": "snapshot", "window_s": 2.5e-4} | change
    numbers = COOLED | {"time_constant": (1e-3, 1e-6)}
    other = camera_timing.of_result(made_up_result(given.pop("camera"), given.pop("readout_mode"), numbers, **given))
    assert require(held, held, where="run.nxs") == ()
    with pytest.raises(ConditionError) as caught:
        require(held, other.conditions, where="run.nxs")
    assert str(caught.value).startswith("run.nxs: ")
    assert said in str(caught.value)


def test_what_cannot_be_compared_is_said():
    """Oracle: a result that names no camera."""
    held = camera_timing.of_result(
        made_up_result("microbolometer", "rolling", BOLOMETER, serial_number=None)
    ).conditions
    assert require(held, held, where="run.nxs") == ("serial number was not compared",)
    nothing = "detector, readout mode, serial number and image size were not compared"
    assert require(held, Conditions(), where="run.nxs") == (nothing,)


@pytest.mark.parametrize(
    ("numbers", "said"),
    [
        ({"row_delay": (1e-5, 1e-7)}, "no trigger delay that can be applied (it has row_delay)"),
        ({"trigger_delay": (np.nan, 1e-7), "time_constant": (1e-3, 1e-6)}, "does not know trigger_delay"),
        ({"trigger_delay": (1e-3, 1e-7)}, "no trigger delay that can be applied (it has trigger_delay)"),
    ],
)
def test_a_result_without_timing_is_refused(numbers, said):
    """Oracle: the words of each refusal."""
    result = made_up_result("microbolometer", "rolling", {name: (0.0, u) for name, (_, u) in numbers.items()})
    values = {
        name: one.model_copy(update={"value": numbers[name][0] if np.isfinite(numbers[name][0]) else None})
        for name, one in result.parameters.items()
    }
    with pytest.raises(EstimationError) as caught:
        camera_timing.of_result(result.model_copy(update={"parameters": values}))
    assert said in str(caught.value)


@pytest.mark.parametrize("rows", [[-1.0], [120.0], []])
def test_rows_beyond_the_image_are_refused(rows):
    """Oracle: an image of 120 rows."""
    timing = camera_timing.of_result(made_up_result("microbolometer", "rolling", BOLOMETER))
    with pytest.raises(EstimationError, match="rows must be from 0 to 119"):
        frame_times.apply(timing, EventTimes(time_s=np.zeros(1), scale="s"), rows_px=np.array(rows))


def test_a_latency_of_the_trigger_path_cancels_where_the_same_generator_stamps():
    """Oracle: drawn cases; a delay is what was seen from the stamp on, 5 ms sure to 1 us, minus a latency known to 3 us."""
    seen_s, u_seen_s, latency_s, u_latency_s = 5e-3, 1e-6, 2e-5, 3e-6
    numbers = {"trigger_delay": (seen_s - latency_s, np.hypot(u_seen_s, u_latency_s)), "time_constant": (4e-3, 1e-9)}
    timing = camera_timing.of_result(made_up_result("microbolometer", "snapshot", numbers))
    known = Generator(u_relative_error=0.0, way=Latency(value_s=latency_s, u_s=u_latency_s))
    triggers = stamps.from_ticks(np.arange(1, 4) * 10**9, clock_frequency_hz=1e9, generator=known)
    times = frame_times.apply(timing, triggers)
    assert times.time_s("reading")[0, 0] == pytest.approx(1 + seen_s, abs=1e-12)
    assert times.u_s("reading")[0] == pytest.approx(u_seen_s, rel=1e-3)


@pytest.mark.parametrize(
    ("numbers", "said"),
    [
        ({"trigger_delay": (1e300, 1e-6)}, "trigger_delay = 1e+300 ± 1e-06 s, must be within ±60 s"),
        (
            {"trigger_delay": (1e-3, 1e-6), "recursive_filter": (1.0, 1e-3)},
            "recursive_filter = 1 ± 0.001, must be within ±0.9",
        ),
    ],
)
def test_numbers_that_no_camera_has_are_refused(numbers, said):
    """Oracle: the words; what was made of them would be no time."""
    result = made_up_result("microbolometer", "snapshot", {"time_constant": (1e-3, 1e-6)} | numbers)
    with pytest.raises(EstimationError) as caught:
        camera_timing.of_result(result)
    assert said in str(caught.value)


def test_a_giant_image_is_refused():
    """Oracle: the words; its rows would fill any memory."""
    with pytest.raises(EstimationError, match="images of 1000000000000 rows"):
        camera_timing.of_result(made_up_result("microbolometer", "rolling", BOLOMETER, rows=10**12))
