"""`irtiming import-capture`: timestamps from a logic analyser, where there is no trigger generator."""

from pathlib import Path
from typing import Annotated

import typer

from irtiming.cli.options import ArrayBits, ArrayCamera, ArrayIntegration, ArrayReadout, filled, in_options
from irtiming.cli.screen import say
from irtiming.errors import ArchiveError, UnitError
from irtiming.units import seconds

_FACTS = ("camera", "readout", "wheel_hz", "integration_time", "trigger_delay_set", "bit_depth")
_SLOWEST_HZ, _FASTEST_HZ = 10**3, 10**12


@in_options
def import_capture(
    capture: Annotated[
        Path,
        typer.Argument(
            help="Value change dump (VCD), CSV, sigrok session (.sr), or folder of a Saleae raw binary export."
        ),
    ],
    line_map: Annotated[
        str,
        typer.Option(
            ...,
            "--map",
            metavar="STREAM=LINE,...",
            help="Line of each stream: camera_trigger, or camera_input for the strobe of a camera that runs free, control_slot, "
            "application_slot and, if wanted, application_edges, such as "
            "camera_trigger=D0,control_slot=!D1,application_slot=D2; '!' where the falling edge counts.",
        ),
    ],
    frames: Annotated[
        Path | None,
        typer.Option(
            help="Recording that the timestamps are for, or its frames, in any format that irtiming info knows."
        ),
    ] = None,
    out: Annotated[
        Path | None, typer.Option("--out", "-o", metavar="OUT", help="Recording to make of frames and timestamps.")
    ] = None,
    json: Annotated[Path | None, typer.Option("--json", metavar="OUT", help="Write the timestamps there.")] = None,
    clock: Annotated[
        str | None,
        typer.Option(
            metavar="FREQUENCY",
            help="Clock of the ticks, such as '24 MHz'. Else the sample rate of the analyser, or 1 GHz where the file does not "
            "tell it.",
        ),
    ] = None,
    shortest: Annotated[
        str, typer.Option(metavar="TIME", help="Levels that last less are glitches and left out, such as '1 us'.")
    ] = "0 s",
    delayed_trigger: Annotated[
        bool,
        typer.Option(
            "--delayed-trigger", help="The captured trigger comes after the set trigger delay, which is taken off."
        ),
    ] = False,
    camera: ArrayCamera = None,
    readout: ArrayReadout = None,
    wheel_hz: Annotated[float | None, typer.Option(help="Nominal wheel rate in Hz; for frames alone.")] = None,
    integration_time: ArrayIntegration = None,
    trigger_delay_set: Annotated[
        str | None,
        typer.Option(metavar="TIME", help="Extra trigger delay that was set; for frames alone."),
    ] = None,
    bit_depth: ArrayBits = None,
) -> None:
    """Take timestamps from a logic analyser's capture, and put them and the frames into a recording.

    The capture must hold both light gates and the camera trigger, or the strobe of a camera that runs free, since an
    analyser has its own clock. The file of the frames is left as it is. A capture in which data were lost is refused with
    the time of the loss.
    """
    given = locals()
    from irtiming.archive.captures.timed_recording import CameraFacts
    from irtiming.session.capture import CaptureOrder
    from irtiming.session.capture import import_capture as take_timestamps

    facts = None
    if any(given[name] is not None for name in _FACTS):
        if camera is None or wheel_hz is None:
            raise ArchiveError("--camera and --wheel-hz belong together; give both for frames alone")
        facts = filled(
            CameraFacts,
            given,
            camera_type=camera,
            readout_mode=readout,
            rotation_speed_hz=wheel_hz,
            trigger_delay_time_set_s=seconds(trigger_delay_set or "0 s"),
        )
    order = filled(CaptureOrder, given, lines=line_map, facts=facts, clock_hz=_clock(clock), is_delayed=delayed_trigger)
    found = take_timestamps(order)
    ticks = found.ticks
    counts = ", ".join(f"{values.size} of {field.name}" for field, values in ticks.streams.items())
    say(f"{' and '.join(map(str, order.places))}: {counts}, in ticks of {ticks.clock_frequency_hz} Hz")
    for finding in found.findings:
        say(f"warning: {finding.sentence()}")


def _clock(text: str | None) -> int | None:
    from irtiming.archive.captures.capture import hertz

    if text is None:
        return None
    rate = hertz(text)
    if rate is None or not _SLOWEST_HZ <= rate <= _FASTEST_HZ:
        raise UnitError(
            f"--clock '{text}' is no clock; write whole hertz from 1 kHz to 1 THz, such as '24 MHz' or '49152000 Hz'"
        )
    return rate
