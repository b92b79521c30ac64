"""What the proofs share: the circuit itself with its inner registers in sight, and the same with a deliberate fault."""

from collections.abc import Mapping
from dataclasses import dataclass
from importlib import import_module
from inspect import getsource
from types import ModuleType
from typing import Any, TypeAlias, final

from amaranth.hdl import Assert, Assume, ClockDomain, Cover, Elaboratable, Fragment, Module, Signal, Value

from irtiming.errors import GatewareError

Parts: TypeAlias = Mapping[str, ModuleType]
"""Modules of the circuit by their names."""

_MODULES = (
    "edge_timestamper",
    "pulse_generator",
    "timestamp_queue",
    "serial_link",
    "register_file",
    "trigger_generator",
)


@final
@dataclass(frozen=True)
class Fault:
    """A change of the circuit's source that breaks it: a proof that still passes proves nothing."""

    module: str
    right: str
    wrong: str


def circuit(fault: Fault | None = None) -> Parts:
    """Fresh copies of the circuit's modules, so that a bench may put something else in the place of a part.

    Parameters
    ----------
    fault
        To put into one of them; none if None.

    Returns
    -------
    The modules, made from the source of the real ones.

    Raises
    ------
    GatewareError
        If the source does not hold the line that the fault changes.
    """
    copies: dict[str, ModuleType] = {}
    for name in _MODULES:
        module = import_module(f"irtiming.gateware.{name}")
        source = getsource(module)
        if fault is not None and name == fault.module:
            if source.count(fault.right) != 1:
                raise GatewareError(
                    f"{name}.py holds {fault.right!r} {source.count(fault.right)} times, not once; mend the fault"
                )
            source = source.replace(fault.right, fault.wrong)
        copy = ModuleType(module.__name__)
        exec(compile(source, f"copy of {name}.py", "exec"), vars(copy))
        for other in copies.values():
            own = {key for key, value in vars(other).items() if getattr(value, "__module__", "") == other.__name__}
            vars(copy).update({key: getattr(other, key) for key in own & vars(copy).keys()})
        copies[name] = copy
    return copies


def elaborated(part: Any) -> Module:
    """One step of elaboration: the module of a part, whose ``submodules`` a bench can reach.

    Parameters
    ----------
    part
        A component of the circuit.

    Returns
    -------
    Its module, to be added to the bench by `opened`.
    """
    part._MustUse__used = True  # Amaranth warns of parts that are never elaborated, and does not see this
    module: Module = part.elaborate(None)
    return module


def opened(part: Elaboratable) -> Fragment:
    """A part of the circuit as it is, elaborated to the end.

    Parameters
    ----------
    part
        A component, or its module.

    Returns
    -------
    What to add to the bench in place of the part.
    """
    return Fragment.get(part, None)


def inner_signals(fragment: Fragment) -> dict[str, Signal]:
    """Registers and other signals that a part drives, by their names.

    Parameters
    ----------
    fragment
        From `opened`, or a part of one (``fragment.find_subfragment(name)``).

    Returns
    -------
    Signals of this part, those of parts within it left out.
    """
    statements = [statement for of_domain in fragment.statements.values() for statement in of_domain]
    return {signal.name: signal for statement in statements for signal in statement._lhs_signals()}


class Bench(Elaboratable):
    """The circuit, what is assumed of its inputs, and what is claimed of it.

    The domain "sync" has no reset: the first cycle is the one after reset. Claims hold in every cycle.
    """

    def __init__(self) -> None:
        self.m = Module()
        self.m.domains.sync = self.domain = ClockDomain(reset_less=True)

    def elaborate(self, platform: object) -> Module:
        """What Amaranth asks for."""
        return self.m

    def assume(self, condition: Any) -> None:
        """Only such inputs come."""
        self.m.d.comb += Assume(condition)

    def claim(self, condition: Any) -> None:
        """To be proved. Relations between circuit and bench that carry an induction are claims too."""
        self.m.d.comb += Assert(condition)

    def cover(self, condition: Any) -> None:
        """To be reached: else a claim may hold because nothing ever happens."""
        self.m.d.comb += Cover(condition)

    def then(self, value: Any, name: str, *, init: int = 0) -> Signal:
        """What this value was in the cycle before; ``init`` in the first cycle."""
        before = Signal(Value.cast(value).shape(), name=f"{name}_then", init=init)
        self.m.d.sync += before.eq(value)
        return before

    def age(self, begins: Any, *, cycles: int) -> Signal:
        """Cycles since ``begins`` was high, from 1 to ``cycles``; 0 where that is longer ago."""
        age = Signal(range(cycles + 1))
        with self.m.If(begins):
            self.m.d.sync += age.eq(1)
        with self.m.Elif(age == cycles):
            self.m.d.sync += age.eq(0)
        with self.m.Elif(age != 0):
            self.m.d.sync += age.eq(age + 1)
        return age


def implies(condition: Any, consequence: Any) -> Value:
    """No consequence is asked for where the condition does not hold.

    Parameters
    ----------
    condition, consequence
        Of any width; true unless 0.

    Returns
    -------
    One bit.
    """
    return ~Value.cast(condition).any() | Value.cast(consequence).any()
