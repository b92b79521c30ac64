"""Recordings of many cameras on one rig: looked at, put together by camera and setting, analysed on workers, made one table."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import final

from irtiming.archive import reader
from irtiming.archive.checksum import sha256_of
from irtiming.archive.json_file import make_folder
from irtiming.archive.limits_file import LimitsFile
from irtiming.archive.result_model import Result
from irtiming.archive.rig_file import read_rig
from irtiming.archive.wheel_calibration_file import read_wheel_calibration, write_wheel_calibration
from irtiming.distribute import lines
from irtiming.distribute.pieces import Seen, Unit, analysed, look
from irtiming.distribute.state import State, key_of
from irtiming.distribute.workers import Failed, Workers, workers
from irtiming.errors import ArchiveError, IrTimingError
from irtiming.estimate.series import gauge
from irtiming.estimate.series.points import point
from irtiming.records.campaign import Broken, Campaign, CampaignPoint, Listed
from irtiming.records.rig import Rig
from irtiming.reduce.wheel import wheel_calibration

WHEEL = "wheel.json"
_MOST_FOR_WHEEL = 12
"""Recordings that calibrate the wheel; more tell hardly more."""

Progress = Callable[[str, int, int], None]


@final
@dataclass(frozen=True, kw_only=True)
class CampaignOrder:
    """What is to be measured: recordings, the rig's numbers, and the folder of all that is found.

    A ``wheel_calibration`` stands in place of that which is made of the recordings. ``scheduler`` and ``n_workers`` are as for
    `workers`.
    """

    recordings: tuple[Listed, ...]
    rig: Path
    folder: Path
    limits: LimitsFile
    wheel_calibration: Path | None = None
    scheduler: str | None = None
    n_workers: int | None = None


@final
@dataclass(frozen=True, kw_only=True)
class Measured:
    """The campaign, and each result behind it with its file."""

    campaign: Campaign
    results: tuple[tuple[Path, CampaignPoint, Result], ...]


@final
@dataclass(frozen=True, kw_only=True)
class _Work:
    """Units by name, with what is known of each."""

    units: dict[str, tuple[Seen, ...]]
    wheel: Path | None


def measure(order: CampaignOrder, *, progress: Progress = lambda name, done, total: None) -> Measured:
    """Do what is missing, and put together all that is there.

    Parameters
    ----------
    order
        Its folder may hold what was done before.
    progress
        Called as recordings are looked at and units are analysed.

    Raises
    ------
    IrTimingError
        If the rig or the wheel cannot be read, no workers can be had, or nothing at all could be analysed.
    """
    make_folder(order.folder)
    rig_sha256 = read_rig(order.rig).sha256 or sha256_of(order.rig)
    state, broken = State(order.folder), list[Broken]()
    with workers(scheduler=order.scheduler, n_workers=order.n_workers) as pool:
        read = _looked_at(pool, order, broken, progress)
        wheel = _wheel(order, read, rig_sha256=rig_sha256)
        wheel_sha256 = "" if wheel is None else sha256_of(wheel)
        units = {key_of(unit, rig_sha256=rig_sha256, wheel_sha256=wheel_sha256): unit for unit in together(read)}
        _do_missing(pool, _Work(units=units, wheel=wheel), order=order, state=state, progress=progress, broken=broken)
    found = list(_results(units, state, broken))
    if not found:
        first = broken[0].what if broken else "no recording was given"
        raise ArchiveError(f"nothing could be analysed; the first of {len(broken)} complaints: {first}")
    points = tuple(one for _, one, _ in found)
    studies, left_out = gauge.studies(points)
    campaign = Campaign(
        points=points, lines=lines.of(points, order.limits), broken=tuple(sorted(broken, key=lambda one: one.files)),
        studies=studies, rule=order.limits.rule_in_words, left_out_of_study=left_out,
        limits_of_none=_limits_of_none(order, points),
    )  # fmt: skip
    return Measured(campaign=campaign, results=tuple(found))


def _limits_of_none(order: CampaignOrder, points: Sequence[CampaignPoint]) -> tuple[str, ...]:
    """Cameras that have limits of their own, and no result that they count for."""
    there = {one.point.camera.serial_number for one in points}
    limited = [one.serial_number for one in order.limits.limit if one.serial_number is not None]
    return tuple(dict.fromkeys(serial for serial in limited if serial not in there))


def _looked_at(pool: Workers, order: CampaignOrder, broken: list[Broken], progress: Progress) -> list[Seen]:
    """Every recording that can be read, in the order of the list; each once."""
    found: dict[str, Seen] = {}
    pieces = {str(one.path): one for one in order.recordings}
    for done, (name, outcome) in enumerate(pool.each(look, pieces), 1):
        if isinstance(outcome, Failed):
            broken.append(Broken(files=(name,), what=outcome.what))
        else:
            found[name] = outcome
        progress("recordings looked at", done, len(pieces))
    kept: dict[str, Seen] = {}
    for one in (found[name] for name in pieces if name in found):
        if one.sha256 in kept:
            same = kept[one.sha256].listed.path
            what = (
                f"{one.listed.path}: is the same recording as {same}; counted twice it makes u too small: leave one out"
            )
            broken.append(Broken(files=(str(one.listed.path),), what=what))
        else:
            kept[one.sha256] = one
    return list(kept.values())


def together(read: Sequence[Seen]) -> list[tuple[Seen, ...]]:
    """Recordings of one camera at one setting, of one operator and run."""
    groups: dict[tuple[object, ...], list[list[Seen]]] = {}
    for one in read:
        same_camera = groups.setdefault((one.camera, one.listed.operator, one.listed.run), [])
        mine = next((group for group in same_camera if group[0].goes_with(one)), None)
        same_camera.append([one]) if mine is None else mine.append(one)
    return [tuple(group) for each in groups.values() for group in each]


def _wheel(order: CampaignOrder, read: Sequence[Seen], *, rig_sha256: str) -> Path | None:
    """The wheel's calibration, made once: later recordings do not change it, a changed rig.toml does."""
    if order.wheel_calibration is not None:
        read_wheel_calibration(order.wheel_calibration)
        return order.wheel_calibration
    path = order.folder / f"{rig_sha256[:12]}-{WHEEL}"
    if path.exists():
        return path
    by_speed = sorted(read, key=lambda one: (one.wheel_hz, one.sha256))
    chosen = by_speed[:: max(1, -(-len(by_speed) // _MOST_FOR_WHEEL))]
    rig = read_rig(order.rig)
    sound = [one.listed.path for one in chosen if _tells_of_the_wheel(one.listed.path, rig)]
    if not sound:
        return None  # each unit then learns the slots from its own recordings, as an analysis by itself does
    found = wheel_calibration.from_recordings((reader.read(path) for path in sound), rig)
    write_wheel_calibration(found, path)
    return path


def _tells_of_the_wheel(path: Path, rig: Rig) -> bool:
    """Whether the slots can be learned from a recording: one that has lost timestamps must not spoil the others."""
    try:
        wheel_calibration.from_recordings([reader.read(path)], rig)
    except IrTimingError:
        return False
    return True


def _do_missing(
    pool: Workers, work: _Work, *, order: CampaignOrder, state: State, progress: Progress, broken: list[Broken]
) -> None:
    missing = {
        key: Unit(recordings=tuple(one.listed.path for one in unit), rig=order.rig, wheel=work.wheel)
        for key, unit in work.units.items()
        if state.result(key) is None and state.refusal(key) is None
    }
    n_before = len(work.units) - len(missing)
    progress("cameras and settings analysed", n_before, len(work.units))
    for done, (key, outcome) in enumerate(pool.each(analysed, missing), 1):
        if not isinstance(outcome, Failed):
            state.keep(key, outcome)
        elif outcome.is_lasting:
            state.keep_refusal(key, outcome.what)
        else:
            files = tuple(str(one.listed.path) for one in work.units[key])
            broken.append(Broken(files=files, what=outcome.what))
        progress("cameras and settings analysed", n_before + done, len(work.units))


def _results(
    units: dict[str, tuple[Seen, ...]], state: State, broken: list[Broken]
) -> Iterator[tuple[Path, CampaignPoint, Result]]:
    """Every unit that is done, in order of serial number; each camera by the name that it was listed with."""
    for key in sorted(units):
        unit, files = units[key], tuple(str(one.listed.path) for one in units[key])
        refused, result = state.refusal(key), state.result(key)
        if result is None:
            if refused is not None:
                broken.append(Broken(files=files, what=refused))
            continue
        try:
            found = point(result, label=key)
        except IrTimingError as error:
            broken.append(Broken(files=files, what=str(error)))
            continue
        listed = unit[0].listed
        found = replace(found, camera=unit[0].camera)
        yield state.path_of(key), CampaignPoint(point=found, operator=listed.operator, run=listed.run), result
