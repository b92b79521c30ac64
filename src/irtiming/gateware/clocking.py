"""From a board's crystal to the clock of the trigger generator: phase-locked loops, and a reset that waits for them.

Each loop keeps to the limits of its data sheet, with exact ratios: an error of the clock's rate would be one of every time.
"""

from dataclasses import dataclass
from typing import Any, final

from amaranth.hdl import ClockDomain, ClockSignal, Const, Elaboratable, Instance, Module, Signal, Value
from amaranth.lib import io
from amaranth.lib.cdc import FFSynchronizer, ResetSynchronizer

from irtiming.errors import GatewareError
from irtiming.gateware.boards import Family

RESET_CYCLES = 8192
"""Of the clock, after the loop has locked: over 0.15 ms. The memories of an iCE40 need 3 us, a loop some more to settle."""


@final
@dataclass(frozen=True)
class _Loop:
    """A phase-locked loop: its output, whether it has locked, and what it is made of."""

    clock: Value
    is_locked: Value
    parts: tuple[Elaboratable, ...]


@final
class Clocking(Elaboratable):
    """Drives the domain "sync" from the crystal: its clock, and a reset that ends once that clock can be trusted.

    Parameters
    ----------
    family
        Of the chip.
    crystal
        The port of the crystal's pin.
    crystal_hz, clock_frequency_hz
        From, to.
    """

    def __init__(self, family: Family, *, crystal: io.PortLike, crystal_hz: int, clock_frequency_hz: int) -> None:
        self._ratio = (family, crystal_hz, clock_frequency_hz)
        self._crystal = crystal

    def elaborate(self, platform: object) -> Module:
        """What Amaranth asks for.

        Raises
        ------
        GatewareError
            If nothing on the chip makes that clock of that crystal.
        """
        if self._ratio not in _LOOPS:
            family, crystal_hz, clock_hz = self._ratio
            raise GatewareError(f"no settings make {clock_hz} Hz from {crystal_hz} Hz on a chip of the family {family}")
        loop = _LOOPS[self._ratio](self._crystal)
        m = Module()
        m.submodules += loop.parts
        m.domains.power_on = ClockDomain(reset_less=True, local=True)
        m.d.comb += [ClockSignal("sync").eq(loop.clock), ClockSignal("power_on").eq(loop.clock)]

        is_locked = Signal()
        waited = Signal(range(RESET_CYCLES + 1))
        is_ready = Signal()  # a register: what resets must not glitch
        m.submodules.lock = FFSynchronizer(loop.is_locked, is_locked, o_domain="power_on")
        m.d.power_on += is_ready.eq(waited == RESET_CYCLES)
        with m.If(~is_locked):
            m.d.power_on += waited.eq(0)
        with m.Elif(waited != RESET_CYCLES):
            m.d.power_on += waited.eq(waited + 1)
        m.submodules.reset = ResetSynchronizer(~is_ready, domain="sync")
        return m


def _hx8k(crystal: io.PortLike) -> _Loop:
    buffer = io.Buffer("i", crystal)
    return _ice40("SB_PLL40_CORE", {"i_REFERENCECLK": buffer.i}, output_exponent=4, parts=(buffer,))


def _up5k(crystal: io.PortLike) -> _Loop:
    """Here the crystal's pin belongs to the loop, and its pad feeds it directly."""
    return _ice40("SB_PLL40_PAD", {"io_PACKAGEPIN": crystal.io}, output_exponent=5, parts=())


def _ice40(cell: str, source: dict[str, Any], *, output_exponent: int, parts: tuple[Elaboratable, ...]) -> _Loop:
    """12 MHz * 64 = 768 MHz (533..1066), divided by a power of two."""
    clock, is_locked = Signal(), Signal()
    loop = Instance(
        cell,
        **source,
        p_FEEDBACK_PATH="SIMPLE",
        p_DIVR=Const(0, 4),
        p_DIVF=Const(63, 7),
        p_DIVQ=Const(output_exponent, 3),
        p_FILTER_RANGE=Const(1, 3),
        i_RESETB=Const(1),
        i_BYPASS=Const(0),
        o_LOCK=is_locked,
        o_PLLOUTGLOBAL=clock,
    )
    return _Loop(clock, is_locked, (*parts, loop))


