"""Analyse recordings, and simulate some to play with."""

from collections.abc import Collection, Iterable, Iterator
from pathlib import Path
from typing import Any, get_args

from irtiming import measurement
from irtiming.archive import reader, result_file, rig_file
from irtiming.errors import UnitError
from irtiming.interface.timing_result import TimingResult
from irtiming.interface.wishes import several, sorted_into
from irtiming.measurement import Extra, Progress
from irtiming.records.choices import Choices
from irtiming.records.recording import Recording
from irtiming.records.rig import Rig
from irtiming.records.words import require_word
from irtiming.report import result
from irtiming.session import simulation
from irtiming.session.simulation import CameraOrder, Simulated, SimulationOrder
from irtiming.twin.defects import Defects


def analyse(
    recordings: str | Path | Recording | Iterable[str | Path | Recording], rig: str | Path | Rig, *,
    choices: Choices | None = None, extras: Collection[Extra] = (), progress: Progress | None = None, maps: bool = False,
) -> TimingResult:  # fmt: skip
    """Timing of a camera from its recordings.

    Parameters
    ----------
    recordings
        Files, or what `open_recording` gave; one, or several of one camera on one rig.
    rig
        rig.toml, or what `read_rig` gave.
    choices
        What to decide by hand; left out, everything is chosen automatically.
    extras
        What to make beside the estimate: ``"published"``, ``"profiles"``, ``"prediction"``, ``"diagnosis"``, ``"maps"``.
    progress
        Called with the recording's name, frames done and frames in all.
    maps
        Whether to make maps of every pixel, ``result.maps``; the same as ``"maps"`` among the extras.

    Raises
    ------
    IrTimingError
        If a file cannot be read, an extra is not known, or the data do not determine the timing.
    """
    for extra in extras:
        require_word("extras", extra, known=get_args(Extra), error=UnitError)
    several = [recordings] if isinstance(recordings, str | Path | Recording) else recordings
    measured = rig if isinstance(rig, Rig) else rig_file.read_rig(Path(rig))
    chosen = choices or Choices()
    asked: Collection[Extra] = {*extras, "maps"} if maps else extras
    found = measurement.analyse(_opened(several, chosen), measured, choices=chosen, progress=progress, extras=asked)
    return TimingResult(result_file.checked_result(result.result(found)), analysis=found)


def _opened(recordings: Iterable[str | Path | Recording], choices: Choices) -> Iterator[Recording]:
    """One after the other; a choice that means nothing for its kind of camera is refused."""
    for one in recordings:
        recording = one if isinstance(one, Recording) else reader.read(one)
        choices.check_for(recording)
        yield recording


_SEVERAL = ("delay_s", "wheel_hz", "blackbody_temperature_k")
_UNITS = {"_s": "s", "_hz": "Hz", "_k": "K", "_m": "m", "_rad": "rad", "_px": "px"}


def _measured(name: str, value: Any) -> Any:
    """A number as it is, one alone where there may be several as that one; text is for the command line."""
    unit = next((unit for end, unit in _UNITS.items() if name.endswith(end)), None)
    if unit is not None and any(isinstance(one, str) for one in several(value)):
        raise UnitError(f"{name} is {value!r}; it must be a number, in {unit}")
    return several(value) if name in _SEVERAL else value


def simulate(folder: str | Path, *, progress: Progress | None = None, **wishes: Any) -> Simulated:
    """Recordings of a simulated camera on a simulated rig, with rig.toml and truth.json beside them.

    Parameters
    ----------
    folder
        For the files; made if it is not there.
    progress
        Called with the folder, frames done and frames in all.
    wishes
        Fields of `SimulationOrder`, `CameraOrder` and `Defects`, by name: ``camera="microbolometer"``, ``frames=400``,
        ``delay_s=(0.0, 0.025)``, ``seed=3``; the rest is as usual, or drawn by the seed.

    Returns
    -------
    Paths of the ``recordings``, of ``rig`` and of ``truth``.

    Raises
    ------
    IrTimingError
        If a wish is not known, this camera or rig cannot be, or a file cannot be written.
    """
    wishes = {name: _measured(name, value) for name, value in wishes.items()}
    of_camera, of_order, of_defects = sorted_into(wishes, CameraOrder, SimulationOrder, Defects)
    own: dict[str, Any] = {"camera": CameraOrder(**of_camera), "defects": Defects(**of_defects)} | of_order
    order = SimulationOrder(folder=Path(folder), **{"asked": frozenset(wishes)} | own)
    return simulation.simulate(order, progress=progress)
