"""Words by which a person, or a script, meddles with a simulated rig: take the wheel away, break a device, look at the truth."""

import json
import socket
from contextlib import suppress
from dataclasses import asdict, fields
from threading import Event, Thread
from types import TracebackType
from typing import Any, Self, final

from irtiming.errors import InstrumentError
from irtiming.twin.devices.bench import Bench

WORDS = (
    "remove                      take wheel and mask out of the way: the camera sees the bare blackbody",
    "insert                      put them back",
    "fault DEVICE.NAME=VALUE     break something, such as camera.packets_lost_per_mille=2 or chopper.is_silent=true",
    "lose-lock SHARE             let the wheel run beside its reference, such as 0.02; 0 mends it",
    "unplug generator            take the trigger generator's port away",
    "state                       settings, temperatures and faults as they truly are, as JSON",
)
"""What can be said, one line each."""

_POLL_S = 0.05
_MOST_BYTES = 4096
_LARGEST = 1e9


@final
class Console:
    """Listens at a loopback port, one sentence per connection, while its ``with`` block runs.

    Parameters
    ----------
    bench
        The rig, served.
    port
        Number; 0 for any that is free.

    Raises
    ------
    InstrumentError
        If the port is taken.
    """

    def __init__(self, bench: Bench, *, port: int = 0) -> None:
        self._bench = bench
        self._socket = socket.socket()
        self._socket.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)  # a rig may be started again at once
        try:
            self._socket.bind(("127.0.0.1", port))
        except OSError as error:
            self._socket.close()
            raise InstrumentError(
                f"port {port} cannot be listened at ({error.strerror}); end the program that uses it, or name another"
            ) from error
        self._socket.listen()
        self._socket.settimeout(_POLL_S)
        self._is_over = Event()
        self._thread = Thread(target=self._serve, name="console of the rig", daemon=True)

    @property
    def port(self) -> int:
        """Where it listens."""
        return int(self._socket.getsockname()[1])

    def __enter__(self) -> Self:
        self._thread.start()
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._is_over.set()
        self._thread.join()
        self._socket.close()

    def _serve(self) -> None:
        while not self._is_over.is_set():
            with suppress(OSError):  # no caller, or the caller is gone
                caller, _ = self._socket.accept()
                with caller:
                    caller.settimeout(1.0)
                    said = caller.recv(_MOST_BYTES).decode(errors="replace").strip()
                    caller.sendall(f"{obey(self._bench, said)}\n".encode())


def say(sentence: str, *, port: int) -> str:
    """Say something to a rig that is served on this computer, and give its answer.

    Parameters
    ----------
    sentence
        One of `WORDS`.
    port
        Of its console.

    Raises
    ------
    InstrumentError
        If there is no listener, or the rig does not understand.
    """
    try:
        with socket.create_connection(("127.0.0.1", port), timeout=5.0) as line:
            line.sendall(f"{sentence}\n".encode())
            answer = b"".join(iter(lambda: line.recv(_MOST_BYTES), b"")).decode().strip()
    except OSError as error:
        raise InstrumentError(
            f"no simulated rig listens at port {port} ({error.strerror or error}); start one with irtiming rig --simulate"
        ) from error
    if answer.startswith("error: "):
        raise InstrumentError(answer.removeprefix("error: "))
    return answer


def obey(bench: Bench, sentence: str) -> str:
    """Do what a sentence asks for; the answer is one line, ``error: `` before one that cannot be done.

    Parameters
    ----------
    bench
        The rig, served.
    sentence
        One of `WORDS`.
    """
    sentence = " ".join(sentence.split())
    word, _, rest = sentence.partition(" ")
    if word in ("remove", "insert") and not rest:
        bench.view.bare_blackbody = word == "remove"
        return "wheel and mask are " + ("out of the way" if word == "remove" else "in their place")
    if word == "fault":
        return _fault(bench, rest)
    if word == "lose-lock":
        return _lose_lock(bench, rest)
    if sentence == "unplug generator":
        bench.unplug_generator()
        return "the trigger generator is unplugged"
    if word == "state" and not rest:
        return json.dumps(_state(bench), default=list)
    known = "; ".join(line.split("  ")[0] for line in WORDS)
    return f"error: '{sentence}' is nothing that this rig understands; say one of: {known}"


def _lose_lock(bench: Bench, text: str) -> str:
    try:
        share = float(text)
    except ValueError:
        return f"error: lose-lock '{text}' is no number; say by which part of its speed the wheel is off, such as 0.02"
    if not abs(share) < 1:
        return f"error: lose-lock {share:g} is too much; it must lie between -1 and 1"
    bench.chopper.lose_lock(share)
    return f"the wheel runs {share:g} of its speed beside its reference" if share else "the wheel follows its reference"


def _fault(bench: Bench, text: str) -> str:
    place, sign, value = text.partition("=")
    device, _, name = place.strip().partition(".")
    faults = bench.faults.get(device)
    if faults is None or not sign:
        return (
            f"error: fault '{text}' is none; write DEVICE.NAME=VALUE, with one of the devices {', '.join(bench.faults)}"
        )
    kinds = {field.name: type(getattr(faults, field.name)) for field in fields(faults)}
    if name not in kinds:
        return f"error: the {device} has no fault '{name}'; it has {', '.join(kinds)}"
    try:
        setattr(faults, name, _converted(value.strip(), kinds[name]))
    except ValueError:
        return f"error: {device}.{name} = '{value.strip()}' cannot be; it is now {getattr(faults, name)!r}: write one like it"
    held = getattr(faults, name)
    return f"{device}.{name} = {sorted(held) if kinds[name] is frozenset else held!r}"


def _converted(text: str, kind: type) -> Any:
    if kind is bool:
        if text.lower() not in ("true", "false"):
            raise ValueError(text)
        return text.lower() == "true"
    if kind is frozenset:
        return frozenset(int(part) for part in text.replace(",", " ").split())
    found = kind(text)
    if kind in (int, float) and not abs(found) <= _LARGEST:
        raise ValueError(text)
    return found


def _state(bench: Bench) -> dict[str, Any]:
    chopper, blackbody = bench.chopper, bench.blackbody
    return {
        "addresses": bench.addresses,
        "bare_blackbody": bench.view.bare_blackbody,
        "wheel_hz": chopper.rotation_hz,
        "chopper": chopper.settings,
        "blackbody_k": blackbody.temperature_k,
        "blackbody_target_k": blackbody.target_k,
        "triggers_ignored": bench.view.triggers_ignored,
        "faults": {device: asdict(faults) for device, faults in bench.faults.items()},
    }
