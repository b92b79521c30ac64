"""The camera of a result, as far as it is applied to other frames: its timing with covariance, and for what it holds.

Moments of a row are sums of parameters; `Moment` has the factor of each, so that uncertainties and correlations follow from the
covariance alone.
"""

import re
from collections.abc import Mapping
from dataclasses import dataclass
from math import isfinite
from typing import Literal, final

import numpy as np

from irtiming.apply.frames import Readout
from irtiming.apply.inverse_lag import Response
from irtiming.apply.stamps import Scatter
from irtiming.archive.result_model import Result
from irtiming.errors import EstimationError
from irtiming.physics.response.two_constants import REFERENCE_TEMPERATURE_K, TwoConstants
from irtiming.records.arrays import Array
from irtiming.records.estimate import SHARES, Estimate
from irtiming.records.frame_events import DELAYS, FrameEvent
from irtiming.records.recording import USUAL_READOUT, CameraType, ReadoutMode
from irtiming.records.two_constants import NAMES as TWO_CONSTANTS

MomentName = Literal["start", "middle", "end", "reading", "effective"]
MEANINGS: Mapping[MomentName, str] = {
    "start": "start of integration",
    "middle": "middle of integration",
    "end": "end of integration",
    "reading": "reading of the row",
    "effective": "the scene appears as it was then, to first order",
}
"""What happens at each moment."""

_TAKEN = (
    "trigger_delay", "exposure_midpoint_delay", "integration_time", "row_delay", "time_constant", *SHARES,
)  # fmt: skip
_MOST_SHARE, _LONGEST_S, _MOST_ROWS = 0.9, 60.0, 2**16
_SHARE = re.compile(r"0?\.[0-9]{1,9}")
_SAME_PERIOD = 1.01  # plans for several wheel speeds have frame periods that differ by a few thousandths
_SURE = 2.0  # standard uncertainties, from which a share of the frame before counts as there


@final
@dataclass(frozen=True, kw_only=True)
class Conditions:
    """For which camera and settings a result holds, or how frames were made; None or empty where not stated."""

    camera_type: CameraType | Literal[""] = ""
    readout_mode: ReadoutMode | Literal[""] = ""
    serial_number: str = ""
    model: str = ""
    integration_time_s: float | None = None
    rows: int | None = None
    columns: int | None = None
    frame_period_s: float | None = None


@final
@dataclass(frozen=True, kw_only=True)
class Moment:
    """A moment of row 0 after the event: a constant plus factors times parameters; each row adds its row delay."""

    name: MomentName
    factors: Mapping[str, float]
    constant_s: float = 0.0


