"""What the pages want done, in plain words: so the server starts at once, and loads nothing of the measurement itself."""

from dataclasses import dataclass
from pathlib import Path
from typing import final

from irtiming.records.choices import Language


@final
@dataclass(frozen=True, kw_only=True)
class RigOrder:
    """A simulated rig: kind of camera and readout, its size, seconds of the rig in one of ours, seed, folder for its files."""

    camera: str
    readout: str
    rows: int
    columns: int
    speed: float
    seed: int
    folder: Path


@final
@dataclass(frozen=True, kw_only=True)
class RecordingOrder:
    """A series, or only its checklist; ``is_silent``: no one is asked to move wheel and mask. No estimate without ``rig``."""

    plan: Path
    folder: Path
    rig: Path | None = None
    checks_only: bool = False
    is_silent: bool = False


@final
@dataclass(frozen=True, kw_only=True)
class CheckOrder:
    """A recording to check, against the rig on which it was made where that is named."""

    path: Path
    rig: Path | None = None


@final
@dataclass(frozen=True, kw_only=True)
class ConvertOrder:
    """Frames to convert into a new file; its ending says the format."""

    path: Path
    out: Path


@final
@dataclass(frozen=True, kw_only=True)
class AnalyseOrder:
    """Recordings of one camera on one rig, how to analyse them, the files to write, and the report's language."""

    recordings: tuple[Path, ...]
    rig: Path
    method: str
    result: Path
    report: Path
    language: Language = "en"


@final
@dataclass(frozen=True, kw_only=True)
class CampaignOrder:
    """Recordings of many cameras, in a folder or listed in a CSV; where all that is found goes, and the register of results.

    ``language`` is that of the page.
    """

    source: Path
    rig: Path
    out: Path
    register: Path
    limits: Path | None = None
    workers: int = 1
    language: Language = "en"


@final
@dataclass(frozen=True, kw_only=True)
class CertifyOrder:
    """Results, certificate.toml, and the files to write."""

    results: tuple[Path, ...]
    form: Path
    out: tuple[Path, ...]


@final
@dataclass(frozen=True, kw_only=True)
class ApplyOrder:
    """A result, the frames that it is applied to, and the files to write; ``period`` is text such as "33.3 ms", or empty.

    ``series`` are results at other settings of the camera, between which is interpolated. Each stamp counts ``alone``, or by its
    place among all.
    """

    result: Path
    source: Path
    out: Path
    series: tuple[Path, ...] = ()
    period: str = ""
    times: Path | None = None
    alone: bool = False


@final
@dataclass(frozen=True, kw_only=True)
class PlanOrder:
    """A series that a person tries out: numbers as text in exact decimals, as ``irtiming plan`` takes them.

    ``wanted`` is text such as "trigger_delay=0.5us": the shortest measurements for it are sought among all usual wheel speeds.
    """

    camera: str
    readout: str
    wheel_hz: tuple[str, ...]
    frame_hz: str
    samples: str
    runs: str
    noise_k: float
    contrast_k: float
    window_or_lag_s: float
    rig: Path | None = None
    wanted: str = ""


@final
@dataclass(frozen=True, kw_only=True)
class HistoryOrder:
    """Which camera of which register of results; drift counts from the day ``since``, else from the last calibration."""

    register: Path
    serial_number: str
    since: str = ""


@final
@dataclass(frozen=True, kw_only=True)
class EnterOrder:
    """Results to enter into a register."""

    results: tuple[Path, ...]
    register: Path
