"""The FPGA boards that the trigger generator is built for: crystal, clock, pins. Plain facts, no Amaranth.

The pins sit side by side on one header where the board allows it. All of them are at 3.3 V.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Literal, final

from irtiming.errors import GatewareError

INPUTS = ("camera_in", "control_in", "application_in", "spare_in")
OUTPUTS = ("chopper_out", "camera_out")

Family = Literal["ice40", "ecp5", "gowin"]
"""Of chips: what their tools are called after."""


@final
@dataclass(frozen=True, kw_only=True)
class HeaderPin:
    """Where a signal leaves the board: what is printed beside the pin, and the pin of the chip behind it."""

    label: str
    chip_pin: str


@final
@dataclass(frozen=True, kw_only=True)
class Board:
    """One board.

    ``platform`` names the class in ``amaranth_boards`` that knows its crystal and serial line. The seed decides how place and
    route begins: with the same seed, source and tools, the same bits come out.
    """

    name: str
    title: str
    family: Family
    platform: tuple[str, str]  # module, class
    crystal: str  # as the platform calls it
    crystal_hz: int
    clock_frequency_hz: int
    header: str
    pins: Mapping[str, HeaderPin]
    tied_high: tuple[str, ...] = ()  # pins of the chip that must not float
    seed: int = 1


def _row(labels: str, chip_pins: str) -> dict[str, HeaderPin]:
    """Outputs first, then inputs, in the order of a header."""
    pairs = zip(labels.split(), chip_pins.split(), strict=True)
    return {
        signal: HeaderPin(label=label, chip_pin=pin)
        for signal, (label, pin) in zip(OUTPUTS + INPUTS, pairs, strict=True)
    }


BOARDS: tuple[Board, ...] = (
    Board(
        name="hx8k-b-evn",
        title="Lattice iCE40-HX8K breakout board",
        family="ice40",
        platform=("ice40_hx8k_b_evn", "ICE40HX8KBEVNPlatform"),
        crystal="clk12",
        crystal_hz=12_000_000,
        clock_frequency_hz=48_000_000,
        header="J2",
        pins=_row("25 26 27 28 29 30", "H16 G15 G16 F15 F16 E14"),
    ),
    Board(
        name="ulx3s",
        title="Radiona ULX3S with LFE5U-25F",
        family="ecp5",
        platform=("ulx3s", "ULX3S_25F_Platform"),
        crystal="clk25",
        crystal_hz=25_000_000,
        clock_frequency_hz=48_000_000,
        header="J1",
        pins=_row("GP0 GP1 GP2 GP3 GP4 GP5", "B11 A10 A9 B9 A7 C8"),
        tied_high=("L2",),  # GPIO0 of the ESP32: pulled low, it takes the board over
    ),
    Board(
        name="tang-nano-9k",
        title="Sipeed Tang Nano 9K",
        family="gowin",
        platform=("tang_nano_9k", "TangNano9kPlatform"),
        crystal="clk27",
        crystal_hz=27_000_000,
        clock_frequency_hz=48_000_000,
        header="row of 25 to 30",
        pins=_row("25 26 27 28 29 30", "25 26 27 28 29 30"),
    ),
    Board(
        name="icebreaker",
        title="1BitSquared iCEBreaker",
        family="ice40",
        platform=("icebreaker", "ICEBreakerPlatform"),
        crystal="clk12",
        crystal_hz=12_000_000,
        clock_frequency_hz=24_000_000,
        header="PMOD 1A",
        pins=_row("1 2 3 4 7 8", "4 2 47 45 3 48"),
    ),
)


def find_board(name: str) -> Board:
    """The board of this name.

    Parameters
    ----------
    name
        As in `BOARDS`.

    Returns
    -------
    The board.

    Raises
    ------
    GatewareError
        If there is none.
    """
    for board in BOARDS:
        if board.name == name:
            return board
    raise GatewareError(f"no board is called {name!r}; use one of {', '.join(board.name for board in BOARDS)}")
