"""Many cameras measured: what was found of each, how it was judged, what could not be analysed, and how well it repeats."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Literal, final

from irtiming.records.setting_point import CameraKey, SettingName, SettingPoint

Judgement = Literal["pass", "conditional pass", "conditional fail", "fail", "not measured", "no limits"]
WORST_FIRST: tuple[Judgement, ...] = (
    "fail",
    "not measured",
    "conditional fail",
    "conditional pass",
    "pass",
    "no limits",
)


@final
@dataclass(frozen=True, kw_only=True)
class Listed:
    """A recording as a person lists it; what is empty the recording says itself, or is unknown.

    ``is_one_of_many`` where there may be other cameras: it must then be known which it is of.
    """

    path: Path
    serial_number: str = ""
    operator: str = ""
    run: str = ""
    is_one_of_many: bool = True


@final
@dataclass(frozen=True, kw_only=True)
class CampaignPoint:
    """One result: its point, who measured, and which time (``operator`` and ``run`` of table.csv; empty where not stated)."""

    point: SettingPoint
    operator: str = ""
    run: str = ""


@final
@dataclass(frozen=True, kw_only=True)
class JudgedValue:
    """A parameter of a camera: value, u, U = k u, limits, what the rule says, and the probability of lying within them.

    ``degrees_of_freedom`` are those of u. Without limits ``probability`` is None; ``birge`` is the ratio by which results scatter
    beyond their u, 1 for one result.
    """

    value: float
    standard_uncertainty: float
    expanded_uncertainty: float
    degrees_of_freedom: float
    unit: str
    lower: float | None = None
    upper: float | None = None
    judgement: Judgement = "no limits"
    probability: float | None = None
    birge: float = 1.0


@final
@dataclass(frozen=True, kw_only=True)
class CampaignLine:
    """A camera at one setting: all its results together.

    ``judgement`` is the worst of its values; ``findings`` are codes, each once per result that has it.
    """

    camera: CameraKey
    settings: Mapping[SettingName, float | str]
    values: Mapping[str, JudgedValue]
    judgement: Judgement
    n_results: int
    n_recordings: int
    first_measured: str = ""
    findings: tuple[str, ...] = ()
    simulated: bool = False


@final
@dataclass(frozen=True, kw_only=True)
class Broken:
    """What could not be analysed: files, and why."""

    files: tuple[str, ...]
    what: str


@final
@dataclass(frozen=True, kw_only=True)
class GaugeStudy:
    """Gauge repeatability and reproducibility of a parameter by analysis of variance (AIAG MSA).

    Variances of one measurement in the unit squared: of the same operator and camera again (``repeatability``), between operators
    (``operators``), of operators with cameras (``interaction``; 0 where it was pooled, ``interaction_p_value`` is what its F-test
    says), and between ``cameras``. ``n_operators`` is 1 where none is distinguished: there is then no reproducibility.
    ``rms_u_own`` is what the results themselves state of what they do not have in common.
    """

    parameter: str
    unit: str
    n_cameras: int
    n_operators: int
    n_repeats: int
    repeatability: float
    operators: float
    interaction: float
    cameras: float
    interaction_p_value: float | None
    rms_u_own: float

    @property
    def reproducibility(self) -> float:
        """Variance by operators, with what they do to some cameras more than to others."""
        return self.operators + self.interaction

    @property
    def gauge(self) -> float:
        """Variance of one measurement of one camera by any operator."""
        return self.repeatability + self.reproducibility

    @property
    def total(self) -> float:
        """Variance of one measurement of any camera."""
        return self.gauge + self.cameras


@final
@dataclass(frozen=True, kw_only=True)
class Campaign:
    """All of it; ``rule`` is that by which it was judged, in words.

    ``limits_of_none`` are serial numbers of cameras that have limits of their own and no result.
    """

    points: tuple[CampaignPoint, ...]
    lines: tuple[CampaignLine, ...]
    broken: tuple[Broken, ...]
    studies: tuple[GaugeStudy, ...]
    rule: str
    left_out_of_study: str = ""
    limits_of_none: tuple[str, ...] = ()
