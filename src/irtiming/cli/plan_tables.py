"""Plans in the terminal: schemes, proposals and runs as tables."""

from collections.abc import Iterable, Iterator, Sequence
from fractions import Fraction

from rich import box
from rich.console import Console
from rich.table import Table

from irtiming.cli.screen import say
from irtiming.plan import sampling
from irtiming.plan.drawing import sampling_text
from irtiming.plan.photon_information import frame_noise
from irtiming.plan.proposals import MOST_RUNS, Proposal, speeds_text
from irtiming.plan.schedule import plan_duration_s, run_length_ticks
from irtiming.plan.search import MOST_COMPARED, Option
from irtiming.plan.targets import Target
from irtiming.plan.wishes import as_text, is_prime
from irtiming.records.camera_description import Camera, Microbolometer
from irtiming.records.trigger_plan import TriggerPlan
from irtiming.session.free_plan import FreePlanned
from irtiming.session.plan import Planned, Proposed
from irtiming.units import readable_time, ticks_to_seconds

_LEAST_SHARE = 1e-3  # of an uncertainty, below which a part of it is not worth a number


def show(planned: Planned | Proposed, *, most: int) -> None:
    """Print what was planned: ``most`` schemes or proposals, what there is to say of them, and the runs of the best."""
    console = Console(highlight=False)
    if isinstance(planned, Proposed):
        _show_proposed(planned, console)
    else:
        _show_schemes(planned, most, console)


def show_free(planned: FreePlanned, *, most: int) -> None:
    """Print wheel speeds for a camera that runs free, the most even first, with the uncertainties to expect."""
    shown = planned.speeds[:most]
    names = next(([each.name for each in one.uncertainties] for one in shown if one.is_even), [])
    table = _numbers(
        "Wheel speeds for a camera that runs free, most even first",
        "wheel / Hz",
        "largest gap",
        *(_u_of(name.replace("trigger_delay", "delay")) for name in names),
    )
    for one in shown:
        found = {each.name: readable_time(float(f"{each.standard_uncertainty_s:.2g}")) for each in one.uncertainties}
        table.add_row(f"{one.wheel_rate_hz:.5g}", f"{one.largest_gap:.2f}", *(found.get(name, "-") for name in names))
    console = Console(highlight=False)
    console.print(table)
    lines = [
        f"largest gap between angles of {planned.order.samples} frames, over the even one: 1 at best; the worst within "
        f"+-{1e6 * planned.order.tolerance:g} ppm of rate and period",
        "u: of one run, k = 1, of a strobe; stamps and arrivals add the scatter of their grid and what relates their clock",
    ]
    _print_lines(lines, console)


