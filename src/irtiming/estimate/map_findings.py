"""What maps of the pixels tell in words: parts that are read at other times, row clocks that are no clocks, pixels that stray."""

from dataclasses import replace

import numpy as np

from irtiming.estimate import map_patterns
from irtiming.estimate.map_patterns import MappedDelays, RowClock
from irtiming.physics import robust
from irtiming.records.arrays import Array, Mask
from irtiming.records.finding import Finding
from irtiming.records.pixel_maps import PixelMaps, ReadoutPattern
from irtiming.units import counted

_STRAYS, _NOISY = 6.0, 3.0  # standard uncertainties; times the median noise
_SURE = 6.0  # standard uncertainties of a pattern
_SIGNIFICANCE = 1e-6
_MOST_CHI_SQUARE = 1.5
_NAMED = 8
_OF_COLUMNS = {
    "odd columns": "columns 1, 3, 5 ... are read {} than columns 0, 2, 4 ...",
    "right half": "the right half of the image is read {} than the left half",
}
_OF_ROWS = {
    "odd rows": "rows 1, 3, 5 ... are read {} than rows 0, 2, 4 ... beside them",
    "lower half": "the lower half of the image is read {} than the upper half and the row delay say",
    "middle rows": "the middle rows are read {} than the straight line from the first to the last row says",
}


def deviating(delays: MappedDelays, clock: RowClock, *, lag_pulls: Array | None, noise_dn: Array) -> Mask:
    """Pixels that stray by more than chance, shape (p,): in delay, in time constant, or in noise.

    Parameters
    ----------
    delays, clock
        Of the pixels.
    lag_pulls
        Shape (p,); by how much their time constants differ from the median, in standard uncertainties, where the camera lags.
    noise_dn
        Shape (p,); nan where it is not known.
    """
    stray = np.abs(clock.left_s) > _STRAYS * clock.scatter * delays.u_s
    stray |= np.nan_to_num(noise_dn) > _NOISY * np.nanmedian(noise_dn)
    if lag_pulls is not None:
        scatter = max(1.0, robust.spread(lag_pulls))
        stray |= np.abs(lag_pulls) > _STRAYS * scatter
    return np.asarray(stray)


def with_findings(maps: PixelMaps, delays: MappedDelays, *, clock: RowClock) -> PixelMaps:
    """The maps with their findings.

    Parameters
    ----------
    maps
        Without.
    delays, clock
        Of their pixels.
    """
    found = [*_taps(maps), *_row_clock(maps, delays, clock), *_unexplained(maps), *_unseen(maps), *_stray(maps)]
    return replace(maps, findings=tuple(found))


def _taps(maps: PixelMaps) -> list[Finding]:
    """Columns that are read at other times than those beside them."""
    sure = [one for one in maps.patterns if one.name in _OF_COLUMNS and abs(one.pull) > _SURE]
    return [
        Finding(
            code="taps-apart",
            severity="warning",
            what=f"{_OF_COLUMNS[one.name].format(_later(one))}: two taps of the readout that do not keep step",
            cure="use the map, or its means over columns, where that matters: the result has one delay for all columns",
        )
        for one in sure
    ]


def _row_clock(maps: PixelMaps, delays: MappedDelays, clock: RowClock) -> list[Finding]:
    """Rows that do not lie on a straight line: by a pattern that has a name, else by what they are off."""
    sure = [one for one in maps.patterns if one.name in _OF_ROWS and abs(one.pull) > _SURE]
    uneven = [_OF_ROWS[one.name].format(_later(one)) for one in sure]
    if not uneven:
        p_value, row, off_s = map_patterns.p_value_of_straight_rows(delays, clock)
        if p_value > _SIGNIFICANCE:
            return []
        uneven = [f"row {row} is off the straight line of the others by {1e6 * off_s:+.2f} µs"]
    return [
        Finding(
            code="row-clock-not-even",
            severity="warning",
            what=f"the row clock is not even: {'; '.join(uneven)}",
            cure="use the map's means over rows where that matters: the result has one row delay for all",
        )
    ]


def _later(one: ReadoutPattern) -> str:
    return f"{1e6 * abs(one.later_s):.2f} µs {'later' if one.later_s > 0 else 'earlier'} (u = {1e6 * one.u_later_s:.2f} µs)"


def _unexplained(maps: PixelMaps) -> list[Finding]:
    if maps.reduced_chi_square <= _MOST_CHI_SQUARE:
        return []
    return [
        Finding(
            code="map-not-explained",
            severity="doubt",
            what=f"pixels are off what contrast, delay and response say of them by {maps.reduced_chi_square:.2f} times the "
            "variance of their noise; the maps' uncertainties are too small by about the root of that",
            cure="focus the camera on the mask, shade it from stray light, and switch filters in the camera off",
        )
    ]


def _unseen(maps: PixelMaps) -> list[Finding]:
    rows = maps.unseen_row_px
    if not rows.size or maps.fitted_row_delay_s == 0:
        return []
    ends = np.split(rows, np.flatnonzero(np.diff(rows) > 1) + 1)
    named = " and ".join(f"{one[0]} to {one[-1]}" if one.size > 1 else str(one[0]) for one in ends)
    return [
        Finding(
            code="rows-unseen",
            severity="info",
            what=f"image rows {named} hold no pixel of the opening: the map says nothing of them, and their delay is that of the "
            "straight row clock",
        )
    ]


def _stray(maps: PixelMaps) -> list[Finding]:
    found = []
    if maps.is_deviating.any():
        what = f"{_named(maps.is_deviating, maps)} unlike the others in delay, time constant or noise"
        found.append(Finding(code="pixels-deviating", severity="info", what=what))
    if maps.is_dead.any():
        what = f"{_named(maps.is_dead, maps)} of the opening dead or blinking, without values in the map"
        found.append(Finding(code="pixels-dead", severity="info", what=what))
    return found


def _named(these: Mask, maps: PixelMaps) -> str:
    """How many pixels, and where the first of them lie."""
    places = np.add(np.argwhere(these), (maps.roi[0], maps.roi[2])).tolist()
    named = ", ".join(f"({row}, {column})" for row, column in places[:_NAMED])
    more = f" and {len(places) - _NAMED} more" if len(places) > _NAMED else ""
    return f"{counted(len(places), 'pixel')}, in (row, column) {named}{more},"
