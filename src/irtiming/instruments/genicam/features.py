"""Features of a GenICam camera by their standard names, over any way to its registers."""

import difflib
import math
from typing import Any, Protocol, final

from genicam import genapi

from irtiming.errors import InstrumentError, InstrumentRefused

_COARSENESS = 1e-3  # a camera rounds a float to a step of its own
_READABLE = (genapi.EAccessMode.RO, genapi.EAccessMode.RW)
_WRITABLE = (genapi.EAccessMode.WO, genapi.EAccessMode.RW)
_TRUTHS = {"1": True, "true": True, "on": True, "0": False, "false": False, "off": False}


EXECUTE = "execute"
"""What a command is set to, to be carried out."""


class Registers(Protocol):
    """Memory of a camera; errors are `InstrumentError`."""

    def read(self, address: int, length: int) -> bytes:
        """Bytes from an address on."""
        ...

    def write(self, address: int, data: bytes) -> None:
        """Set bytes from an address on."""
        ...


@final
class Features:
    """Features as a camera's own description explains them; values are text, as one would type them."""

    def __init__(self, description: str, *, registers: Registers, name: str) -> None:
        self._name = name
        self._port = _Port(registers)
        self._map = genapi.NodeMap()
        try:
            self._map.load_xml_from_string(description)
        except genapi.GenericException as error:
            raise InstrumentRefused(
                f"{name} describes itself in a way that cannot be read ({_reason(error)}); ask its maker for an update"
            ) from error
        self._map.connect(self._port, "Device")

    def names(self) -> list[str]:
        """All features that hold a value or are commands, in the order of the alphabet."""
        return sorted(node.node.name for node in self._map.nodes if node.node.is_feature() and _is_value(node))

    def has(self, name: str) -> bool:
        """Whether the camera has a feature of this name, and it can be used now.

        Parameters
        ----------
        name
            In words of GenICam SFNC.
        """
        if not self._map.has_node(name):
            return False
        mode = self._guarded(name, self._map.get_node(name).get_access_mode)
        return mode in _READABLE or mode in _WRITABLE

    def choices(self, name: str) -> list[str]:
        """Values that a choice may take now, in the camera's order; empty for what is no choice.

        Parameters
        ----------
        name
            Of the feature.

        Raises
        ------
        InstrumentError
            If there is no such feature, or the camera fails to answer.
        """
        node = self._node(name)
        if not isinstance(node, genapi.IEnumeration):
            return []
        return self._guarded(name, lambda: _offered(node))

    def read(self, name: str) -> str:
        """Value of a feature.

        Parameters
        ----------
        name
            In words of GenICam SFNC, such as ``"TriggerSource"``.

        Raises
        ------
        InstrumentRefused
            If there is no such feature, or it cannot be read.
        """
        node = self._node(name)
        if not _is_value(node) or isinstance(node, genapi.ICommand):
            raise InstrumentRefused(f"{name} of {self._name} holds no value")
        if self._guarded(name, node.get_access_mode) not in _READABLE:
            raise InstrumentRefused(f"{name} of {self._name} cannot be read now; other settings may lock it")
        return str(self._guarded(name, node.to_string))

    def number(self, name: str) -> float:
        """Value of an integer or float feature.

        Parameters
        ----------
        name
            In words of GenICam SFNC.

        Raises
        ------
        InstrumentRefused
            If there is no such feature, it cannot be read, or it is no number.
        """
        text = self.read(name)
        try:
            return float(text) if not text.lower().startswith("0x") else float(int(text, 16))
        except ValueError as error:
            raise InstrumentRefused(f"{name} of {self._name} is {text!r}, not a number") from error

    def write(self, name: str, *, value: str) -> str:
        """Set a feature and read it back, or carry out a command.

        Parameters
        ----------
        name
            In words of GenICam SFNC.
        value
            As one would type it; `EXECUTE` for a command.

        Returns
        -------
        What the camera then holds: a float may be rounded to a step of the camera.

        Raises
        ------
        InstrumentRefused
            If there is no such feature, it cannot be set, not to this value, or the camera then holds another.
        """
        node = self._node(name)
        if isinstance(node, genapi.ICommand):
            if value != EXECUTE:
                raise InstrumentRefused(
                    f"{name} of {self._name} is a command, not to be set to {value!r}; say {EXECUTE}"
                )
            self.execute(name)
            return value
        if not _is_value(node) or self._guarded(name, node.get_access_mode) not in _WRITABLE:
            raise InstrumentRefused(
                f"{name} of {self._name} cannot be set (read-only, or locked by another setting or while it runs)"
            )
        choices = self.choices(name)
        if choices and value not in choices:
            raise InstrumentRefused(f"{name} of {self._name} cannot be {value!r}; it may be {', '.join(choices)}")
        self._guarded(name, lambda: node.from_string(_spelled(node, value)), value=value)
        held = self.read(name)
        if not _agrees(node, held, value):
            raise InstrumentRefused(f"{name} of {self._name} was set to {value}, but the camera holds {held}")
        return held

    def execute(self, name: str) -> None:
        """Carry out a command.

        Parameters
        ----------
        name
            Of the command, such as ``"AcquisitionStart"``.

        Raises
        ------
        InstrumentRefused
            If there is no such command, or it cannot be given now.
        """
        node = self._node(name)
        if not isinstance(node, genapi.ICommand):
            raise InstrumentRefused(f"{name} of {self._name} is no command")
        self._guarded(name, node.execute)

    def forget(self) -> None:
        """Forget values that were read, since the camera may have changed them."""
        for node in self._map.nodes:
            node.node.invalidate_node()

    def close(self) -> None:
        """Let go of the registers; nothing is written."""
        self._map.disconnect()

    def _node(self, name: str) -> Any:
        if self._map.has_node(name):
            return self._map.get_node(name)
        near = difflib.get_close_matches(name, self.names(), n=3) or [
            n for n in self.names() if name.lower() in n.lower()
        ]
        cure = f"nearest names: {', '.join(near[:3])}" if near else "its manual lists its features"
        raise InstrumentRefused(f"{self._name} has no feature {name!r}; {cure}")

    def _guarded(self, name: str, action: Any, *, value: str | None = None) -> Any:
        """Do it; a failure of the registers comes back as it was, one of the description in one line."""
        self._port.failure = None
        try:
            result = action()
        except Exception as error:
            if self._port.failure is not None:
                raise self._port.failure from error
            if not isinstance(error, (genapi.GenericException, ValueError)):
                raise
            what = f"cannot be {value!r}" if value is not None else "cannot be used"
            raise InstrumentRefused(f"{name} of {self._name} {what}: {_reason(error)}") from error
        if self._port.failure is not None:
            raise self._port.failure
        return result


