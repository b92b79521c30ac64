"""Driver of the blackbody CI Systems SR-800R (ControlMaster, manual 605-7040, chapter 6): texts over RS-232, TCP or UDP.

Opening it only asks. Its successor SR-800N speaks in binary; it is recognised and refused.
"""

import re
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import replace
from typing import Any, final

from pymeasure.adapters import Adapter
from pymeasure.instruments import Instrument
from pymeasure.instruments.validators import strict_range

from irtiming.errors import InstrumentError, InstrumentRefused, InstrumentSilent
from irtiming.instruments.visa_line import (
    Pace,
    Speech,
    Unanswered,
    Worker,
    open_text_line,
    speed_of,
    split_options,
)
from irtiming.records.instrument_state import BlackbodyState
from irtiming.units import ZERO_CELSIUS_K, plain_integer

_MODEL = "SR-800R"
_SPEECH = Speech(baud=9600, quiet_s=0.1)  # the end of its answers is not known for every line
_GAP_S = 0.31  # at most three messages a second
_STABLE_GAP_S = 1.0  # section 6.2.25
_TIMING_S = 0.01  # by which two messages may come nearer to each other on their way
_TRIES = 3
_HELLO = "IRTIMING"
_LOWEST_DEGC, _HIGHEST_DEGC = -100.0, 1500.0  # nothing of the maker's goes beyond
_STEP_DEGC = 0.001
_NEAR_K = 0.5
"""A temperature farther from its target is not stable there, whatever the unit says: its word may still be on the last one."""

_TEMPERATURE = re.compile(r"[-+]?\d+(\.\d+)?")
_ANSWERS = {
    "GETTEMPERATURE": _TEMPERATURE,
    "GETTARGETTEMPERATURE": _TEMPERATURE,
    "ISTEMPERATURESTABLE": re.compile("[01]"),
    "GETBITERROR": re.compile(r"[\x20-\x7e]+"),
    f"ECHO {_HELLO}": re.compile(_HELLO, re.IGNORECASE),
}
_BINARY_START = "\xaa\x01"  # of every message of an SR-800N
_MOST_EMPTY = 4  # lines before an answer


class UnknownCommand(InstrumentRefused):
    """The blackbody's firmware has no such command."""


