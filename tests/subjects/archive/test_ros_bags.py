"""Bags of ROS 1 and ROS 2, written by rosbags and read as frames."""

import numpy as np
import pytest

from irtiming.archive.captures.camera_frames import CameraFacts, camera_frames
from irtiming.archive.frames.opening import open_frames
from irtiming.errors import ArchiveError

rosbag1 = pytest.importorskip("rosbags.rosbag1", reason="rosbags comes with irtiming[frames]")
from rosbags import rosbag2  # noqa: E402
from rosbags.typesys import Stores, get_typestore  # noqa: E402

SECONDS = 1_700_000_123
FRAMES = np.random.default_rng(4).integers(0, 2**16, (12, 5, 7)).astype(np.uint16)


def _image(store, image, k, *, encoding="16UC1"):
    """Image message k with padded rows, big-endian in every other frame, 33 ms after the one before."""
    kind = store.types["sensor_msgs/msg/Image"]
    stamp = store.types["builtin_interfaces/msg/Time"](sec=SECONDS, nanosec=33_000_001 * k)
    order = ">" if k % 2 else "<"
    rows, columns = image.shape
    padded = np.zeros((rows, columns + 2), image.dtype.newbyteorder(order))
    padded[:, :columns] = image
    named = {"seq": k} if "seq" in store.types["std_msgs/msg/Header"].__dataclass_fields__ else {}
    header = store.types["std_msgs/msg/Header"](stamp=stamp, frame_id="camera", **named)
    return kind(header=header, height=rows, width=columns, encoding=encoding, is_bigendian=k % 2,
                step=padded.strides[0], data=padded.view(np.uint8).reshape(-1))  # fmt: skip


def _bag(folder, version, *, topics=("/camera/image_raw",), encoding="16UC1"):
    if version == 1:
        store, path = get_typestore(Stores.ROS1_NOETIC), folder / "run.bag"
        writer, serialise = rosbag1.Writer(path), store.serialize_ros1
    else:
        store, path = get_typestore(Stores.ROS2_HUMBLE), folder / "run"
        writer, serialise = rosbag2.Writer(path, version=8), store.serialize_cdr
    with writer:
        lines = [writer.add_connection(topic, "sensor_msgs/msg/Image", typestore=store) for topic in topics]
        for k, image in enumerate(FRAMES):
            for line in lines:
                message = serialise(_image(store, image, k, encoding=encoding), "sensor_msgs/msg/Image")
                writer.write(line, SECONDS * 10**9 + 33_000_001 * k + 5_000_000, message)
    return path


@pytest.mark.parametrize("version", [1, 2])
def test_a_bag_is_read_frame_by_frame_with_the_stamps_of_its_headers(version, tmp_path):
    """Oracle: the arrays and stamps that rosbags' own writer was given; bytes of both orders, rows with padding."""
    source = open_frames(_bag(tmp_path, version))
    facts = source.facts
    assert (facts.shape, facts.dtype, facts.time_scale) == ((12, 5, 7), "uint16", "UTC")
    assert facts.more["topic"] == "/camera/image_raw"
    assert np.allclose(facts.times_s - SECONDS, 33_000_001e-9 * np.arange(12), rtol=0, atol=3e-7)
    assert np.array_equal(np.concatenate([block for _, block in source.blocks()]), FRAMES)
    assert np.array_equal(source.pick([7, 2, 11]), FRAMES[[7, 2, 11]])
    path = tmp_path / ("run.bag", "run")[version - 1]
    taken = camera_frames(path,
                          CameraFacts(camera_type="microbolometer", rotation_speed_hz=3.0))  # fmt: skip
    stamps_s = (taken.frame_timestamp_ticks - taken.frame_timestamp_ticks[0]) / taken.timestamp_frequency_hz
    assert np.allclose(stamps_s, 33_000_001e-9 * np.arange(12), rtol=0, atol=5e-7)


def test_a_bag_that_is_not_one_camera_of_grey_images_is_refused(tmp_path):
    """Oracle: hand-made: two topics, three colours, a bag that is cut."""
    for name in "abc":
        (tmp_path / name).mkdir()
    with pytest.raises(ArchiveError, match="holds 2 topics of images"):
        open_frames(_bag(tmp_path / "a", 2, topics=("/left", "/right")))
    with pytest.raises(ArchiveError, match="encoded as rgb8; they must be one of mono8"):
        open_frames(_bag(tmp_path / "b", 1, encoding="rgb8"))
    cut = _bag(tmp_path / "c", 1)
    cut.write_bytes(cut.read_bytes()[:300])
    with pytest.raises(ArchiveError, match="cannot be read as ROS"):
        open_frames(cut)
