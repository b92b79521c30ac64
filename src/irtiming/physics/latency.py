r"""What late timestamps do to the wheel's angle (light gates, trigger path), and what they leave in a delay.

An edge that passes the application beam at t is timestamped at t + L_a, a slot at the control beam at t + L_c, and a trigger
reaches the camera's connector L_t after its timestamp. With theta(t) the wheel's angle and omega its speed:

- The slots' timestamps say theta + dbeta at a time that is L_c too late. Read at the timestamp of the reference edge they give
  dbeta + omega (L_a - L_c): what the gates seem to be apart.
- With that taken for their distance, the angle that the slots say at the timestamp of a trigger is theta(t - L_a). The camera,
  whose delay D counts from the connector, exposes at theta(t + L_t + D). So the delay comes out as D + L_a + L_t.
- beta_1 follows from dbeta, and an edge that is taken to pass beta_1 too late by an angle makes the delay shorter by that angle
  over omega. With s = d beta_1 / d dbeta the delay is D + L_t + L_a - s (L_a - L_c).

A gate distance from recordings at another speed, omega', puts omega' (L_a - L_c) / omega in place of L_a - L_c; so it is with the
mean of dbeta over recordings, from which beta_1 follows.
"""

from dataclasses import dataclass
from math import sqrt
from typing import final

from irtiming.records.rig import CameraOptics, Latency, Measured, WindowTail

USUAL_CLOCK = Measured(0.0, 50e-6 / sqrt(3))
"""Relative error of an unmeasured crystal: within +-50 ppm, all alike."""

USUAL_TAIL = WindowTail(share=Measured(0.0, 0.04 / sqrt(3)))
"""Tail of an unmeasured window: a share from 0 to 4 %, all alike, over 0.2 ms.

No correction is made for it, so that its uncertainty is the root mean square about 0, not the spread about the mean of 2 %.
"""

EXACT_S = 1e-9
"""Standard uncertainty of an integration time that is stated as exact."""


@final
@dataclass(frozen=True, kw_only=True)
class Late:
    """Latencies as numbers, s; 0 where rig.toml does not state one."""

    application_gate_s: float
    control_gate_s: float
    trigger_s: float

    @property
    def register_s(self) -> float:
        """By how much more the application gate is late than the control gate: omega times that is added to their distance."""
        return self.application_gate_s - self.control_gate_s

    @property
    def slots_s(self) -> float:
        """From when a slot passes the control beam to the moment that its timestamp stands for at the camera's connector."""
        return self.control_gate_s + self.trigger_s


def stated(latency: Latency | None) -> Late:
    """The latencies that rig.toml states.

    Parameters
    ----------
    latency
        None where there is no such section.
    """
    given = latency or Latency()
    return Late(
        application_gate_s=_value(given.application_gate_s),
        control_gate_s=_value(given.control_gate_s),
        trigger_s=_value(given.trigger_s),
    )


def window_tail(camera: CameraOptics) -> WindowTail | None:
    """What is known of the tail: what rig.toml states; a usual one where it vouches for the length alone; else None.

    Parameters
    ----------
    camera
        As measured. Where no uncertainty of the length is stated, the whole window is taken on trust.
    """
    return camera.window_tail or (None if camera.integration_time_u_s is None else USUAL_TAIL)


def _value(number: Measured | None) -> float:
    return 0.0 if number is None else number.value


def effects_s(
    *, angular_frequency_rad_per_s: float, register_rad_per_s: float, gates_rad_per_s: float, per_separation: float
) -> dict[str, float]:
    """What one second of each latency that was not corrected adds to the delay of a recording, by name.

    Parameters
    ----------
    angular_frequency_rad_per_s
        Of the wheel in the recording.
    register_rad_per_s
        Mean of it over the recordings that determined the gate distance of this recording's angles.
    gates_rad_per_s
        The same of the gate distance that beta_1 follows from.
    per_separation
        s, derivative of beta_1 to that distance.
    """
    register = (register_rad_per_s - per_separation * gates_rad_per_s) / angular_frequency_rad_per_s
    return {"application_gate": register, "control_gate": 1.0 - register, "trigger": 1.0}
