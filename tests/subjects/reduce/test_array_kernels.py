"""The loops for frames in a GPU's memory: on a GPU, and with arrays that know the words of the array API standard alone."""

from dataclasses import is_dataclass, replace
from types import SimpleNamespace

import array_api_strict
import numpy as np
import pytest

from irtiming.archive.frame_stack import ArrayFrames
from irtiming.errors import ReductionError
from irtiming.records.choices import Choices
from irtiming.reduce import device_memory, kernels, recipes
from irtiming.twin.rig import draw, simulate
from irtiming.twin.scene import paper_scene, with_wheel_speed


def _frames(shape, seed=0):
    return np.random.default_rng(seed).integers(0, 65536, shape, dtype=np.uint16)


@pytest.fixture(params=["standard", "gpu"])
def there(request):
    """Where frames are that are not in this machine's memory: arrays of the standard, and those of CuPy if it finds a GPU."""
    found = array_api_strict if request.param == "standard" else device_memory.gpu()
    return found or pytest.skip("no GPU here")


@pytest.mark.parametrize("shape", [(7, 12, 16), (1, 1, 1), (5, 13, 1), (11, 31, 37)])
def test_counts_and_sums_are_those_of_the_compiled_loops(shape, there):
    """Oracle: the compiled loops, whose oracle is NumPy; whole numbers exactly, weighted sums to the rounding of float32."""
    frames, rng = _frames(shape) % 900, np.random.default_rng(1)
    given, weights = there.asarray(frames), rng.uniform(0, 2, shape[1:]).astype(np.float32)
    bits = rng.choice(np.array([0, 65535], np.uint16), shape[1:])
    for loop, more in (
        (kernels.count_above, (frames[0],)),
        (kernels.count_at_limits, (450, 3)),
        (kernels.sum_within, (bits,)),
        (kernels.sum_within, (bits[::3], 3)),
    ):
        assert np.array_equal(loop(given, *more), loop(frames, *more))
    for loop in (kernels.weighted_sum, kernels.weighted_row_sum):
        np.testing.assert_allclose(loop(given, weights), loop(frames, weights), rtol=1e-6)
    thin = kernels.weighted_row_sum(frames, weights[::3], 3)
    np.testing.assert_allclose(kernels.weighted_row_sum(given, weights[::3], 3), thin, rtol=1e-6)


def test_repeated_frames_are_found(there):
    """Oracle: by hand; frame 3 is frame 2, frame 0 the one before, and one pixel makes a difference."""
    frames = _frames((6, 9, 11))
    frames[3], frames[5] = frames[2], frames[4]
    frames[5, 8, 10] ^= 1
    given = there.asarray(frames)
    assert kernels.repeats(given, given[0, ...]).tolist() == [True, False, False, True, False, False]


def test_sums_of_waves_are_those_of_the_compiled_loops(there):
    """Oracle: the compiled loops; in double precision, and in single precision for maps."""
    frames, rng = _frames((40, 9, 11)), np.random.default_rng(2)
    given, cosine, sine = there.asarray(frames), rng.normal(size=40), rng.normal(size=40)
    into, into_there = np.zeros((3, 9, 11)), device_memory.zeros((3, 9, 11), "float64", beside=given)
    for _ in range(2):
        kernels.add_projection(frames, cosine, sine, into)
        kernels.add_projection(given, cosine, sine, into_there)
    np.testing.assert_allclose(device_memory.to_host(into_there), into, atol=1e-12 * np.abs(into).max())

    spans = np.array([(0, 3, 9), (4, 0, 11), (8, 10, 11)])
    held, held_there = np.zeros((40, 18), np.uint16), device_memory.zeros((40, 18), "uint16", beside=given)
    kernels.gather(frames, spans, held)
    kernels.gather(given, spans, held_there)
    assert np.array_equal(device_memory.to_host(held_there), held)
    weights, sums = rng.normal(size=(5, 40)).astype(np.float32), np.zeros((5, 18), np.float32)
    sums_there = device_memory.zeros((5, 18), "float32", beside=given)
    kernels.add_waves(held, weights, held[0].astype(np.float32), sums)
    kernels.add_waves(held_there, weights, device_memory.single_precision(held_there[0, :]), sums_there)
    np.testing.assert_allclose(device_memory.to_host(sums_there), sums, atol=1e-6 * np.abs(sums).max())


def _assert_alike(one, other, fields=("frame_index", "segment", "rows", "pixels", "contrast", "waves")):
    """Two reductions, or parts of them, agree: sums to the rounding of float32, whole numbers exactly."""
    for field in fields:
        here, there = getattr(one, field), getattr(other, field)
        assert type(here) is type(there)
        if is_dataclass(here):
            _assert_alike(here, there, here.__dataclass_fields__)
        elif np.asarray(here).dtype.kind in "fc":
            np.testing.assert_allclose(there, here, atol=1e-6 * np.nanmax(np.abs(here), initial=0), err_msg=field)
        else:
            assert np.array_equal(here, there)


@pytest.fixture
def both(monkeypatch, there):
    """Reductions of a recording in either memory."""
    monkeypatch.setattr(device_memory, "gpu", lambda: there)

    def reductions(recording, rig):
        processors = ("cpu", "gpu")
        return [recipes.reduce(recording, rig, choices=Choices(processor=one), maps=True) for one in processors]

    return reductions


def test_a_lagging_camera_with_shutter_events_is_reduced_alike(both, rolled, rig, turning, paper_bolometer):
    """Oracle: the reduction in this machine's memory; a closed shutter and a frozen frame make stretches and hold frames back."""
    frames = paper_bolometer().noisy(turning, seed=1)
    frames[300:306] = 4500
    frames[400] = frames[399]
    here, elsewhere = both(rolled(frames), rig)
    _assert_alike(here, elsewhere)
    assert here.shutter_events
    assert 400 not in here.frame_index


def test_a_photon_camera_with_dead_frames_is_reduced_alike(both):
    """Oracle: the reduction in this machine's memory; one frame is all zeros, pixels are corrected by references."""
    drawn = draw(with_wheel_speed(paper_scene(48, 64), 3.0, samples=300), seed=1)
    recording = simulate(drawn.scene, seed=1)
    frames = np.concatenate([block.copy() for _, block in recording.frames.blocks()])
    frames[120] = 0
    here, elsewhere = both(replace(recording, frames=ArrayFrames(frames, block_frames=50)), drawn.measured)
    _assert_alike(here, elsewhere)
    assert 120 not in here.frame_index


def test_a_gpu_that_is_not_there_is_named(monkeypatch):
    """Oracle: by hand; wanted without CuPy, and with a CuPy that finds no device. Automatic takes this machine's memory then."""
    frames = _frames((2, 3, 4))
    none = SimpleNamespace(cuda=SimpleNamespace(runtime=SimpleNamespace(getDeviceCount=lambda: 0)))
    monkeypatch.setattr(device_memory, "import_module", lambda name: none)
    with pytest.raises(ReductionError, match=r"CuPy finds none here: pip install"):
        device_memory.mover("gpu")
    assert device_memory.mover("automatic")(frames) is frames
    one = SimpleNamespace(cuda=SimpleNamespace(runtime=SimpleNamespace(getDeviceCount=lambda: 1)), asarray=np.negative)
    monkeypatch.setattr(device_memory, "import_module", lambda name: one)
    assert np.array_equal(device_memory.mover("automatic")(frames), np.negative(frames))
    assert device_memory.mover("cpu")(frames) is frames
