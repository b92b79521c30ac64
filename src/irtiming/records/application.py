"""What a result is applied to, and to whom it is handed over."""

from typing import Literal

StampKind = Literal["trigger", "camera", "arrival"]
"""What a stamp of a frame is: its trigger edge, a stamp of the camera, or the arrival at a computer."""

Program = Literal["kalibr", "openvins", "vins", "gyroflow", "opendronemap", "android", "opencv", "ros2"]
"""Whose words a result can be said in."""
