"""`irtiming plan`: from wishes to the trigger schemes that meet them, as a table, a drawing and JSON."""

from collections.abc import Iterator
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from irtiming.cli.camera_options import CameraKind, Described
from irtiming.errors import PlanError

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table

    from irtiming.plan.search import Option, Options
    from irtiming.records.trigger_plan import TriggerPlan, Wish, Wishes

MOST_IN_FILE = 10_000
"""Options that the JSON file lists at most; ``n_options`` in it says how many there are."""

PAPER = {"--clock-hz": "49152000", "--frame-hz": "30.303", "--samples": "1000"}
"""Schatz 2023, section 2.3: what --for takes where nothing is given."""

USUAL_SPEEDS = ("2", "3", "4", "5", "6", "8", "10", "12", "15", "20", "25", "30", "40", "50")
"""Wheel speeds in Hz that --for chooses from where none is given."""

_DOUBLE = (Fraction(1, 2), Fraction(2))
"""Default limits of the samples per turn, relative, where an exact frame rate leaves little choice."""


def plan(
    wanted: Annotated[
        list[str] | None,
        typer.Option("--for", metavar="PARAMETER=U", help="What to know, and how well (k = 1): 'trigger_delay=0.5us'."),
    ] = None,
    clock_hz: Annotated[str | None, typer.Option(help="Frequency of the trigger generator's clock; whole Hz.")] = None,
    wheel_hz: Annotated[
        list[str] | None,
        typer.Option(help="Wheel rate in Hz; repeat it for several. With --for: those to choose from."),
    ] = None,
    frame_hz: Annotated[str | None, typer.Option(help="Frame rate in Hz: 30.303, or exactly 1000/33.")] = None,
    samples: Annotated[str | None, typer.Option(help="Samples per turn of the wheel.")] = None,
    frame_hz_exact: Annotated[bool, typer.Option("--frame-hz-exact", help="No other frame rate will do.")] = False,
    frame_hz_min: Annotated[str | None, typer.Option(help="Lowest frame rate of the camera in Hz.")] = None,
    frame_hz_max: Annotated[str | None, typer.Option(help="Highest frame rate of the camera in Hz.")] = None,
    samples_min: Annotated[str | None, typer.Option(help="Fewest samples; with an exact frame rate half.")] = None,
    samples_max: Annotated[str | None, typer.Option(help="Most samples; with an exact frame rate double.")] = None,
    tolerance: Annotated[str, typer.Option(help="Limits of every wish that has none of its own.")] = "1%",
    wheel_tolerance: Annotated[str | None, typer.Option(help="Tolerance of the wheel rate; 0 is exact.")] = None,
    control_slots: Annotated[str, typer.Option(help="Slots of the ring that controls the wheel.")] = "100",
    between_corrections: Annotated[
        str | None,
        typer.Option(help="Longest time between two non-uniformity corrections, such as '20 min'."),
    ] = None,
    delay: Annotated[list[str] | None, typer.Option(help="Extra trigger delay, such as '25 ms'; repeatable.")] = None,
    repeats: Annotated[str, typer.Option(help="Runs for each wheel speed and delay; --for finds them itself.")] = "1",
    rig: Annotated[Path | None, typer.Option(help="With --for: rig.toml, for the uncertainties of its angles.")] = None,
    camera: Annotated[CameraKind | None, typer.Option(help="With --for: kind of camera; photon if not given.")] = None,
    noise: Annotated[
        float | None, typer.Option(help="With --for: noise of a pixel in K, or in DN as --contrast.")
    ] = None,
    contrast: Annotated[float | None, typer.Option(help="With --for: blackbody minus wheel in K, or in DN.")] = None,
    opening_pixels: Annotated[float | None, typer.Option(help="With --for: pixels within the mask opening.")] = None,
    integration_time: Annotated[
        str | None, typer.Option(help="With --for: of a photon camera, such as '250 us'.")
    ] = None,
    known_integration_time: Annotated[
        bool, typer.Option("--known-integration-time", help="With --for: it is exact and need not be found.")
    ] = False,
    time_constant: Annotated[
        str | None, typer.Option(help="With --for: of a microbolometer, roughly, such as '5 ms'.")
    ] = None,
    like: Annotated[
        Path | None, typer.Option(metavar="RESULT", help="With --for: take the camera from this result JSON.")
    ] = None,
    most: Annotated[int, typer.Option(min=1, help="Rows of the table.")] = 10,
    json: Annotated[Path | None, typer.Option(help="Write all schemes and the plan to this file.")] = None,
    picture: Annotated[Path | None, typer.Option(help="Draw the sampling order of the best to this SVG.")] = None,
) -> None:
    """Find every trigger scheme that meets the wishes, best first.

    With --for: the shortest measurements that should reach an uncertainty, whatever wheel speeds and runs that takes. Clock,
    frame rate and samples are then those of the paper if not given, and the wheel may turn at 2 to 50 Hz.
    """
    from irtiming.cli.plan_json import write
    from irtiming.plan.drawing import sampling_svg
    from irtiming.plan.schedule import schedule
    from irtiming.plan.search import search
    from irtiming.plan.wishes import exact_seconds, ratio, whole_number
    from irtiming.records.trigger_plan import Wishes

    given = {"--clock-hz": clock_hz, "--wheel-hz": wheel_hz, "--frame-hz": frame_hz, "--samples": samples}
    described = Described(
        camera=camera, noise=noise, contrast=contrast, opening_pixels=opening_pixels, integration_time=integration_time,
        known_integration_time=known_integration_time, time_constant=time_constant, like=like, rig=rig,
    )  # fmt: skip
    _check_asked(bool(wanted), given, described=described, repeats=repeats)
    delays = delay or (["0 s", "25 ms"] if any("relative" in text for text in wanted or ()) else ["0 s"])
    share = ratio(tolerance, "the tolerance")
    wheel_share = share if wheel_tolerance is None else ratio(wheel_tolerance, "the wheel tolerance")
    around, around_wheel = (1 - share, 1 + share), (1 - wheel_share, 1 + wheel_share)
    wishes = Wishes(
        clock_frequency_hz=whole_number(clock_hz or PAPER["--clock-hz"], "the clock frequency in Hz"),
        wheel_rates_hz=tuple(
            _wish(text, (None, None), around_wheel, "the wheel rate") for text in wheel_hz or USUAL_SPEEDS
        ),
        frame_rate_hz=_wish(
            frame_hz or PAPER["--frame-hz"], (frame_hz_min, frame_hz_max), around, "the frame rate", frame_hz_exact
        ),
        samples_per_turn=_wish(
            samples or PAPER["--samples"],
            (samples_min, samples_max),
            _DOUBLE if frame_hz_exact else around,
            "samples per turn",
        ),
        control_slots=whole_number(control_slots, "the number of control slots"),
        longest_uninterrupted_s=None
        if between_corrections is None
        else exact_seconds(between_corrections, "the time between corrections"),
        trigger_delays_s=tuple(exact_seconds(text, "the trigger delay") for text in delays),
        repeats=whole_number(repeats, "the number of repeats"),
    )
    if wanted:
        from irtiming.cli.plan_for import plan_for

        plan_for(wanted, wishes, described=described, most=most, files=(json, picture))
        return
    options = search(wishes, most=most if json is None else max(most, MOST_IN_FILE))
    best = schedule(options.best[0].schemes, wishes)
    if json is not None:
        write(json, _as_json(options, best, wishes))
    if picture is not None:
        write(picture, sampling_svg(best.schemes[0], wishes.clock_frequency_hz))
    _show(options, best, wishes, most)