def _show_schemes(planned: Planned, most: int, console: Console) -> None:
    best = planned.best
    shown = planned.options.best[:most]
    console.print(_schemes(shown, planned.wishes.clock_frequency_hz))
    _print_lines(_remarks_on_schemes(planned, len(shown)), console)
    if len(best.runs) > 1 or best.runs[0].repeats > 1:
        _show_runs(best, console)
    for scheme in best.schemes:
        console.print(f"\nSampling order of T = {scheme.turn_period_ticks}, C = {scheme.camera_period_ticks} ticks")
        say(sampling_text(scheme, turns=12 // len(best.schemes) + 1), console)


def _show_proposed(planned: Proposed, console: Console) -> None:
    console.print(_proposals(planned.found.best, planned.asked))
    console.print(_parts(planned.found.best[0]))
    _print_lines(_remarks_on_proposals(planned), console)
    _print_lines((*planned.setting.rig.remarks, _camera_text(planned.setting.camera)), console)
    _show_runs(planned.best, console)


def _print_lines(lines: Iterable[str], console: Console) -> None:
    for line in lines:
        console.print(line, markup=False)


def _numbers(title: str, *headings: str) -> Table:
    """A table of numbers, each column with its heading."""
    table = Table(title=title, box=box.SIMPLE_HEAD, pad_edge=False)
    for heading in headings:
        table.add_column(heading, justify="right")
    return table


def _u_of(name: str) -> str:
    """A heading in words, between which it may be broken."""
    return f"u of {name.replace('_', ' ')}"


def _schemes(ranked: Sequence[Option], clock_frequency_hz: int) -> Table:
    table = Table(title="Trigger schemes, best first", box=box.SIMPLE_HEAD, pad_edge=False, padding=(0, 1, 0, 0))
    for heading in ("", "T\nT'\n/ ticks", "C\ndelta\n/ ticks", "samples\nper turn\nper frame"):
        table.add_column(heading, justify="right", no_wrap=True)
    for heading in ("wheel / Hz\nexactly", "camera / Hz\nexactly", "run\ntolerance\nused"):
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
                f"{readable_time(float(sampling.run_duration_s(scheme, clock_frequency_hz)))}\n"
                f"{float(option.used_tolerance):.4f}",
            )
    return table


def _rate(rate_hz: Fraction) -> str:
    """Decimal above, exact below, where they differ."""
    decimal, exact = f"{float(rate_hz):.8g}", as_text(rate_hz)
    return decimal if decimal == exact else f"{decimal}\n{exact}"


def _remarks_on_schemes(planned: Planned, shown: int) -> Iterator[str]:
    options, wishes = planned.options, planned.wishes
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


def _show_runs(best: TriggerPlan, console: Console) -> None:
    """The runs of a plan, in order, and how long they take."""
    clock = best.clock_frequency_hz
    headings = ("run", "correction before", "wheel / Hz", "trigger delay", "delay / ticks", "repeats", "lasts")
    table = _numbers("Runs of the best, in order", *headings)
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


def _proposals(proposals: Sequence[Proposal], asked: Sequence[Target]) -> Table:
    uncertainties = (f"{_u_of(target.name)}\nwanted\n{_time(target.standard_uncertainty_s)}" for target in asked)
    title = "Measurements that should do, shortest first"
    table = _numbers(title, "", "wheel / Hz", "runs of each", "lasts", *uncertainties)
    for rank, proposal in enumerate(proposals, 1):
        clock = proposal.plan.clock_frequency_hz
        table.add_row(
            str(rank),
            "\n".join(f"{clock / scheme.turn_period_ticks:.4g}" for scheme in proposal.plan.schemes),
            "\n".join(map(str, proposal.runs_of_each)),
            readable_time(float(f"{proposal.duration_s:.3g}")),
            *(_time(found.standard_uncertainty_s) for found in proposal.uncertainties),
        )
    return table


def _parts(best: Proposal) -> Table:
    table = _numbers(
        "What u of the first is made of", "source", *(found.name.replace("_", " ") for found in best.uncertainties)
    )
    table.columns[0].justify = "left"
    sizes = [{part.source: part.standard_uncertainty_s for part in found.parts} for found in best.uncertainties]
    for source in dict.fromkeys(source for one in sizes for source in one):
        cells = [
            _time(one[source]) if one.get(source, 0.0) >= _LEAST_SHARE * found.standard_uncertainty_s else "–"
            for one, found in zip(sizes, best.uncertainties, strict=True)
        ]
        table.add_row(source, *cells)
    return table


def _remarks_on_proposals(planned: Proposed) -> Iterator[str]:
    """What one wheel speed could do where several are proposed."""
    if len(planned.best.schemes) == 1:
        return
    alone = planned.found.one_speed
    for each, target in zip(alone.uncertainties, planned.asked, strict=True):
        if each.standard_uncertainty_s > target.standard_uncertainty_s:
            yield (
                f"One wheel speed alone reaches u({each.name}) = {_time(each.standard_uncertainty_s)} at best "
                f"({speeds_text(alone.wheel_rates_hz)}, {MOST_RUNS} runs); {each.largest_part.source} makes "
                f"{_time(each.largest_part.standard_uncertainty_s)} of it."
            )


def _camera_text(camera: Camera) -> str:
    noise = f"noise of a pixel {camera.noise_to_contrast:.2%} of the contrast"
    text = f"Camera: {noise}, {camera.opening_pixels:.0f} pixels in the opening"
    rows = "" if camera.row_delay_s is None else f", row delay about {_time(camera.row_delay_s)}"
    if isinstance(camera, Microbolometer):
        return f"{text}, time constant about {_time(camera.time_constant_s)}{rows}."
    if rows:
        return f"{text}, integration time {_time(camera.integration_time_s)}{rows}."
    return f"{text}, so noise of a frame {frame_noise(camera).share:.2g} of its step."


def _time(time_s: float) -> str:
    return readable_time(float(f"{time_s:.2g}"))
