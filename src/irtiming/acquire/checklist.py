"""Whether a series can begin: every complaint at once, before anything moves or heats."""

import os
import shutil
from collections.abc import AsyncIterator, Iterator
from fractions import Fraction
from pathlib import Path

from irtiming.acquire import frame_rate
from irtiming.acquire.journal import Journal
from irtiming.acquire.rig import Rig
from irtiming.acquire.series import Series, features_of
from irtiming.archive.reference_file import read_reference
from irtiming.errors import ArchiveError, InstrumentError
from irtiming.records.camera_settings import EXPOSURES
from irtiming.records.series_plan import SeriesPlan
from irtiming.units import readable_time

_BYTES_PER_PIXEL = 2
_MOST_SAVED = 0.5
"""Noise of a camera compresses to about half; less than that is not to be hoped for."""

_BLADES_WITH_CONTROL_SLOTS = ("MC1F2",)
_INNER = "external-inner"


async def complaints(rig: Rig, series: Series, *, journal: Journal) -> list[str]:
    """All that stands against beginning; empty if nothing does. Nothing is set, moved or heated.

    Parameters
    ----------
    rig
        Connected.
    series
        What is to be made.
    journal
        Of the folder: runs that are complete are not asked about.
    """
    found = [text async for text in _of_camera(rig, series.plan, series)]
    found += [text async for text in _of_chopper(rig, series)]
    found += [text async for text in _of_blackbody(rig)]
    found += list(_of_clock(rig, series))
    found += list(_of_folder(series.folder))
    if not found:
        found += [text async for text in _of_disk(rig, series, journal=journal)]
    if series.plan.references is not None and series.plan.references.file:
        try:
            read_reference(series.plan.references.file)
        except ArchiveError as error:
            found.append(str(error))
    return found


def _of_clock(rig: Rig, series: Series) -> Iterator[str]:
    planned, clock = series.triggers.clock_frequency_hz, rig.generator.clock_frequency_hz
    if planned != clock:
        yield (
            f"the plan is for a clock of {planned} Hz, the trigger generator at {rig.generator.name} has {clock} Hz; "
            f"plan again with irtiming plan --clock-hz {clock}"
        )


async def _of_camera(rig: Rig, plan: SeriesPlan, series: Series) -> AsyncIterator[str]:
    camera, wishes = rig.camera, plan.camera
    serial = camera.identity.serial_number
    if wishes.serial_number and serial != wishes.serial_number:
        yield (
            f"{camera.name} is number {serial or 'unknown'}, the plan is for {wishes.serial_number}; connect that "
            "one, or correct serial_number"
        )
    for name, _ in features_of(plan):
        try:
            await camera.feature(name)
        except InstrumentError as error:
            yield f"{error}; correct [camera]"
    beside = [f"{name} = {value}" for name, value in wishes.features if name in EXPOSURES]
    if beside and wishes.integration_time_s is not None:
        yield (
            f"the plan's integration_time is {readable_time(wishes.integration_time_s)}, and {beside[0]} (µs) is to be set "
            "beside it; say it once: leave one of the two out"
        )
    clock = series.triggers.clock_frequency_hz
    delayed = [run.trigger_delay_ticks for run in series.triggers if run.trigger_delay_ticks]
    if wishes.runs_free and delayed:
        yield (
            f"[camera] frame_event is '{wishes.frame_event}', and a delay of {readable_time(max(delayed) / clock)} is planned; a "
            "camera that runs free knows none: leave delays out"
        )
    shortest_s, window_s = series.triggers.shortest_period_s, wishes.integration_time_s or 0.0
    if window_s >= shortest_s:
        yield (
            f"the integration time is {readable_time(window_s)}, the camera is triggered every "
            f"{readable_time(shortest_s)}; integrate shorter, or plan a lower frame rate"
        )
    is_set = await frame_rate.is_set(camera, dict(features_of(plan)))  # else the series asks when it has set the camera
    if is_set and (slow := await frame_rate.complaint(camera, series.triggers)) is not None:
        yield slow


async def _of_chopper(rig: Rig, series: Series) -> AsyncIterator[str]:
    if rig.chopper is None:
        return
    try:
        state = await rig.chopper.state()
    except InstrumentError as error:
        yield str(error)
        return
    slots = sorted({run.scheme.control_slots for run in series.triggers})
    if state.blade not in _BLADES_WITH_CONTROL_SLOTS:
        yield (
            f"{rig.chopper.name} is set to blade {state.blade}; a wheel with two cutouts and a ring of control slots is "
            f"{' or '.join(_BLADES_WITH_CONTROL_SLOTS)}: mount it and set it at the controller"
        )
    if not state.is_enabled:
        return
    if state.reference != _INNER:
        yield (
            f"{rig.chopper.name} turns on its reference {state.reference}, it must follow {_INNER}; stop the wheel, "
            "and it will be set"
        )
    if (state.harmonic_multiplier, state.harmonic_divider) != (1, 1):
        yield (
            f"{rig.chopper.name} turns at {state.harmonic_multiplier}/{state.harmonic_divider} of its reference, it "
            f"must follow its {slots[0]} control slots one to one; stop the wheel, and it will be set"
        )


async def _of_blackbody(rig: Rig) -> AsyncIterator[str]:
    if rig.blackbody is None:
        return
    try:
        await rig.blackbody.state()
    except InstrumentError as error:
        yield str(error)


def _of_folder(folder: Path) -> Iterator[str]:
    place = folder if folder.exists() else folder.parent
    if folder.exists() and not folder.is_dir():
        yield f"{folder}: is a file; name a folder with --out"
    elif not place.is_dir():
        yield f"{folder}: there is no folder {place}; make it first"
    elif not os.access(place, os.W_OK | os.X_OK):
        yield f"{place}: may not be written to; give yourself permission, or name another folder with --out"


async def _of_disk(rig: Rig, series: Series, *, journal: Journal) -> AsyncIterator[str]:
    planned = dict(features_of(series.plan))
    try:
        width, height = [planned.get(name) or await rig.camera.feature(name) for name in ("Width", "Height")]
        pixels = int(float(width)) * int(float(height))
    except (InstrumentError, ValueError) as error:
        yield f"{rig.camera.name} does not report the size of its frames ({error}); check the camera"
        return
    runs = series.to_make(journal)
    n_frames = sum(one.run.scheme.samples_per_turn * one.run.repeats for one in runs)
    references = series.plan.references
    if references is not None:
        n_frames += 2 * references.frames * (len(runs) + 2)
    needed = Fraction(n_frames * pixels * _BYTES_PER_PIXEL) * Fraction(_MOST_SAVED)
    place = series.folder if series.folder.exists() else series.folder.parent
    free = shutil.disk_usage(place).free
    if free < needed:
        yield (
            f"{place}: {free / 1e9:.3g} GB are free, {n_frames} frames need {float(needed) / 1e9:.3g} GB even if "
            "they compress well; make room, or name another disk with --out"
        )
