"""How far a parameter of a camera has moved from one calibration to the next."""

from dataclasses import dataclass
from typing import final

from irtiming.records.setting_point import SettingPoint


@final
@dataclass(frozen=True, kw_only=True)
class Drift:
    """The mean of the results of the newest day less that of an earlier day, at one setting.

    ``value`` is that of the newest day, ``change`` the difference; ``standard_uncertainty`` and ``u_change`` are theirs. Errors
    of the rig that both days have in common cancel in ``u_change``. ``rate_per_year`` is the slope of all days, with
    ``u_rate_per_year``; None for fewer than three days.
    """

    parameter: str
    unit: str
    earlier: tuple[SettingPoint, ...]
    newest: tuple[SettingPoint, ...]
    value: float
    standard_uncertainty: float
    change: float
    u_change: float
    n_days: int
    rate_per_year: float | None = None
    u_rate_per_year: float | None = None

    @property
    def has_moved(self) -> bool:
        """Whether the change is more than its expanded uncertainty (k = 2)."""
        return abs(self.change) > 2 * self.u_change