class SR800R(Instrument):  # type: ignore[misc]  # pymeasure has no types
    """The controller behind an adapter of pymeasure. Nothing is sent before a property is read or set."""

    def __init__(self, adapter: Adapter, name: str = "CI Systems SR-800R", *, speed: float = 1.0) -> None:
        super().__init__(adapter, name, includeSCPI=False)
        self._pace = Pace(_GAP_S / speed + (_TIMING_S if speed != 1 else 0.0))
        self._stable_pace = Pace(_STABLE_GAP_S / speed)
        self._no_answer_s = _GAP_S / speed

    greeting = Instrument.measurement(f"ECHO {_HELLO}", """Get a word back from it.""", cast=str)
    temperature_degc = Instrument.measurement("GETTEMPERATURE", """Measure the temperature, degrees Celsius.""")
    target_degc = Instrument.control(
        "GETTARGETTEMPERATURE", "SETTEMPERATURE %.3f", """Control the temperature to go to, degrees Celsius.""",
        validator=strict_range, values=(_LOWEST_DEGC, _HIGHEST_DEGC),
    )  # fmt: skip
    is_stable = Instrument.measurement(
        "ISTEMPERATURESTABLE", """Get its word on whether the temperature is stable.""",
        values={False: 0, True: 1}, map_values=True, cast=int,
    )  # fmt: skip
    bit_error = Instrument.measurement(
        "GETBITERROR", """Get the result of its self-test, with OK where it found no fault.""",
        cast=str, separator="\r",
    )  # fmt: skip
    mode = Instrument.setting("SETMODE %d", """Set the mode; 1 is that of absolute temperatures.""")

    def ask(self, command: str, query_delay: float | None = None) -> str:
        """Answer to a question, asked again where it got lost or came to harm.

        Parameters
        ----------
        command
            Such as ``"GETTEMPERATURE"``.
        query_delay
            Of no effect here.

        Raises
        ------
        InstrumentSilent
            If nothing comes back.
        InstrumentRefused
            If the blackbody knows no such command, or is one that speaks in binary.
        InstrumentError
            If what comes back is no answer to this.
        """
        strange, refusal = "", None
        for _ in range(_TRIES):  # a command that came to harm on its way there is refused as well
            self._send(command)
            try:
                answer = self._answer()
            except Unanswered as error:
                strange = error.arrived or strange
                continue
            refusal = self._refusal(command, answer)
            if refusal is None and _ANSWERS[command].fullmatch(answer):
                return answer
            strange = answer or strange
        if refusal is not None:
            raise refusal
        if not strange:
            raise InstrumentSilent(
                f"{self.name} does not answer {command!r}; see that it is on, shows its main window, and is set to this line. "
                "An SR-800N speaks in binary and cannot be used"
            )
        raise InstrumentError(
            f"{self.name} answers {_short(strange)} to {command!r}, which no {_MODEL} does: another device is at this line, or "
            "it is disturbed; name the right line, or see to the cable"
        )

    def write(self, command: str, **_: Any) -> None:
        """Send a setting; the unit answers only to refuse it."""
        refusal = None
        for _attempt in range(_TRIES):
            self._send(command)
            try:
                refusal = self._refusal(command, self.adapter.read(timeout_s=self._no_answer_s).strip())
            except Unanswered:
                return
            if refusal is None:
                return
        if refusal is not None:
            raise refusal

    def _send(self, command: str) -> None:
        if command == "ISTEMPERATURESTABLE":
            self._stable_pace.wait()
        self._pace.wait()
        self.adapter.flush_read_buffer()  # what comes late answers something else
        self.adapter.write(command)

    def _answer(self) -> str:
        """What comes first that is no empty line."""
        answer = ""
        for _ in range(_MOST_EMPTY):
            answer = answer or str(self.adapter.read()).strip()
        return answer

    def _refusal(self, command: str, answer: str) -> InstrumentRefused | None:
        if answer.startswith(_BINARY_START):
            return InstrumentRefused(
                f"{self.name} speaks the binary protocol of an SR-800N; this driver is for an {_MODEL}"
            )
        if "invalidcommand" in answer.lower():
            return UnknownCommand(
                f"{self.name} has no command {command!r} ({_short(answer)}); see that it is an {_MODEL}"
            )
        if "invalidoperand" in answer.lower():
            return InstrumentRefused(f"{self.name} refuses {command!r} ({_short(answer)}); see the range in its manual")
        return None


