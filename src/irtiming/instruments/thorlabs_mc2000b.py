"""Driver of the chopper controller Thorlabs MC2000B or MC2000B-EC (user guide TTN102010-D02, sections 7 and 8).

Opening it only reads. Blade, reference, output and harmonics change only while the wheel stands.
"""

import re
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import dataclass, replace
from typing import Any, final

from pymeasure.adapters import Adapter
from pymeasure.instruments import Instrument
from pymeasure.instruments.validators import strict_discrete_set, strict_range

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
from irtiming.records.instrument_state import ChopperState
from irtiming.units import plain_integer

BLADES = (
    "MC1F2", "MC1F10", "MC1F15", "MC1F30", "MC1F60", "MC1F100", "MC1F10HP", "MC1F2P10", "MC1F6P10", "MC1F10A",
    "MC2F330", "MC2F47", "MC2F57B", "MC2F860", "MC2F5360",
)  # fmt: skip
_TWO_TRACKS = (0, 6, 7)
_TWO_SECTIONS = range(10, 15)
_MODEL = "THORLABS MC2000B"
_SPEECH = Speech(baud=115_200, ends=">")  # of the prompt "\r> "; what is left of it leads the next answer
_GAP_S = 0.2  # it loses replies when it is asked more often
_TRIES = 3
_MOST_STRANGE = 20  # answers to nothing that was asked, in one wait
_ERROR = "Command error"
_NUMBER = re.compile(r"[-+]?\d+(\.\d+)?")


class UnknownCommand(InstrumentRefused):
    """The controller's firmware has no such command."""


class MC2000B(Instrument):  # type: ignore[misc]  # pymeasure has no types
    """The controller behind an adapter of pymeasure. Nothing is sent before a property is read or set.

    Every command is echoed; an answer counts only behind its own echo, up to the prompt. ``gap_s`` keeps commands apart.
    """

    def __init__(self, adapter: Adapter, name: str = "Thorlabs MC2000B", *, gap_s: float = _GAP_S) -> None:
        super().__init__(adapter, name, includeSCPI=False)
        self._pace = Pace(gap_s)

    identity = Instrument.measurement(
        "id?",
        """Get what the controller says of itself.""",
        cast=str,
        preprocess_reply=lambda reply: reply.split("\r")[0],
    )
    blade = Instrument.control(
        "blade?", "blade=%d", """Control the name of the blade that is set.""",
        validator=strict_discrete_set, values={name: number for number, name in enumerate(BLADES)}, map_values=True, cast=int,
    )  # fmt: skip
    reference = Instrument.control(
        "ref?", "ref=%d", """Control the number of the reference; see `references` of the blade.""",
        validator=strict_range, values=(0, 3), cast=int,
    )  # fmt: skip
    output = Instrument.control(
        "output?", "output=%d", """Control the number of the reference output; see `outputs` of the blade.""",
        validator=strict_range, values=(0, 4), cast=int,
    )  # fmt: skip
    harmonic_multiplier = Instrument.control(
        "nharmonic?", "nharmonic=%d", """Control the multiplier of the external reference, 1 to 15.""",
        validator=strict_range, values=(1, 15), cast=int,
    )  # fmt: skip
    harmonic_divider = Instrument.control(
        "dharmonic?", "dharmonic=%d", """Control the divider of the external reference, 1 to 15.""",
        validator=strict_range, values=(1, 15), cast=int,
    )  # fmt: skip
    is_enabled = Instrument.control(
        "enable?", "enable=%d", """Control whether the wheel turns.""",
        validator=strict_discrete_set, values={False: 0, True: 1}, map_values=True, cast=int,
    )  # fmt: skip
    input_hz = Instrument.measurement("input?", """Measure the frequency at the reference input, Hz.""")
    says_locked = Instrument.measurement(
        "locked?", """Get its word on the lock, which proves nothing.""",
        values={False: 0, True: 1}, map_values=True, cast=int,
    )  # fmt: skip

    def ask(self, command: str, query_delay: float | None = None) -> str:
        """Answer to a command, without echo and prompt; asked again where it got lost or came to harm.

        Parameters
        ----------
        command
            Such as ``"blade?"``, or ``"blade=0"``, to which nothing is answered.
        query_delay
            Of no effect here.

        Raises
        ------
        InstrumentSilent
            If nothing comes back.
        InstrumentRefused
            If the controller knows no such command or value.
        InstrumentError
            If what comes back is no answer to this.
        """
        strange = ""
        for _ in range(_TRIES):
            try:
                answer = self._exchange(command)
            except Unanswered as error:
                strange = strange or error.arrived
                continue
            if _is_answer(command, answer):
                return answer
            strange = answer or "nothing"
        if not strange:
            raise InstrumentSilent(
                f"{self.name} does not answer {command!r}; see that it is on, its cable plugged in and this its port"
            )
        raise InstrumentError(
            f"{self.name} answers {_short(strange)} to {command!r}, which no MC2000B does: another device is at this port, or "
            "the line is disturbed; name the right port, or see to the cable"
        )

    def write(self, command: str, **_: Any) -> None:
        """Have a command done; `ask` without an answer."""
        self.ask(command)

    def _exchange(self, command: str) -> str:
        self._pace.wait()
        self.adapter.write(command)
        strange: list[str] = []
        while len(strange) < _MOST_STRANGE:
            try:
                reply = self.adapter.read()
            except Unanswered as error:
                raise Unanswered(str(error), " ".join([*strange, error.arrived]).strip()) from error
            lines = [line.strip() for line in re.split(r"[\r\n]", reply)]
            if command in lines:
                answer = "\r".join(line for line in lines[lines.index(command) + 1 :] if line)
                self._refuse(command, answer)
                return answer
            strange.append(" ".join(lines).strip())  # late, of a disturbed echo, or a line of status
        raise Unanswered(f"{self.name} talks of other things", " ".join(strange))

    def _refuse(self, command: str, answer: str) -> None:
        if answer.startswith(_ERROR):
            reason = answer.removeprefix(_ERROR).strip()
            kind = UnknownCommand if "CMD_NOT_DEFINED" in reason else InstrumentRefused
            raise kind(f"{self.name} refuses {command!r} ({reason}); see that its firmware is that of an MC2000B")


