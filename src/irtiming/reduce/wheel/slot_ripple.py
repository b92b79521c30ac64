"""Tell the slots' own angles from a speed ripple that is locked to the wheel: at several speeds, by how it falls."""

from collections.abc import Sequence

import numpy as np

from irtiming.physics import slot_orders
from irtiming.records.wheel_calibration import SlotsAtSpeed, SpeedRipple
from irtiming.reduce.wheel.slot_table import SlotTable

_CLEARLY_APART = 1.2  # fastest over slowest speed
_LEAST_VARIANCE_RAD2 = 1e-18  # a nanoradian; for wheels on paper, which scatter not at all


def separate(speeds: Sequence[SlotsAtSpeed]) -> tuple[SlotTable, SpeedRipple | None]:
    """Slots and ripple from the apparent slots at each speed.

    A torque that repeats every turn moves the wheel by an angle that falls with the square of the speed. So each order is
    fitted with a + b (slowest speed / speed)^2 by weighted least squares. Where b is mere noise it would only blur a: it is
    shrunk by the factor b^2 / (b^2 + its variance), and counts with as much of its variance.

    Parameters
    ----------
    speeds
        Of one wheel. Where the fastest is not 1.2 times the slowest, they count as one speed.

    Returns
    -------
    Slots, and the ripple at the slowest speed; None at one speed, where the slots hold it.
    """
    n_slots = speeds[0].deviation_rad.size
    hz = np.array([one.rotation_speed_hz for one in speeds])
    spectra = slot_orders.spectrum(np.array([one.deviation_rad for one in speeds]))
    weight = 1 / np.maximum([one.order_variance_rad2 for one in speeds], _LEAST_VARIANCE_RAD2)
    total = weight.sum(axis=0)
    mean = np.sum(weight * spectra, axis=0) / total
    if hz.max() < _CLEARLY_APART * hz.min():
        return SlotTable(deviation_rad=slot_orders.from_spectrum(mean, n_slots), order_variance_rad2=1 / total), None
    fall = ((hz.min() / hz) ** 2)[:, None]
    middle = np.sum(weight * fall, axis=0) / total
    reach = np.sum(weight * (fall - middle) ** 2, axis=0)
    slope = np.sum(weight * (fall - middle) * spectra, axis=0) / reach
    strength = np.abs(slope) ** 2 * reach
    trust = strength / (1 + strength)
    slots = SlotTable(
        deviation_rad=slot_orders.from_spectrum(mean - middle * trust * slope, n_slots),
        order_variance_rad2=1 / total + middle**2 * trust / reach,
    )
    waves = slot_orders.degrees_of_freedom(n_slots)
    return slots, SpeedRipple(
        reference_speed_hz=float(hz.min()),
        deviation_rad=slot_orders.from_spectrum(trust * slope, n_slots),
        order_variance_rad2=trust / reach,
        order_chance=slot_orders.p_value(strength * waves, waves),
        chance=float(slot_orders.p_value(np.sum(strength * waves), waves.sum())),
    )
