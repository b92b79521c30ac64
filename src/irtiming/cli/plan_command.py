"""`irtiming plan`: from wishes to the trigger schemes that meet them, as a table, a drawing and JSON."""

from collections.abc import Iterator
from fractions import Fraction
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

if TYPE_CHECKING:
    from rich.console import Console
    from rich.table import Table

    from irtiming.plan.search import Option, Options
    from irtiming.records.trigger_plan import TriggerPlan, TriggerScheme, Wish, Wishes

MOST_IN_FILE = 10_000
"""Options that the JSON file lists at most; ``n_options`` in it says how many there are."""

_DOUBLE = (Fraction(1, 2), Fraction(2))
"""Default limits of the samples per turn, relative, where an exact frame rate leaves little choice."""


def plan(
    clock_hz: Annotated[str, typer.Option(help="Frequency of the trigger generator's clock; whole Hz.")],
    wheel_hz: Annotated[list[str], typer.Option(help="Wheel rate in Hz; repeat it for several wheel speeds.")],
    frame_hz: Annotated[str, typer.Option(help="Frame rate in Hz: 30.303, or exactly 1000/33.")],
    samples: Annotated[str, typer.Option(help="Samples per turn of the wheel.")],
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
    repeats: Annotated[str, typer.Option(help="Runs for each wheel speed and delay.")] = "1",
    most: Annotated[int, typer.Option(min=1, help="Rows of the table.")] = 10,
    json: Annotated[Path | None, typer.Option(help="Write all schemes and the plan to this file.")] = None,
    picture: Annotated[Path | None, typer.Option(help="Draw the sampling order of the best to this SVG.")] = None,
) -> None:
    """Find every trigger scheme that meets the wishes, best first."""
    from irtiming.plan.drawing import sampling_svg
    from irtiming.plan.schedule import schedule
    from irtiming.plan.search import search
    from irtiming.plan.wishes import exact_seconds, ratio, whole_number
    from irtiming.records.trigger_plan import Wishes

    share = ratio(tolerance, "the tolerance")
    wheel_share = share if wheel_tolerance is None else ratio(wheel_tolerance, "the wheel tolerance")
    around, around_wheel = (1 - share, 1 + share), (1 - wheel_share, 1 + wheel_share)
    wishes = Wishes(
        clock_frequency_hz=whole_number(clock_hz, "the clock frequency in Hz"),
        wheel_rates_hz=tuple(_wish(text, (None, None), around_wheel, "the wheel rate") for text in wheel_hz),
        frame_rate_hz=_wish(frame_hz, (frame_hz_min, frame_hz_max), around, "the frame rate", frame_hz_exact),
        samples_per_turn=_wish(
            samples, (samples_min, samples_max), _DOUBLE if frame_hz_exact else around, "samples per turn"
        ),
        control_slots=whole_number(control_slots, "the number of control slots"),
        longest_uninterrupted_s=None
        if between_corrections is None
        else exact_seconds(between_corrections, "the time between corrections"),
        trigger_delays_s=tuple(exact_seconds(text, "the trigger delay") for text in delay or ["0 s"]),
        repeats=whole_number(repeats, "the number of repeats"),
    )
    options = search(wishes, most=most if json is None else max(most, MOST_IN_FILE))
    best = schedule(options.best[0].schemes, wishes)
    if json is not None:
        _write(json, _as_json(options, best, wishes))
    if picture is not None:
        _write(picture, sampling_svg(best.schemes[0], wishes.clock_frequency_hz))
    _show(options, best, wishes, most)


def _wish(
    text: str,
    limits: tuple[str | None, str | None],
    factors: tuple[Fraction, Fraction],
    name: str,
    is_exact: bool = False,
) -> "Wish":
    from irtiming.errors import PlanError
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
        _show_runs(console, best)
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


def _show_runs(console: "Console", best: "TriggerPlan") -> None:
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
    from irtiming.plan.sampling import sampling_order
    from irtiming.plan.schedule import plan_duration_s, run_length_ticks

    clock = wishes.clock_frequency_hz
    runs = [
        {
            "turn_period_ticks": run.scheme.turn_period_ticks,
            "camera_period_ticks": run.scheme.camera_period_ticks,
            "trigger_delay_ticks": run.trigger_delay_ticks,
            "trigger_delay_s": run.trigger_delay_ticks / clock,
            "repeats": run.repeats,
            "is_after_correction": run.is_after_correction,
            "duration_s": run_length_ticks(run.scheme, repeats=run.repeats, trigger_delay_ticks=run.trigger_delay_ticks)
            / clock,
        }
        for run in best
    ]
    return {
        "clock_frequency_hz": clock,
        "n_options": options.n_options,
        "n_schemes": list(options.n_schemes),
        "is_complete": options.is_complete,
        "shares_camera_period": options.shares_camera_period,
        "schemes": [
            {"rank": rank, **_scheme_as_json(scheme, clock), "used_tolerance": float(option.used_tolerance)}
            for rank, option in enumerate(options.best, 1)
            for scheme in option.schemes
        ],
        "plan": {
            "runs": runs,
            "duration_s": float(plan_duration_s(best)),
            "sampling_orders": [sampling_order(scheme).tolist() for scheme in best.schemes],
        },
    }


def _scheme_as_json(scheme: "TriggerScheme", clock_frequency_hz: int) -> dict[str, Any]:
    from irtiming.plan import sampling

    wheel = sampling.wheel_rate_hz(scheme, clock_frequency_hz)
    camera = sampling.frame_rate_hz(scheme, clock_frequency_hz)
    duration = sampling.run_duration_s(scheme, clock_frequency_hz)
    return {
        "turn_period_ticks": scheme.turn_period_ticks,
        "control_slot_period_ticks": scheme.control_slot_period_ticks,
        "camera_period_ticks": scheme.camera_period_ticks,
        "sampling_interval_ticks": scheme.sampling_interval_ticks,
        "samples_per_turn": scheme.samples_per_turn,
        "samples_per_frame": scheme.samples_per_frame,
        "control_slots": scheme.control_slots,
        "triggers_to_neighbour": sampling.triggers_to_neighbour(scheme),
        "wheel_rate_hz": float(wheel),
        "wheel_rate_hz_exact": str(wheel),
        "frame_rate_hz": float(camera),
        "frame_rate_hz_exact": str(camera),
        "run_duration_s": float(duration),
        "run_duration_s_exact": str(duration),
    }


def _write(path: Path, content: str | dict[str, Any]) -> None:
    from json import dumps

    from irtiming.errors import ArchiveError

    text = content if isinstance(content, str) else dumps(content, indent=1) + "\n"
    try:
        path.write_text(text, encoding="utf-8")
    except OSError as error:
        raise ArchiveError(
            f"{path} cannot be written ({error.strerror}); give a path in a folder that exists"
        ) from error