def _ulx3s(crystal: io.PortLike) -> _Loop:
    """25 -> 24 -> 48 MHz: one loop would have to compare at 5 MHz, and the data sheet wants 10 or more."""
    buffer = io.Buffer("i", crystal)
    middle, clock = Signal(), Signal()
    middle_is_locked, clock_is_locked = Signal(), Signal()
    first = _ecp5(buffer.i, clock=middle, locked=middle_is_locked, dividers=(1, 24, 25))
    second = _ecp5(middle, clock=clock, locked=clock_is_locked, dividers=(2, 10, 10))
    return _Loop(clock, middle_is_locked & clock_is_locked, (buffer, first, second))


def _ecp5(reference: Value, *, clock: Value, locked: Value, dividers: tuple[int, int, int]) -> Instance:
    """Dividers of feedback, of the oscillator's own output, of the output used.

    The oscillator runs at reference * first * second divider, 400 to 800 MHz.
    """
    of_feedback, of_first_output, of_second_output = dividers
    feedback = Signal()
    return Instance(
        "EHXPLLL",
        p_CLKI_DIV=1,
        p_CLKFB_DIV=of_feedback,
        p_FEEDBK_PATH="CLKOP",
        p_CLKOP_ENABLE="ENABLED",
        p_CLKOP_DIV=of_first_output,
        p_CLKOS_ENABLE="ENABLED",
        p_CLKOS_DIV=of_second_output,
        i_CLKI=reference,
        i_CLKFB=feedback,
        i_RST=Const(0),
        i_STDBY=Const(0),
        i_PHASESEL0=Const(0),
        i_PHASESEL1=Const(0),
        i_PHASEDIR=Const(0),
        i_PHASESTEP=Const(0),
        i_PHASELOADREG=Const(0),
        i_PLLWAKESYNC=Const(0),
        i_ENCLKOP=Const(0),
        i_ENCLKOS=Const(0),
        o_CLKOP=feedback,
        o_CLKOS=clock,
        o_LOCK=locked,
        a_ICP_CURRENT="12",
        a_LPF_RESISTOR="8",
        a_MFG_ENABLE_FILTEROPAMP="1",
        a_MFG_GMCREF_SEL="2",
    )


def _tang_nano_9k(crystal: io.PortLike) -> _Loop:
    """27 / 3 * 16 = 144 MHz from an oscillator at 576 MHz (400..1200), then by three. The comparison is at 9 MHz (3..400)."""
    buffer = io.Buffer("i", crystal)
    clock, is_locked = Signal(), Signal()
    loop = Instance(
        "rPLL",
        p_DEVICE="GW1NR-9C",
        p_FCLKIN="27",
        p_IDIV_SEL=2,
        p_FBDIV_SEL=15,
        p_ODIV_SEL=4,
        p_DYN_IDIV_SEL="false",
        p_DYN_FBDIV_SEL="false",
        p_DYN_ODIV_SEL="false",
        p_DYN_DA_EN="false",
        p_DYN_SDIV_SEL=2,
        p_PSDA_SEL="0000",
        p_DUTYDA_SEL="1000",
        p_CLKFB_SEL="internal",
        p_CLKOUT_BYPASS="false",
        p_CLKOUTP_BYPASS="false",
        p_CLKOUTD_BYPASS="false",
        p_CLKOUTD_SRC="CLKOUT",
        p_CLKOUTD3_SRC="CLKOUT",
        i_CLKIN=buffer.i,
        i_CLKFB=Const(0),
        i_RESET=Const(0),
        i_RESET_P=Const(0),
        i_IDSEL=Const(0, 6),
        i_FBDSEL=Const(0, 6),
        i_ODSEL=Const(0, 6),
        i_PSDA=Const(0, 4),
        i_DUTYDA=Const(0, 4),
        i_FDLY=Const(0, 4),
        o_CLKOUTD3=clock,
        o_LOCK=is_locked,
    )
    return _Loop(clock, is_locked, (buffer, loop))


_LOOPS = {
    ("ice40", 12_000_000, 48_000_000): _hx8k,
    ("ice40", 12_000_000, 24_000_000): _up5k,
    ("ecp5", 25_000_000, 48_000_000): _ulx3s,
    ("gowin", 27_000_000, 48_000_000): _tang_nano_9k,
}