@final
@dataclass(frozen=True, kw_only=True)
class ChopperOptions:
    """``blade`` that must be mounted, by name, and the ``speed`` of a simulated rig, 1 for a chopper of this world."""

    blade: str = BLADES[0]
    speed: float = 1.0


@final
class MC2000BChopper:
    """The controller for a measurement; open it by `connected`. Implements `protocols.Chopper`."""

    def __init__(self, controller: MC2000B, *, options: ChopperOptions | None = None) -> None:
        self._controller = controller
        self._options = options or ChopperOptions()
        self._worker = Worker(controller.name)
        self._model = ""
        self._tells_lock = True

    @property
    def name(self) -> str:
        """For messages."""
        return str(self._controller.name)

    async def identify(self) -> str:
        """Ask the device what it is.

        Raises
        ------
        InstrumentRefused
            If it is no MC2000B.
        """
        self._model = await self._worker.do(self._identity)
        return self._model

    async def state(self) -> ChopperState:
        """All settings and readings now; takes two seconds, since the controller must not be asked more often."""
        return await self._worker.do(self._state)

    async def prepare(self) -> ChopperState:
        """Set it to follow the external reference with its inner slots, each of which it then puts out.

        Raises
        ------
        InstrumentRefused
            If another blade is set, the wheel turns with other settings, or a setting does not hold. A turning wheel is
            left as it is.
        """
        return await self._worker.do(self._prepare)

    async def start(self) -> None:
        """Let the wheel turn; one that turns already goes on undisturbed."""
        await self._worker.do(lambda: self._enable(True))

    async def stop(self) -> None:
        """Let the wheel come to rest."""
        await self._worker.do(lambda: self._enable(False))

    async def close(self) -> None:
        """Give the line back and leave the wheel as it is; again does no harm."""
        await self._worker.close()
        self._controller.adapter.close()

    def _identity(self) -> str:
        said = str(self._controller.identity)
        if not said.upper().startswith(_MODEL):
            raise InstrumentRefused(f"{self.name} is {_short(said)}, no {_MODEL}; name the port of the chopper")
        return said

    def _state(self) -> ChopperState:
        controller = self._controller
        blade = _read(controller, "blade")
        return ChopperState(
            model=self._model,
            blade=blade,
            reference=_word(controller, "reference", references(blade)),
            output=_word(controller, "output", outputs(blade)),
            harmonic_multiplier=_harmonic(controller, "harmonic_multiplier"),
            harmonic_divider=_harmonic(controller, "harmonic_divider"),
            is_enabled=_read(controller, "is_enabled"),
            input_hz=float(controller.input_hz),
            says_locked=self._lock(),
        )

    def _lock(self) -> bool | None:
        """Its word on the lock, which not every firmware has."""
        if self._tells_lock:
            try:
                return bool(_read(self._controller, "says_locked"))
            except UnknownCommand:
                self._tells_lock = False
        return None

    def _prepare(self) -> ChopperState:
        state = self._state()
        blade = self._options.blade
        if state.blade != blade:
            raise InstrumentRefused(
                f"{self.name} is set to blade {state.blade}, the measurement needs {blade}; mount it and set it at the "
                f"controller, or name another by ?blade={BLADES.index(state.blade)}"
            )
        wanted = {
            "reference": "external-inner" if "external-inner" in references(blade) else "external",
            "output": "inner" if "inner" in outputs(blade) else "actual",
            "harmonic_multiplier": 1,
            "harmonic_divider": 1,
        }
        wrong = {name: value for name, value in wanted.items() if getattr(state, name) != value}
        if wrong and state.is_enabled:
            complaint = ", ".join(
                f"{name} is {getattr(state, name)} and must be {value}" for name, value in wrong.items()
            )
            raise InstrumentRefused(
                f"the wheel of {self.name} turns, but {complaint}; stop it first, nothing was changed"
            )
        numbers = {"reference": references(blade), "output": outputs(blade)}
        for name, value in wrong.items():
            self._set(name, numbers[name].index(str(value)) if name in numbers else value)
        return self._confirmed(replace(state, **wrong))  # type: ignore[arg-type]  # mypy sees one type for all fields

    def _confirmed(self, wanted: ChopperState) -> ChopperState:
        """The state read once more: a number that came to harm on the line, when it was first read, shows here."""
        now = self._state()
        if replace(now, input_hz=None, says_locked=None) != replace(wanted, input_hz=None, says_locked=None):
            raise InstrumentError(
                f"{self.name} says {now}, and before {wanted}; check its cable, and leave its knobs alone"
            )
        return now

    def _enable(self, wanted: bool) -> None:
        if _read(self._controller, "is_enabled") is not wanted:
            self._set("is_enabled", wanted)

    def _set(self, name: str, value: object) -> None:
        """Set one property and read it back."""
        setattr(self._controller, name, value)
        held = _read(self._controller, name)
        if held != value:
            raise InstrumentRefused(
                f"{self.name} was set to {name} = {value}, but holds {held}; set it at the controller"
            )


