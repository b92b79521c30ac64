"""The trigger generator on a board: ports at the pins of a header, the board's serial line, a clock from its crystal."""

from importlib import import_module
from typing import Any, final

from amaranth.build import Attrs, Pins, Resource, Subsignal
from amaranth.hdl import ClockDomain, Const, Elaboratable, Module
from amaranth.lib import io

from irtiming.gateware.boards import INPUTS, OUTPUTS, Board
from irtiming.gateware.clocking import Clocking
from irtiming.gateware.trigger_generator import TriggerGenerator

_OUTPUT_ATTRIBUTES = {
    "ice40": {"IO_STANDARD": "SB_LVCMOS"},
    "ecp5": {"IO_TYPE": "LVCMOS33"},
    "gowin": {"IO_TYPE": "LVCMOS33"},
}
_INPUT_ATTRIBUTES: dict[str, dict[str, str | int]] = {  # pulled up: a signal that is not wired stays quiet
    "ice40": {"IO_STANDARD": "SB_LVCMOS", "PULLUP": 1},
    "ecp5": {"IO_TYPE": "LVCMOS33", "PULLMODE": "UP"},
    "gowin": {"IO_TYPE": "LVCMOS33", "PULL_MODE": "UP"},
}


def make_platform(board: Board) -> Any:
    """Amaranth's platform for this board, with the header's pins added.

    Parameters
    ----------
    board
        One of `boards.BOARDS`.

    Returns
    -------
    An instance of ``amaranth.build.Platform``, good for one build.
    """
    module, name = board.platform
    platform = getattr(import_module(f"amaranth_boards.{module}"), name)()
    outputs, inputs = Attrs(**_OUTPUT_ATTRIBUTES[board.family]), Attrs(**_INPUT_ATTRIBUTES[board.family])
    header = [Subsignal(name, Pins(board.pins[name].chip_pin, dir="o"), outputs) for name in OUTPUTS]
    header += [Subsignal(name, Pins(board.pins[name].chip_pin, dir="i"), inputs) for name in INPUTS]
    tied = [Resource("tied_high", k, Pins(pin, dir="o"), outputs) for k, pin in enumerate(board.tied_high)]
    platform.add_resources([Resource("trigger_generator", 0, *header), *tied])
    return platform


@final
class BoardTop(Elaboratable):
    """All that goes into the chip.

    Parameters
    ----------
    board
        One of `boards.BOARDS`; elaborate it with the platform that `make_platform` gives.
    """

    def __init__(self, board: Board) -> None:
        self._board = board

    def elaborate(self, platform: Any) -> Module:
        """What Amaranth asks for."""
        board = self._board
        m = Module()
        m.domains.sync = ClockDomain()
        m.submodules.clocking = Clocking(
            board.family,
            crystal=platform.request(board.crystal, dir="-"),
            crystal_hz=board.crystal_hz,
            clock_frequency_hz=board.clock_frequency_hz,
        )
        m.submodules.generator = generator = TriggerGenerator(clock_frequency_hz=board.clock_frequency_hz)
        uart = platform.request("uart", 0, dir={part.name: "-" for part in platform.lookup("uart", 0).ios})
        header = platform.request("trigger_generator", 0, dir=dict.fromkeys(OUTPUTS + INPUTS, "-"))
        for name in (*INPUTS, "rx"):
            port = uart.rx if name == "rx" else getattr(header, name)
            m.submodules[name] = buffer = io.Buffer("i", port)
            m.d.comb += getattr(generator, name).eq(buffer.i)
        for name in (*OUTPUTS, "tx"):
            port = uart.tx if name == "tx" else getattr(header, name)
            m.submodules[name] = buffer = io.Buffer("o", port)
            m.d.comb += buffer.o.eq(getattr(generator, name))
        for k in range(len(board.tied_high)):
            m.submodules[f"tied_high_{k}"] = tied = io.Buffer("o", platform.request("tied_high", k, dir="-"))
            m.d.comb += tied.o.eq(Const(1))
        return m