@final
class SR800RBlackbody:
    """The blackbody for a measurement; open it by `connected`. Implements `protocols.Blackbody`."""

    def __init__(self, controller: SR800R) -> None:
        self._controller = controller
        self._worker = Worker(controller.name)
        self._lacks: set[str] = set()

    @property
    def name(self) -> str:
        """For messages."""
        return str(self._controller.name)

    async def identify(self) -> None:
        """Make sure that the device is what it should be, by questions alone.

        Raises
        ------
        InstrumentRefused
            If it is none, or its self-test found a fault.
        """
        await self._worker.do(self._identify)

    async def state(self) -> BlackbodyState:
        """Temperatures now; takes more than a second, since it must not be asked more often."""
        return await self._worker.do(self._state)

    async def set_target(self, temperature_k: float) -> None:
        """Go to a temperature.

        Parameters
        ----------
        temperature_k
            To a millikelvin.

        Raises
        ------
        InstrumentRefused
            If the unit refuses it, holds another one afterwards, or has a fault.
        """
        await self._worker.do(lambda: self._set_target(temperature_k))

    async def close(self) -> None:
        """Give the line back and leave the temperature as it is; again does no harm."""
        await self._worker.close()
        self._controller.adapter.close()

    def _identify(self) -> None:
        try:
            self._controller.greeting  # noqa: B018 - the question is the point
            degc = self._controller.temperature_degc
        except UnknownCommand as error:
            raise InstrumentRefused(f"{error}; name the line of the blackbody") from error
        if not _LOWEST_DEGC <= degc <= _HIGHEST_DEGC:
            raise InstrumentRefused(
                f"{self.name} says it has {degc:g} degrees Celsius, which no {_MODEL} reaches; see to its line"
            )
        self._refuse_faults()

    def _state(self) -> BlackbodyState:
        self._refuse_faults()
        target = self._optional("target_degc")
        temperature_k = self._controller.temperature_degc + ZERO_CELSIUS_K
        target_k = None if target is None else target + ZERO_CELSIUS_K
        is_near = target_k is None or abs(temperature_k - target_k) <= _NEAR_K
        return BlackbodyState(
            model=_MODEL,
            temperature_k=temperature_k,
            target_k=target_k,
            is_stable=bool(self._controller.is_stable) and is_near,
        )

    def _set_target(self, temperature_k: float) -> None:
        degc = temperature_k - ZERO_CELSIUS_K
        if not _LOWEST_DEGC <= degc <= _HIGHEST_DEGC:
            raise InstrumentRefused(
                f"no {_MODEL} goes to {temperature_k:g} K; give a temperature from {_LOWEST_DEGC + ZERO_CELSIUS_K:g} to "
                f"{_HIGHEST_DEGC + ZERO_CELSIUS_K:g} K"
            )
        self._refuse_faults()
        held: float | None = None
        for _ in range(_TRIES):  # a message that got lost is not answered, nor is one that arrived
            self._controller.mode = 1
            self._controller.target_degc = degc
            held = self._optional("target_degc")
            if held is None or abs(held - degc) <= _STEP_DEGC:
                return
        raise InstrumentRefused(
            f"{self.name} was set to {degc:.3f} degrees Celsius, but goes to {held:.3f}; see its limits in its menu"
        )

    def _refuse_faults(self) -> None:
        for _ in range(_TRIES):  # a word that came to harm is no fault; a fault stays
            found = self._optional("bit_error")
            if found is None or re.search(r"\bOK\b", found, re.IGNORECASE):
                return
        if found is not None:
            raise InstrumentRefused(
                f"{self.name} reports a fault ({_short(found)}); see its manual, then switch it off and on"
            )

    def _optional(self, what: str) -> Any:
        """Value of a property, or None for a unit without its command."""
        if what in self._lacks:
            return None
        try:
            return getattr(self._controller, what)
        except UnknownCommand:
            self._lacks.add(what)
            return None


@asynccontextmanager
async def connected(address: str) -> AsyncIterator[SR800RBlackbody]:
    """Blackbody at an address, for the length of an ``async with`` block; its temperature goes on as it is.

    Parameters
    ----------
    address
        Serial port, ``tcp:HOST:5200``, ``udp:HOST:5200`` or a VISA name, with options: ``reply_port`` at which answers over UDP
        arrive (5100 as the unit is delivered, 0 for the one of the question), ``speed`` of a simulated rig.

    Raises
    ------
    InstrumentError
        If the line cannot be opened, nothing answers, or it is no SR-800R.
    """
    line, given = split_options(address, ("reply_port", "speed"))
    speed = speed_of(given)
    port = given.get("reply_port", "5100")
    number = plain_integer(port)
    if number is None or number >= 2**16:
        raise InstrumentError(f"reply_port={port} is no port; write a number from 0 to 65535")
    speech = replace(_SPEECH, quiet_s=0.1 if speed == 1 else 0.03)
    worker = Worker(f"opens {line}")
    try:
        adapter = await worker.do(lambda: open_text_line(line, speech, reply_port=number))
    finally:
        await worker.close()
    blackbody = SR800RBlackbody(SR800R(adapter, f"blackbody at {line}", speed=speed))
    try:
        await blackbody.identify()
        yield blackbody
    finally:
        await blackbody.close()


def _short(text: str) -> str:
    words = " ".join(text.split())
    return repr(words if len(words) <= 60 else words[:57] + "...")