def references(blade: str) -> tuple[str, ...]:
    """Words of the manual for the numbers of ``ref`` with this blade."""
    two = BLADES.index(blade) in _TWO_TRACKS
    return ("internal-outer", "internal-inner", "external-outer", "external-inner") if two else ("internal", "external")


def outputs(blade: str) -> tuple[str, ...]:
    """Words of the manual for the numbers of ``output`` with this blade."""
    number = BLADES.index(blade)
    if number in _TWO_SECTIONS:
        return ("target", "outer", "inner", "sum", "difference")
    return ("target", "outer", "inner") if number in _TWO_TRACKS else ("target", "actual")


@asynccontextmanager
async def connected(address: str) -> AsyncIterator[MC2000BChopper]:
    """Chopper at an address, for the length of an ``async with`` block; its wheel goes on as it is.

    Parameters
    ----------
    address
        Serial port, or another line, with options: ``"/dev/ttyUSB0?blade=MC1F2"`` (name or number of the blade that must be
        mounted), ``speed`` of a simulated rig.

    Raises
    ------
    InstrumentError
        If the line cannot be opened, nothing answers, or it is no MC2000B.
    """
    line, given = split_options(address, ("blade", "speed"))
    options = ChopperOptions(blade=_blade(given.get("blade", "0")), speed=speed_of(given))
    worker = Worker(f"opens {line}")
    try:
        adapter = await worker.do(lambda: open_text_line(line, _SPEECH))
    finally:
        await worker.close()
    chopper = MC2000BChopper(MC2000B(adapter, f"chopper at {line}", gap_s=_GAP_S / options.speed), options=options)
    try:
        await chopper.identify()
        yield chopper
    finally:
        await chopper.close()


def _blade(text: str) -> str:
    if text.upper() in BLADES:
        return text.upper()
    number = plain_integer(text)
    if number is not None and number < len(BLADES):
        return BLADES[number]
    raise InstrumentError(
        f"blade={text} is no blade; write a number from 0 to {len(BLADES) - 1} or one of {', '.join(BLADES)}"
    )


def _read(controller: MC2000B, name: str) -> Any:
    try:
        return getattr(controller, name)
    except KeyError as error:
        raise InstrumentError(
            f"{controller.name} gives {name} as a number that its manual does not have ({error})"
        ) from error


def _word(controller: MC2000B, name: str, words: tuple[str, ...]) -> str:
    number = _read(controller, name)
    if number not in range(len(words)):
        raise InstrumentError(
            f"{controller.name} gives {name} {number}, its manual has 0 to {len(words) - 1} for this blade"
        )
    return words[int(number)]


def _harmonic(controller: MC2000B, name: str) -> int:
    number = _read(controller, name)
    if number not in range(1, 16):
        raise InstrumentError(f"{controller.name} gives {name} {number}, its manual has 1 to 15")
    return int(number)


def _is_answer(command: str, answer: str) -> bool:
    """Whether this can be the answer: none to a setting, any to ``id?``, else one number."""
    if not command.endswith("?"):
        return not answer
    return bool(answer) if command == "id?" else _NUMBER.fullmatch(answer) is not None


def _short(text: str) -> str:
    words = " ".join(text.split())
    return repr(words if len(words) <= 60 else words[:57] + "...")