@final
@dataclass(frozen=True, kw_only=True, eq=False)
class CameraTiming:
    """Timing of a camera as a result states it.

    ``event`` is what its delays count from. ``estimate`` has what of the parameters the result holds, with covariance; the first
    delay is called ``trigger_delay`` there, whatever the event. ``scatter`` is how single stamps lie about the event, None where
    each is one; ``frame_scatter_s`` is by how much the camera itself is late or early from frame to frame, a standard deviation.
    ``frame_periods_s`` are those of the recordings, each once, ascending.
    ``stated_window_u_s`` is what rig.toml states of the integration time that the recordings state, 0 where it states nothing.
    ``shared_u`` is, of each parameter, how much of the standard uncertainty comes from errors of the rig, which
    other results share. ``not_in_uncertainty`` are the result's own words.
    """

    conditions: Conditions
    estimate: Estimate
    event: FrameEvent = "trigger"
    scatter: Scatter | None = None
    frame_scatter_s: float = 0.0
    frame_periods_s: tuple[float, ...] = ()
    stated_window_u_s: float = 0.0
    shared_u: tuple[float, ...] = ()
    two_constants: TwoConstants | None = None
    substrate_temperature_k: float | None = None
    not_in_uncertainty: tuple[str, ...] = ()
    simulated: bool = False

    @property
    def has_lag(self) -> bool:
        """Whether pixels follow the scene with a lag instead of integrating it."""
        return self.conditions.camera_type == "microbolometer"

    @property
    def row_delay_s(self) -> float:
        """From the reading of a row to that of the row below it; 0 where all are read at once."""
        return self.estimate.value("row_delay") if "row_delay" in self.estimate else 0.0

    @property
    def response(self) -> Response:
        """What lies between scene and frames; a share of the frame before only where it is more than two of its uncertainties."""
        return Response(
            time_constant_s=self.estimate.value("time_constant") if self.has_lag else 0.0,
            recursive_filter=self._sure("recursive_filter"),
            pixel_memory=self._sure("pixel_memory"),
        )

    @property
    def readout(self) -> Readout:
        """For `frames.scenes`."""
        return Readout(response=self.response, row_delay_s=self.row_delay_s)

    def moments(self, frame_period_s: float | None) -> tuple[Moment, ...]:
        """The moments that the camera has, those of row 0.

        Parameters
        ----------
        frame_period_s
            Between frames, for what a share of the frame before does to the effective moment; None where it is not known.
        """
        if self.has_lag:
            reading = Moment(name="reading", factors={"trigger_delay": 1.0})
            effective = _sum(reading, {"time_constant": -1.0})
            return reading, self._of_frames_before(effective, frame_period_s)
        both = {"trigger_delay", "exposure_midpoint_delay"} <= set(self.estimate.names)
        window_s = self.conditions.integration_time_s
        if both:
            start = Moment(name="start", factors={"trigger_delay": 1.0})
            middle = Moment(name="middle", factors={"exposure_midpoint_delay": 1.0})
            last = {"exposure_midpoint_delay": 2.0, "trigger_delay": -1.0}
            if "integration_time" in self.estimate:  # what comes after the window makes its middle later, not its end
                last = {"trigger_delay": 1.0, "integration_time": 1.0}
            end = Moment(name="end", factors=last)
        elif "exposure_midpoint_delay" in self.estimate or window_s is None:
            only = "exposure_midpoint_delay" if "exposure_midpoint_delay" in self.estimate else "trigger_delay"
            middle = Moment(name="middle", factors={only: 1.0})
            return middle, self._of_frames_before(middle, frame_period_s)
        else:
            start = Moment(name="start", factors={"trigger_delay": 1.0})
            middle = Moment(name="middle", factors=start.factors, constant_s=window_s / 2)
            end = Moment(name="end", factors=start.factors, constant_s=window_s)
        return start, middle, end, self._of_frames_before(middle, frame_period_s)

    @property
    def frame_before(self) -> str | None:
        """Name of the share of the frame before that the result has, if any."""
        return next((name for name in SHARES if name in self.estimate), None)

    def offset_s(self, moment: Moment, row_px: Array) -> Array:
        """How much after the event the moment is, of each row, s; both shape (row,)."""
        at = moment.constant_s + sum(factor * self.estimate.value(name) for name, factor in moment.factors.items())
        return at + np.asarray(row_px, dtype=np.float64) * self.row_delay_s

    def covariance_s2(self, one: Moment, other: Moment, *, one_row_px: Array, other_row_px: Array) -> Array:
        """Covariance of `offset_s` of two moments, row by row, s^2; all shape (row,)."""
        left, right = self._factors(one, one_row_px), self._factors(other, other_row_px)
        return np.asarray(np.einsum("ri,ij,rj->r", left, self.estimate.covariance, right))

    def u_s(self, moment: Moment, row_px: Array) -> Array:
        """Standard uncertainty of `offset_s`, shape (row,)."""
        power = self.covariance_s2(moment, moment, one_row_px=row_px, other_row_px=row_px)
        return np.sqrt(np.maximum(power, 0))

    def _factors(self, moment: Moment, row_px: Array) -> Array:
        found = np.zeros((np.size(row_px), len(self.estimate.names)))
        for name, factor in moment.factors.items():
            found[:, self.estimate.names.index(name)] = factor
        if "row_delay" in self.estimate:
            found[:, self.estimate.names.index("row_delay")] += row_px
        return found

    def _of_frames_before(self, moment: Moment, frame_period_s: float | None) -> Moment:
        """The effective moment: a share k of the frame before puts it k / (1 - k) frames back, a memory s by s frames."""
        factors, constant_s = dict(moment.factors), moment.constant_s
        for name in SHARES:
            if name not in self.estimate or frame_period_s is None:
                continue
            share = self.estimate.value(name)
            back, slope = (share / (1 - share), (1 - share) ** -2) if name == "recursive_filter" else (share, 1.0)
            factors[name] = -slope * frame_period_s
            constant_s += (slope * share - back) * frame_period_s
        return Moment(name="effective", factors=factors, constant_s=constant_s)

    def _sure(self, name: str) -> float:
        if name not in self.estimate:
            return 0.0
        value, u = self.estimate.value(name), self.estimate.u(name)
        return value if abs(value) > _SURE * u else 0.0


