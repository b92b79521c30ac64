"""The two light gates as they truly are: where their beams lie, and when they tell of an edge."""

import math
from dataclasses import dataclass
from typing import final


@final
@dataclass(frozen=True, kw_only=True)
class Beams:
    """Light beams below the axle: application on the left at (d, h), control on the right at (d, h - dh).

    The middle between them lies ``lateral_offset_m`` beside the vertical through the axle, towards the control beam.
    ``jitter_s`` is the standard deviation of the moment at which a detector sees an edge; ``late_application_gate_s`` and
    ``late_control_gate_s`` are how much later its edges are timestamped than they pass.
    """

    half_separation_m: float = 13.0e-3
    height_difference_m: float = 5.5e-3
    height_m: float = 47.3e-3
    jitter_s: float = 0.3e-6
    lateral_offset_m: float = 0.0
    late_application_gate_s: float = 0.0
    late_control_gate_s: float = 0.0

    @property
    def beta_1_rad(self) -> float:
        """Angle of the application beam to the vertical through the axle."""
        return math.atan2(self.half_separation_m - self.lateral_offset_m, self.height_m)

    @property
    def beta_2_rad(self) -> float:
        """Angle of the control beam to the vertical through the axle."""
        across_m = self.half_separation_m + self.lateral_offset_m
        return math.atan2(across_m, self.height_m - self.height_difference_m)
