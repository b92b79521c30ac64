"""Measure the timing of a thermal infrared camera with a chopper wheel and a blackbody.

From a file to a delay with its uncertainty::

    import irtiming

    result = irtiming.analyse(["run1.nxs", "run2.nxs"], "rig.toml")
    delay = result["trigger_delay"]
    print(delay.value, delay.u, delay.expanded(0.95))
"""

from importlib import import_module
from types import ModuleType
from typing import TYPE_CHECKING, Any

from irtiming import plan as _folder_of_planning
from irtiming.errors import IrTimingError

if TYPE_CHECKING:
    from irtiming.interface.files import open_frames, open_recording, read_result, read_rig
    from irtiming.interface.measuring import analyse, simulate
    from irtiming.interface.planning import plan
    from irtiming.records.choices import Choices

__all__ = [
    "Choices",
    "IrTimingError",
    "analyse",
    "open_frames",
    "open_recording",
    "plan",
    "read_result",
    "read_rig",
    "simulate",
]

_HOMES = {
    "Choices": "irtiming.records.choices",
    "analyse": "irtiming.interface.measuring",
    "open_frames": "irtiming.interface.files",
    "open_recording": "irtiming.interface.files",
    "read_result": "irtiming.interface.files",
    "read_rig": "irtiming.interface.files",
    "simulate": "irtiming.interface.measuring",
}
"""Where each name lives; it is loaded when it is asked for, since numerical libraries take a second."""


class _Planning(ModuleType):
    """The folder of that name, which can be called: ``irtiming.plan(...)``, and ``from irtiming.plan import search``."""

    def __call__(self, **wishes: Any) -> Any:
        return import_module("irtiming.interface.planning").plan(**wishes)

    @property
    def __doc__(self) -> str | None:  # type: ignore[override]
        return import_module("irtiming.interface.planning").plan.__doc__


_folder_of_planning.__class__ = _Planning


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'irtiming' has no attribute '{name}'")
    return getattr(import_module(_HOMES[name]), name)


def __dir__() -> list[str]:
    return __all__
