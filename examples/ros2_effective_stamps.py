"""ROS 2 node that stamps images with the moment at which the scene was like them.

It takes images with their CameraInfo, adds ``shift_ns`` to both stamps, and publishes them again. ``irtiming apply export RESULT
--to ros2 --out stamps.yaml`` writes its parameters; frames must be stamped with the trigger edge, or its ``--stamp-latency`` must
say by how much later. In a shell where ROS is set up:

    python3 ros2_effective_stamps.py --ros-args --params-file stamps.yaml -r image:=/camera/image_raw -r camera_info:=/camera/info

`effective_stamp` and `row_stamps` need no ROS.
"""

NANOSECONDS = 10**9


def effective_stamp(sec: int, nanosec: int, *, shift_ns: int) -> tuple[int, int]:
    """Seconds and nanoseconds of a ROS stamp, shifted; whole numbers throughout, since a float of a date is 0.2 us coarse.

    Raises
    ------
    ValueError
        If the stamp would lie before 1970, where ROS has none.
    """
    total = sec * NANOSECONDS + nanosec + shift_ns
    if total < 0:
        raise ValueError(
            f"stamp {sec}.{nanosec:09d} s shifted by {shift_ns} ns lies before 0; is the camera's clock set?"
        )
    return total // NANOSECONDS, total % NANOSECONDS


def row_stamps(stamp_ns: int, *, rows: int, row_delay_ns: float) -> list[int]:
    """Stamp of each row from the stamp of the middle of the image, ns."""
    return [stamp_ns + round((row - (rows - 1) / 2) * row_delay_ns) for row in range(rows)]


def main() -> None:
    """Run the node until it is stopped."""
    import message_filters
    import rclpy
    from rclpy.node import Node
    from sensor_msgs.msg import CameraInfo, Image

    class EffectiveStamps(Node):
        """Images and their CameraInfo, with stamps shifted."""

        def __init__(self) -> None:
            super().__init__("effective_stamps")
            self.shift_ns = self.declare_parameter("shift_ns", 0).value
            for name in ("shift_u_ns", "row_delay_ns"):
                self.declare_parameter(name, 0.0)
            self.declare_parameter("serial_number", "")
            self.images = self.create_publisher(Image, "image_effective", 10)
            self.infos = self.create_publisher(CameraInfo, "camera_info_effective", 10)
            both = [
                message_filters.Subscriber(self, Image, "image"),
                message_filters.Subscriber(self, CameraInfo, "camera_info"),
            ]
            self.pairs = message_filters.TimeSynchronizer(both, 10)
            self.pairs.registerCallback(self.shift)

        def shift(self, image: Image, info: CameraInfo) -> None:
            stamp = image.header.stamp
            stamp.sec, stamp.nanosec = effective_stamp(stamp.sec, stamp.nanosec, shift_ns=self.shift_ns)
            info.header.stamp = stamp
            self.images.publish(image)
            self.infos.publish(info)

    rclpy.init()
    rclpy.spin(EffectiveStamps())


if __name__ == "__main__":
    main()
