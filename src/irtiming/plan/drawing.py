"""The sampling order, drawn: as text for a terminal, and as figure 3 of Schatz 2023 in SVG."""

from fractions import Fraction
from itertools import islice
from math import ceil
from xml.sax.saxutils import escape

from irtiming.plan.sampling import sampling_order, triggers_to_neighbour
from irtiming.plan.wishes import as_text
from irtiming.records.trigger_plan import TriggerScheme

MOST_DOTS = 2000
"""Triggers that a panel of the picture shows at most; the caption says so where there are more."""

_LEFT, _WIDTH, _PICTURE_WIDTH = 96, 820, 960
_BLUE, _PALE, _RED, _INK = "#1f5fa8", "#dbe8f7", "#c0392b", "#222222"


def sampling_text(scheme: TriggerScheme, *, width: int = 72, turns: int = 12) -> str:
    """One line per turn of the wheel, with a mark where a trigger falls, and all turns folded at the end.

    Parameters
    ----------
    scheme
        Its first turns are drawn; if N is at most ``width``, a column is one sample.
    width
        Columns for one turn, at least 1.
    turns
        Lines at most; further turns are not drawn but counted.

    Returns
    -------
    Lines, without an end of line after the last. A mark is the last digit of the trigger's number where each
    column is one sample, else ``|``.
    """
    samples, per_frame = scheme.samples_per_turn, scheme.samples_per_frame
    columns = min(samples, width)
    shown = min(turns, per_frame)
    rows = [["."] * columns for _ in range(shown)]
    for trigger in islice(scheme, ceil(shown * samples / per_frame)):
        row = trigger.ticks // scheme.turn_period_ticks
        mark = str(trigger.number % 10) if samples <= width else "|"
        rows[row][trigger.sample * columns // samples] = mark
    label = len(f"turn {per_frame - 1}")
    lines = [f"{f'turn {number}':<{label}}  {''.join(row)}" for number, row in enumerate(rows)]
    if shown < per_frame:
        lines.append(f"{'...':<{label}}  {per_frame - shown} more turns")
    lines.append(f"{'all':<{label}}  {'|' * columns}")
    return "\n".join([*lines, sampling_sentence(scheme)])


def sampling_sentence(scheme: TriggerScheme) -> str:
    """How the samples of a turn follow each other, in one line."""
    samples, neighbour = scheme.samples_per_turn, triggers_to_neighbour(scheme)
    return (
        f"{samples} triggers in {scheme.samples_per_frame} turns; trigger n takes sample "
        f"n x {scheme.samples_per_frame} mod {samples}; "
        f"a sample's neighbour comes {neighbour} triggers later (delta = {neighbour} C mod T)"
    )


def sampling_svg(scheme: TriggerScheme, clock_frequency_hz: int) -> str:
    """Figure 3: triggers along the time axis above, and every trigger at its place in the turn below.

    Parameters
    ----------
    scheme
        One scheme; above are its first turns, below the first `MOST_DOTS` triggers, earliest turn at the top.
    clock_frequency_hz
        For the rates in the title; Hz.

    Returns
    -------
    A complete SVG document as text.
    """
    title = (
        f"T = {scheme.turn_period_ticks}, C = {scheme.camera_period_ticks}, "
        f"delta = {scheme.sampling_interval_ticks} ticks of 1/{clock_frequency_hz} s: wheel "
        f"{_rate(clock_frequency_hz, scheme.turn_period_ticks)} Hz, camera "
        f"{_rate(clock_frequency_hz, scheme.camera_period_ticks)} Hz"
    )
    height = 470
    parts = [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {_PICTURE_WIDTH} {height}" role="img" '
        'font-family="sans-serif" font-size="14">',
        f"<title>{escape('Sampling order: ' + title)}</title>",
        f'<rect width="{_PICTURE_WIDTH}" height="{height}" fill="white"/>',
        _text(_PICTURE_WIDTH / 2, 26, title),
        *_time_axis(scheme),
        *_folded_turn(scheme),
        _text(_PICTURE_WIDTH / 2, 456, sampling_sentence(scheme)),
        "</svg>",
    ]
    return "\n".join(parts) + "\n"


def _time_axis(scheme: TriggerScheme) -> list[str]:
    """Upper panel: the first turns as blue intervals, the triggers as red lines, and T, C drawn as arrows."""
    turns = min(
        scheme.samples_per_frame,
        max(4, ceil(Fraction(2 * scheme.camera_period_ticks, scheme.turn_period_ticks))),
    )
    span = turns * scheme.turn_period_ticks

    def at(ticks: int) -> float:
        return _LEFT + _WIDTH * ticks / span

    parts = [_text(_LEFT - 10, 104, "time", "end")]
    if turns <= 40:
        for turn in range(turns):
            left, right = at(turn * scheme.turn_period_ticks), at((turn + 1) * scheme.turn_period_ticks)
            parts.append(
                f'<rect x="{left:.2f}" y="80" width="{right - left:.2f}" height="40" '
                f'fill="{_PALE if turn % 2 else "white"}" stroke="{_BLUE}"/>'
            )
    for trigger in islice(scheme, MOST_DOTS):
        if trigger.ticks >= span:
            break
        parts.append(_line((at(trigger.ticks), 72, at(trigger.ticks), 128), _RED, 2))
        if span <= 45 * scheme.camera_period_ticks:
            parts.append(_text(at(trigger.ticks), 144, str(trigger.number), colour=_RED))
    parts += _arrow(at(0), at(scheme.turn_period_ticks), 60, "T", _BLUE)
    if scheme.samples_per_turn > 1:
        parts += _arrow(at(0), at(scheme.camera_period_ticks), 172, "C", _RED)
    return parts


def _folded_turn(scheme: TriggerScheme) -> list[str]:
    """Lower panel: place in the turn to the right, order of the triggers downwards."""
    order = sampling_order(scheme)[:MOST_DOTS].tolist()
    top, bottom, samples = 210, 400, scheme.samples_per_turn
    few = samples <= 40

    def at(sample: int) -> float:
        return _LEFT + _WIDTH * (sample + 0.5) / samples

    frame = f'x="{_LEFT}" y="{top}" width="{_WIDTH}" height="{bottom - top}"'
    parts = [
        f'<rect {frame} fill="none" stroke="{_BLUE}"/>',
        _text(_LEFT - 10, top + 14, "first", "end"),
        _text(_LEFT - 10, bottom - 4, "last", "end"),
        _text(_LEFT - 10, (top + bottom) / 2 + 5, "trigger", "end"),
    ]
    if few:
        parts += [_line((at(sample), top, at(sample), bottom), _PALE) for sample in range(samples)]
        parts += [_text(at(sample), bottom + 16, str(sample)) for sample in range(samples)]
    for number, sample in enumerate(order):
        height = top + 8 + (bottom - top - 16) * number / max(1, len(order) - 1)
        radius = 5 if few else 1.6
        parts.append(f'<circle cx="{at(sample):.2f}" cy="{height:.2f}" r="{radius}" fill="{_RED}"/>')
    if few and samples > 1:
        parts += _arrow(at(0), at(1), top - 10, "delta", _BLUE)
    left_out = samples - len(order)
    caption = f"place in the turn, in units of delta (0 .. {samples - 1})"
    caption += f"; the last {left_out} triggers are not drawn" if left_out else ""
    return [*parts, _text(_LEFT + _WIDTH / 2, bottom + (34 if few else 20), caption)]


def _arrow(left: float, right: float, height: float, label: str, colour: str) -> list[str]:
    return [
        _line((left, height, right, height), colour),
        _line((left, height - 5, left, height + 5), colour),
        _line((right, height - 5, right, height + 5), colour),
        _text((left + right) / 2, height - 6, label, colour=colour),
    ]


def _line(ends: tuple[float, float, float, float], colour: str, width: float = 1) -> str:
    x1, y1, x2, y2 = ends
    place = f'x1="{x1:.2f}" y1="{y1:.2f}" x2="{x2:.2f}" y2="{y2:.2f}"'
    return f'<line {place} stroke="{colour}" stroke-width="{width}"/>'


def _text(x: float, y: float, text: str, anchor: str = "middle", colour: str = _INK) -> str:
    return f'<text x="{x:.2f}" y="{y:.2f}" text-anchor="{anchor}" fill="{colour}">{escape(text)}</text>'


def _rate(clock_frequency_hz: int, ticks: int) -> str:
    rate = Fraction(clock_frequency_hz, ticks)
    return as_text(rate) if len(as_text(rate)) <= 12 else f"{float(rate):.6g}"