class _Port(genapi.AbstractPort):  # type: ignore[misc]
    """The way for GenApi; keeps the error that GenApi would turn into its own."""

    def __init__(self, registers: Registers) -> None:
        super().__init__()
        self._registers = registers
        self.failure: InstrumentError | None = None

    def read(self, address: int, length: int) -> bytes:
        try:
            return self._registers.read(address, length)
        except InstrumentError as error:
            self.failure = error
            raise

    def write(self, address: int, data: bytes) -> None:
        try:
            self._registers.write(address, bytes(data))
        except InstrumentError as error:
            self.failure = error
            raise

    def get_access_mode(self) -> Any:
        return genapi.EAccessMode.RW


def _is_value(node: Any) -> bool:
    kinds = (genapi.IInteger, genapi.IFloat, genapi.IString, genapi.IBoolean, genapi.IEnumeration, genapi.ICommand)
    return isinstance(node, kinds)


def _offered(node: Any) -> list[str]:
    usable = [entry for entry in node.entries if entry.get_access_mode() in (*_READABLE, *_WRITABLE)]
    return [entry.symbolic for entry in usable]


def _spelled(node: Any, value: str) -> str:
    """As GenApi reads it: it knows no ``on`` for a truth value."""
    if isinstance(node, genapi.IBoolean) and value.lower() in _TRUTHS:
        return "1" if _TRUTHS[value.lower()] else "0"
    return value


def _agrees(node: Any, held: str, value: str) -> bool:
    if isinstance(node, genapi.IBoolean):
        return _TRUTHS.get(held.lower()) == _TRUTHS.get(value.lower())
    if isinstance(node, genapi.IInteger):
        return int(held, 0) == int(value, 0)
    if isinstance(node, genapi.IFloat):
        return math.isclose(float(held), float(value), rel_tol=_COARSENESS)
    return held == value


def _reason(error: Exception) -> str:
    """The first words of an error of GenApi, without the place in its source."""
    return " ".join(str(error).split()).split(" : ")[0].removesuffix(".")