def _check_asked(wants: bool, given: dict[str, Any], *, described: Described, repeats: str) -> None:
    """Refuse what is missing without --for, and what makes no sense with or without it."""
    missing = [name for name, value in given.items() if not value and value != ""]
    if not wants and missing:
        raise PlanError(
            f"{', '.join(missing)} must be given; only with --for, such as --for 'trigger_delay=0.5us', are they found"
        )
    if not wants and described != Described():
        raise PlanError("camera and rig are described, but nothing is asked of them; add --for 'trigger_delay=0.5us'")
    if wants and repeats.strip() != "1":
        raise PlanError(f"--repeats {repeats} with --for, which finds the number of runs itself; leave one of them out")


def _wish(
    text: str,
    limits: tuple[str | None, str | None],
    factors: tuple[Fraction, Fraction],
    name: str,
    is_exact: bool = False,
) -> "Wish":
    from irtiming.plan.wishes import as_text, exact_number
    from irtiming.records.trigger_plan import Wish

    wanted = exact_number(text, name)
    lowest, highest = (
        wanted * factor if limit is None else exact_number(limit, f"the limit of {name}")
        for limit, factor in zip(limits, factors, strict=True)
    )
    if not lowest <= wanted <= highest:
        raise PlanError(
            f"{name} is {as_text(wanted)}, outside its limits {as_text(lowest)} .. {as_text(highest)}; "
            f"the nearest within is {as_text(lowest if wanted < lowest else highest)}"
        )
    return (
        Wish(wanted=wanted, lowest=wanted, highest=wanted)
        if is_exact
        else Wish(wanted=wanted, lowest=lowest, highest=highest)
    )


