"""The blackbody: brought to a temperature before a run, and watched during it."""

import asyncio
from time import monotonic
from typing import final

from irtiming.acquire.attendant import Attendant
from irtiming.acquire.rig import Rig
from irtiming.errors import InstrumentError
from irtiming.records.instrument_state import BlackbodyState
from irtiming.records.series_plan import BlackbodyWishes
from irtiming.units import ZERO_CELSIUS_K, readable_time

_POLL_S = 1.5
"""Of the rig's time; the SR-800R must not be asked for stability more often than once a second."""

_SAME_TARGET_K = 0.005
_MOST_SILENT = 2
_SAME_K, _TRIES = 0.1, 4
"""A temperature counts when it was said twice: a line without check sums may turn any digit into another."""


async def settled(rig: Rig, target_k: float, *, wishes: BlackbodyWishes, attendant: Attendant) -> BlackbodyState | None:
    """Bring the blackbody to a temperature and wait until it is there and says that it is stable.

    Parameters
    ----------
    rig
        With a blackbody.
    target_k
        Where to.
    wishes
        How long it may take, and how near it must come.
    attendant
        Learns what is waited for, and may leave.

    Returns
    -------
    Its state when stable, None if the waiting was ended.

    Raises
    ------
    InstrumentError
        If it fails, or is not stable in time.
    """
    blackbody = rig.blackbody
    if blackbody is None:
        raise InstrumentError("the rig has no blackbody that can be set; name it in [devices]")
    state = await blackbody.state()
    if state.target_k is None or abs(state.target_k - target_k) > _SAME_TARGET_K:
        await blackbody.set_target(target_k)
        await asyncio.sleep(rig.host_s(_POLL_S))
        state = await blackbody.state()
    begun = monotonic()
    if not _is_there(state, target_k, wishes):
        attendant.says(
            f"waiting for the blackbody to settle at {celsius(target_k)}, now {celsius(state.temperature_k)}"
        )
    while not _is_there(state, target_k, wishes):
        if attendant.is_leaving():
            return None
        if monotonic() - begun > rig.host_s(wishes.settle_within_s):
            raise InstrumentError(
                f"{blackbody.name} is at {celsius(state.temperature_k)} and not stable at {celsius(target_k)} after "
                f"{readable_time(wishes.settle_within_s)}; wait longer (settle_within), or see what keeps it from there"
            )
        await asyncio.sleep(rig.host_s(_POLL_S))
        state = await blackbody.state()
    return state


async def as_it_is(rig: Rig) -> BlackbodyState | None:
    """State of the blackbody whatever its temperature is, which is asked for twice; None where there is none.

    Raises
    ------
    InstrumentError
        If it fails, or says another temperature each time.
    """
    if rig.blackbody is None:
        return None
    before = await rig.blackbody.state()
    for _ in range(_TRIES):
        state = await rig.blackbody.state()
        if abs(state.temperature_k - before.temperature_k) <= _SAME_K:
            return state
        before, said = state, before
    raise InstrumentError(
        f"{rig.blackbody.name} says {celsius(said.temperature_k)} and then {celsius(state.temperature_k)}; wait until it is "
        "stable, or see to its line"
    )


@final
class TemperatureWatch:
    """Asks the blackbody during a run; ``complaint`` says when it has left its temperature, ``last`` where it was."""

    def __init__(self, rig: Rig, before: BlackbodyState, *, tolerance_k: float) -> None:
        self._rig = rig
        self._before = before
        self._tolerance_k = tolerance_k
        self._silent = self._away = 0
        self.last = before
        self.complaint: str | None = None

    async def watch(self) -> None:
        """Ask again and again until cancelled."""
        while self.complaint is None:
            await asyncio.sleep(self._rig.host_s(_POLL_S))
            await self._ask()

    async def ask_at_the_end(self) -> None:
        """Ask until it is clear whether the blackbody still has its temperature."""
        has_noted = False
        while self.complaint is None and not has_noted:
            await self._ask()
            has_noted = self._silent == self._away == 0

    async def _ask(self) -> None:
        """An answer that fails to come is asked for again, and so is one that tells of another temperature."""
        if self._rig.blackbody is None:
            return
        try:
            self.last = await self._rig.blackbody.state()
        except InstrumentError as error:
            self._silent += 1
            if self._silent > _MOST_SILENT:
                self.complaint = str(error)
            return
        self._silent = 0
        is_away = abs(self.last.temperature_k - self._before.temperature_k) > self._tolerance_k
        self._away = self._away + 1 if is_away else 0
        if self._away > 1:
            self.complaint = (
                f"the blackbody went from {celsius(self._before.temperature_k)} to "
                f"{celsius(self.last.temperature_k)} during the run, {self._tolerance_k:g} K are allowed; wait until "
                "it is stable and record again"
            )


def celsius(temperature_k: float) -> str:
    """Temperature as people at a blackbody read it."""
    return f"{temperature_k - ZERO_CELSIUS_K:.2f} °C"


def _is_there(state: BlackbodyState, target_k: float, wishes: BlackbodyWishes) -> bool:
    return state.is_stable and abs(state.temperature_k - target_k) <= wishes.tolerance_k