def _sum(moment: Moment, more: Mapping[str, float]) -> Moment:
    return Moment(name="effective", factors={**moment.factors, **more}, constant_s=moment.constant_s)


def of_result(result: Result) -> CameraTiming:
    """The camera of a result.

    Raises
    ------
    EstimationError
        If it has no delay that can be applied, or one of its numbers or their correlations is missing.
    """
    own = DELAYS[result.frame_event]
    by_own_name = {own if name == "trigger_delay" else name: name for name in _TAKEN}
    found = tuple(name for name in by_own_name if name in result.parameters)
    names = tuple(by_own_name[name] for name in found)
    delays = {"trigger_delay", "exposure_midpoint_delay"} & set(names)
    needed = {"time_constant"} if result.camera == "microbolometer" else set()
    if not delays or not needed <= set(names):
        have, wanted = ", ".join(found) or "none", own.replace("_", " ")
        raise EstimationError(
            f"the result has no {wanted} that can be applied (it has {have}); analyse recordings that determine it"
        )
    values = np.array([result.parameters[name].value for name in found], dtype=np.float64)
    u = np.array([result.parameters[name].standard_uncertainty for name in found], dtype=np.float64)
    lacking = [
        name for name, one, other in zip(found, values, u, strict=True) if not (isfinite(one) and isfinite(other))
    ]
    if lacking:
        raise EstimationError(f"the result does not know {', '.join(lacking)}; analyse recordings that determine it")
    _require_plausible(names, values, u)
    estimate = Estimate(
        names=names,
        units=tuple(result.parameters[name].unit for name in found),
        values=values,
        covariance=_correlation(result, found) * np.outer(u, u),
    )
    two, substrate_k = _two_constants(result)
    return CameraTiming(
        conditions=_conditions(result),
        estimate=estimate,
        event=result.frame_event,
        scatter=_scatter(result),
        frame_scatter_s=(result.delay_scatter and result.delay_scatter.standard_deviation) or 0.0,
        frame_periods_s=_periods(result),
        stated_window_u_s=_stated_window_u_s(result),
        shared_u=tuple(_shared_u(result, name) for name in found),
        two_constants=two,
        substrate_temperature_k=substrate_k,
        not_in_uncertainty=tuple(result.not_in_uncertainty),
        simulated=result.simulated,
    )


def _periods(result: Result) -> tuple[float, ...]:
    return tuple(
        sorted({one.frame_period for one in result.inputs if one.frame_period and 0 < one.frame_period <= _LONGEST_S})
    )


def _period(result: Result) -> float | None:
    """From frame to frame, as good as the same in all recordings; None where it is not."""
    periods = _periods(result)
    return sum(periods) / len(periods) if periods and periods[-1] < _SAME_PERIOD * periods[0] else None


def _stated_window_u_s(result: Result) -> float:
    stated = [one.value for one in result.rig.values if one.name == "camera.integration_time_u"]
    return max((one for one in stated if isinstance(one, float) and 0 < one <= _LONGEST_S), default=0.0)


def _require_plausible(names: tuple[str, ...], values: Array, u: Array) -> None:
    """Refuse numbers that no camera has: nothing is to be made of a file that was changed."""
    for name, value, one in zip(names, values, u, strict=True):
        most, unit = (_MOST_SHARE, "") if name in SHARES else (_LONGEST_S, " s")
        if not (abs(value) <= most and one <= most):
            raise EstimationError(
                f"the result has {name} = {value:g} ± {one:g}{unit}, must be within ±{most:g}{unit}; write it anew with "
                "irtiming analyse --json"
            )


