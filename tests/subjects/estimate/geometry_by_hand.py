"""What a rig.toml says of a wheel and its light gates, as numbers."""

import numpy as np

from irtiming.physics.wheel import wheel_model
from irtiming.records.wheel_geometry import GateAngles, WheelGeometry

GATES = GateAngles(
    application_rad=0.27, control_rad=0.3, height_m=0.047, control_height_m=0.0415, sensitivity=(0.5, 0.0, 1.0)
)


def geometry_by_hand(*, common=(5e-4, 2e-4), u_edge=1e-4, edges_from="rig.toml", findings=()) -> WheelGeometry:
    """What is known of the angles: two common errors and, where told, that of a single edge."""
    return WheelGeometry(
        model=wheel_model(
            (0.0, 1.57, 3.15, 4.71), 0.27, opening_angle_rad=1.3, centre_angle_rad=float(np.radians(-90))
        ),
        gates=GATES,
        angle_budget=tuple((f"angle {k}", "B", u) for k, u in enumerate(common)),
        u_edge_rad=u_edge,
        edges_from=edges_from,
        camera_roll_rad=None,
        findings=findings,
    )
