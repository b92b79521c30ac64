"""What a result is applied to, and to whom it is handed over."""

from collections.abc import Mapping
from typing import Literal

from irtiming.records.frame_events import FrameEvent

StampKind = Literal["trigger", "strobe", "camera", "arrival"]
"""What a stamp of a frame is: its trigger edge, the edge of its strobe, a stamp of the camera, or the arrival at a computer."""

KIND_OF: Mapping[FrameEvent, StampKind] = {
    "trigger": "trigger", "strobe": "strobe", "stamp": "camera", "arrival": "arrival",
}  # fmt: skip
"""The stamps that are the event from which a result counts."""

Program = Literal[
    "kalibr", "openvins", "vins", "basalt", "orbslam3", "gyroflow", "opendronemap", "metashape", "android", "opencv", "ros2"
]  # fmt: skip
"""Whose words a result can be said in."""