def _correlation(result: Result, names: tuple[str, ...]) -> Array:
    """Of these parameters; those that the matrix of the result lacks count as uncorrelated with the others."""
    known, matrix = result.correlation.names, result.correlation.matrix
    found = np.eye(len(names))
    for i, one in enumerate(names):
        for k, other in enumerate(names):
            if i != k and one in known and other in known:
                coefficient = matrix[known.index(one)][known.index(other)]
                if coefficient is None:
                    raise EstimationError(
                        f"the result does not know the correlation of {one} and {other}; write it anew with "
                        "irtiming analyse --json"
                    )
                found[i, k] = coefficient
    return found


def _shared_u(result: Result, name: str) -> float:
    """Of one parameter, from sources of type B."""
    parts = [one.standard_uncertainty.get(name) for one in result.contributions if one.type == "B"]
    return float(np.sqrt(sum(part**2 for part in parts if part is not None and isfinite(part))))


def _scatter(result: Result) -> Scatter | None:
    """Of single stamps about the event, all recordings together; None where each stamp is an event by itself."""
    jitters = [one.event.jitter for one in result.inputs if one.event is not None]
    if not jitters or result.frame_event not in ("stamp", "arrival"):
        return None
    means, variances = [], []
    for one in jitters:
        edges, counts = np.array(one.histogram.edges), np.array(one.histogram.counts, dtype=np.float64)
        if edges.size != counts.size + 1 or not counts.sum() > 0:
            raise EstimationError("the histogram of the stamps' jitter has no counts; write the result anew")
        means.append(float(counts @ (edges[1:] + edges[:-1]) / 2 / counts.sum()))
        variances.append(one.standard_deviation**2)
    mean_s, spread_s = float(np.mean(means)), float(np.sqrt(np.mean(variances) + np.var(means)))
    if not (abs(mean_s) <= _LONGEST_S and spread_s <= _LONGEST_S):
        raise EstimationError(
            f"stamps scatter by {spread_s:g} s about {mean_s:g} s, must be within {_LONGEST_S:g} s; write it anew"
        )
    shares = set.intersection(*(set(one.quantiles) for one in jitters))
    if odd := [share for share in shares if _SHARE.fullmatch(share) is None]:
        raise EstimationError(
            f"a quantile of the stamps' jitter is that of '{odd[0]}', must be of a share such as 0.95; write it anew"
        )
    return Scatter(
        mean_s=mean_s,
        standard_deviation_s=spread_s,
        quantiles_s={
            float(share): float(np.mean([one.quantiles[share] for one in jitters])) for share in sorted(shares)
        },
    )


def _conditions(result: Result) -> Conditions:
    images = {(one.image.rows, one.image.columns) for one in result.inputs if one.image is not None}
    windows = {
        one.integration_time for one in result.inputs if one.integration_time and 0 < one.integration_time <= _LONGEST_S
    }
    rows, columns = images.pop() if len(images) == 1 else (None, None)
    if rows is not None and not 0 < rows <= _MOST_ROWS:
        raise EstimationError(f"the result is of images of {rows} rows, must be from 1 to {_MOST_ROWS}")
    return Conditions(
        camera_type=result.camera,
        readout_mode=result.readout_mode or USUAL_READOUT[result.camera],
        serial_number=result.item.serial_number or "",
        model=result.item.model or "",
        integration_time_s=windows.pop() if len(windows) == 1 else None,
        rows=rows,
        columns=columns,
        frame_period_s=_period(result),
    )


def _two_constants(result: Result) -> tuple[TwoConstants | None, float | None]:
    """Constants of a wide temperature range and the substrate's temperature, where the result has both constants."""
    both = [result.parameters.get(name) for name in TWO_CONSTANTS]
    around = (result.two_constants or {}).get("substrate_temperature")
    kelvin = around.get("value") if isinstance(around, dict) else None
    substrate, scene = both
    if (
        substrate is None
        or scene is None
        or not substrate.value
        or not scene.value
        or not isinstance(kelvin, float | int)
    ):
        return None, None
    at = scene.reference_temperature
    reference_k = at.value if at is not None and at.value else REFERENCE_TEMPERATURE_K
    constants = TwoConstants(
        substrate_time_constant_s=substrate.value,
        scene_time_constant_s=scene.value,
        reference_temperature_k=reference_k,
    )
    return constants, float(kelvin)
