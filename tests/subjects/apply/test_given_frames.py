"""Which frame has which time where a person gives times beside frames: by hand, in files of a few small frames."""

import json

import numpy as np
import pytest
from made_up_result import made_up_result

from irtiming.apply.camera_timing import of_result
from irtiming.errors import EstimationError
from irtiming.session import given_frames

IDS = [*range(5), *range(7, 12)]
"""Numbers of ten frames, of which 5 and 6 were lost."""


@pytest.fixture
def camera():
    """Of a result, to which a microbolometer camera was triggered."""
    numbers = {"trigger_delay": (4e-3, 2e-5), "time_constant": (5e-3, 5e-6), "row_delay": (7e-4, 1e-7)}
    return of_result(made_up_result("microbolometer", "rolling", numbers, rows=4))


@pytest.fixture
def frames(tmp_path):
    """Writer of ten frames with facts beside them."""

    def write(**facts):
        np.save(tmp_path / "film.npy", np.zeros((10, 4, 160), np.uint16))
        (tmp_path / "film.npy.json").write_text(json.dumps(facts))
        return tmp_path / "film.npy"

    return write


def _stamps(tmp_path, numbers, times_ms):
    lines = ["stamp_ms" if numbers is None else "frame,stamp_ms"]
    for k, time in enumerate(times_ms):
        lines.append(f"{time}" if numbers is None else f"{numbers[k]},{time}")
    (tmp_path / "stamps.csv").write_text("\n".join(lines))
    return tmp_path / "stamps.csv"


def test_a_period_goes_from_number_to_number(frames, camera):
    """Oracle: by hand; after the two lost frames three periods have passed."""
    given = given_frames.read(frames(frame_id=IDS), camera, period_s=0.03)
    assert given.numbers.tolist() == IDS
    np.testing.assert_allclose(given.events.time_s, 0.03 * np.array(IDS))
    given = given_frames.read(frames(), camera, period_s=0.03)
    assert given.numbers.tolist() == list(range(10))


def test_stamps_are_those_of_the_same_numbers(frames, camera, tmp_path):
    """Oracle: by hand; twelve triggers, frame k the k-th of them, of which two gave no frame."""
    stamps = _stamps(tmp_path, range(12), 30.0 * np.arange(12) + 1000)
    given = given_frames.read(frames(frame_id=IDS), camera, stamps=stamps)
    np.testing.assert_allclose(given.events.time_s + given.events.origin_s, 1 + 0.03 * np.array(IDS))
    assert given.numbers.tolist() == IDS


def test_frames_without_numbers_have_those_of_their_stamps(frames, camera, tmp_path):
    """Oracle: by hand; one stamp for each frame, in their order."""
    stamps = _stamps(tmp_path, IDS, 30.0 * np.array(IDS))
    given = given_frames.read(frames(), camera, stamps=stamps)
    np.testing.assert_allclose(given.events.time_s, 0.03 * np.array(IDS))
    assert given.numbers.tolist() == IDS


@pytest.mark.parametrize(
    ("facts", "numbers", "times_ms", "said"),
    [
        (
            {"frame_id": IDS},
            [*range(4), *range(8, 14)],
            range(0, 300, 30),
            "no stamp of 2 of 10 frames: of number 4, 7;",
        ),
        ({"frame_id": IDS}, range(1, 13), range(0, 360, 30), "they are 0 to 11 in the frames and 1 to 12 here"),
        ({"frame_id": IDS}, None, range(0, 300, 30), "missing by their own numbers, the first after number 4:"),
        ({"frame_id": IDS}, None, range(0, 360, 30), "has 12 stamps for 10 frames"),
        ({}, range(12), range(0, 360, 30), "has 12 stamps for 10 frames"),
    ],
)
def test_stamps_that_contradict_the_frames_are_refused(frames, camera, tmp_path, facts, numbers, times_ms, said):
    """Oracle: by hand; other numbers, numbers that begin at 1, no time for what is missing, more stamps than frames."""
    stamps = _stamps(tmp_path, numbers, times_ms)
    with pytest.raises(EstimationError, match=said):
        given_frames.read(frames(**facts), camera, stamps=stamps)


def test_stamps_that_leave_time_for_what_is_missing_are_taken(frames, camera, tmp_path):
    """Oracle: by hand; ten stamps in a row, of which two are 90 ms apart where two frames are missing."""
    stamps = _stamps(tmp_path, None, 30.0 * np.array(IDS))
    given = given_frames.read(frames(frame_id=IDS), camera, stamps=stamps)
    np.testing.assert_allclose(given.events.time_s, 0.03 * np.array(IDS))


@pytest.mark.parametrize(
    ("facts", "wanted", "said"),
    [
        (
            {"times_s": [0.02 * k for k in range(10)], "time_scale": "camera clock"},
            {"period_s": 0.03},
            "every 20 ms, and a period of",
        ),
        ({"frame_id": [*range(9), 8]}, {"period_s": 0.03}, "numbers frame 9 no higher than the one before"),
        ({}, {"period_s": 0.03, "stamps": "x.csv"}, "give one of them"),
    ],
)
def test_a_period_that_contradicts_the_file_is_refused(frames, camera, facts, wanted, said):
    """Oracle: by hand; times of its own, numbers that do not rise, stamps as well."""
    with pytest.raises(EstimationError, match=said):
        given_frames.read(frames(**facts), camera, **wanted)


def test_times_that_do_not_rise_are_none(frames, camera):
    """Oracle: by hand; a clock that stood still tells nothing, so that the period counts."""
    path = frames(times_s=[7.0] * 10, time_scale="camera clock")
    given = given_frames.read(path, camera, period_s=0.03)
    np.testing.assert_allclose(given.events.time_s, 0.03 * np.arange(10))
