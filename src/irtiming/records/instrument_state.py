"""What the chopper's controller and the blackbody say of themselves."""

from dataclasses import dataclass
from typing import final


@final
@dataclass(frozen=True, kw_only=True)
class ChopperState:
    """Settings and readings of a chopper controller, as it says them.

    ``blade`` and ``reference`` are in the words of its manual, such as ``"MC1F2"`` and ``"external-inner"``.
    ``input_hz`` is the frequency that it measures at its reference input; ``says_locked`` its own word on the lock, which
    proves nothing. Both are None where it does not say.
    """

    model: str
    blade: str
    reference: str
    output: str
    harmonic_multiplier: int
    harmonic_divider: int
    is_enabled: bool
    input_hz: float | None = None
    says_locked: bool | None = None


@final
@dataclass(frozen=True, kw_only=True)
class BlackbodyState:
    """Temperatures of a blackbody, K, as it says them, and its own word on whether they are stable."""

    model: str
    temperature_k: float
    target_k: float | None
    is_stable: bool