def _show(options: "Options", best: "TriggerPlan", wishes: "Wishes", most: int) -> None:
    from rich.console import Console

    from irtiming.plan.drawing import sampling_text

    console = Console(highlight=False)
    console.print(_table(options.best[:most], wishes.clock_frequency_hz))
    for line in _remarks(options, min(most, len(options.best)), wishes):
        console.print(line, markup=False)
    if len(best.runs) > 1 or best.runs[0].repeats > 1:
        show_runs(console, best)
    for scheme in best.schemes:
        console.print(f"\nSampling order of T = {scheme.turn_period_ticks}, C = {scheme.camera_period_ticks} ticks")
        console.print(sampling_text(scheme, turns=12 // len(best.schemes) + 1), markup=False, soft_wrap=True)


def _table(ranked: "tuple[Option, ...]", clock_frequency_hz: int) -> "Table":
    from rich import box
    from rich.table import Table

    from irtiming.plan import sampling
    from irtiming.plan.wishes import is_prime
    from irtiming.units import readable_time

    table = Table(title="Trigger schemes, best first", box=box.SIMPLE_HEAD, pad_edge=False, padding=(0, 1, 0, 0))
    for heading in ("", "T\nT'\n/ ticks", "C\ndelta\n/ ticks", "samples\nper turn\nper frame"):
        table.add_column(heading, justify="right", no_wrap=True)
    for heading in ("wheel / Hz\nexactly", "camera / Hz\nexactly", "run", "tolerance\nused"):
        table.add_column(heading, justify="right", overflow="fold")
    for rank, option in enumerate(ranked, 1):
        for scheme in option.schemes:
            prime = "prime " if is_prime(scheme.samples_per_turn) else ""
            table.add_row(
                str(rank),
                f"{scheme.turn_period_ticks}\n{scheme.control_slot_period_ticks}",
                f"{scheme.camera_period_ticks}\n{scheme.sampling_interval_ticks}",
                f"{prime}{scheme.samples_per_turn}\n{scheme.samples_per_frame}",
                _rate(sampling.wheel_rate_hz(scheme, clock_frequency_hz)),
                _rate(sampling.frame_rate_hz(scheme, clock_frequency_hz)),
                readable_time(float(sampling.run_duration_s(scheme, clock_frequency_hz))),
                f"{float(option.used_tolerance):.4f}",
            )
    return table


def _rate(rate_hz: Fraction) -> str:
    """Decimal above, exact below, where they differ."""
    from irtiming.plan.wishes import as_text

    decimal, exact = f"{float(rate_hz):.8g}", as_text(rate_hz)
    return decimal if decimal == exact else f"{decimal}\n{exact}"


def _remarks(options: "Options", shown: int, wishes: "Wishes") -> Iterator[str]:
    from irtiming.plan.search import MOST_COMPARED

    one = options.n_options == 1
    noun = f"admissible scheme{'' if one else 's'}"
    if len(options.n_schemes) > 1:
        noun = f"camera period{' serves' if one else 's serve'} all wheel speeds"
    if options.shares_camera_period:
        at_least = "" if options.is_complete else "at least "
        yield f"{at_least}{options.n_options} {noun}; {shown} shown."
    else:
        yield "No camera period serves all wheel speeds, so each has its own; wider limits may find one."
    if not options.is_complete:
        yield (
            f"Of {' + '.join(map(str, options.n_schemes))} schemes the best {MOST_COMPARED} of each "
            "wheel speed were compared; narrower limits compare all."
        )
    for delay_s in wishes.trigger_delays_s:
        if (delay_s * wishes.clock_frequency_hz).denominator != 1:
            yield f"A delay of {float(delay_s):g} s is not a whole number of ticks; the nearest is set."


def show_runs(console: "Console", best: "TriggerPlan") -> None:
    """Print the runs of a plan, in order, and how long they take."""
    from rich import box
    from rich.table import Table

    from irtiming.plan.schedule import plan_duration_s, run_length_ticks
    from irtiming.units import readable_time, ticks_to_seconds

    clock = best.clock_frequency_hz
    table = Table(title="Runs of the best, in order", box=box.SIMPLE_HEAD, pad_edge=False)
    for heading in (
        "run",
        "correction before",
        "wheel / Hz",
        "trigger delay",
        "delay / ticks",
        "repeats",
        "lasts",
    ):
        table.add_column(heading, justify="right")
    for number, run in enumerate(best, 1):
        length = run_length_ticks(run.scheme, repeats=run.repeats, trigger_delay_ticks=run.trigger_delay_ticks)
        table.add_row(
            str(number),
            "yes" if run.is_after_correction else "",
            f"{clock / run.scheme.turn_period_ticks:.6g}",
            readable_time(ticks_to_seconds(run.trigger_delay_ticks, clock)),
            str(run.trigger_delay_ticks),
            str(run.repeats),
            readable_time(ticks_to_seconds(length, clock)),
        )
    console.print(table)
    corrections = sum(run.is_after_correction for run in best)
    noun = "correction" if corrections == 1 else "corrections"
    console.print(f"{corrections} {noun}, {readable_time(float(plan_duration_s(best)))} of triggers in all.")


def _as_json(options: "Options", best: "TriggerPlan", wishes: "Wishes") -> dict[str, Any]:
    from irtiming.cli.plan_json import plan_as_json, scheme_as_json

    clock = wishes.clock_frequency_hz
    return {
        "clock_frequency_hz": clock,
        "n_options": options.n_options,
        "n_schemes": list(options.n_schemes),
        "is_complete": options.is_complete,
        "shares_camera_period": options.shares_camera_period,
        "schemes": [
            {"rank": rank, **scheme_as_json(scheme, clock), "used_tolerance": float(option.used_tolerance)}
            for rank, option in enumerate(options.best, 1)
            for scheme in option.schemes
        ],
        "plan": plan_as_json(best),
    }
