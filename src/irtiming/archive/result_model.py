"""The result of an analysis as it stands in JSON: one structure for every camera, what a camera has none of is left out."""

from typing import Annotated, Literal

from pydantic import Field, JsonValue, model_validator

from irtiming.archive import result_sense as sense
from irtiming.archive.typed_file import Part
from irtiming.records.finding import Severity
from irtiming.records.frame_events import FrameEvent
from irtiming.records.recording import CameraType, ReadoutMode

FORMAT = "irtiming-result"
VERSION = "1.2"
"""A reader takes any file of its own major version: a later minor one has more keys, which it leaves out."""

Real = float | None
"""A number; null where it is none, for JSON has neither not-a-number nor infinity."""

Uncertainty = Annotated[float, Field(ge=0)] | None
"""A standard or expanded uncertainty; null where it is not known."""

Evidence = dict[str, JsonValue]
"""What a method has to show for its numbers, by its own names; the page of the result tells what they mean."""


class Quantity(Part):
    """A value with its unit."""

    value: Real
    unit: str


class Measured(Quantity):
    """A value with its standard uncertainty (k = 1), what it is counted from, and its sign, null for a length of time."""

    unit: Literal["s", "1"]
    standard_uncertainty: Uncertainty
    reference_event: str
    sign: str | None


class ChangePerKelvin(Part):
    """By how much a constant would change with a warmer substrate or wheel."""

    substrate: Real
    wheel: Real
    unit: Literal["s/K"]


class Parameter(Measured):
    """A measurand; U = k u holds it with 95.45 % probability."""

    expanded_uncertainty: Uncertainty
    coverage_factor: Real
    effective_degrees_of_freedom: Real = Field(description="null: infinite")
    reference_temperature: Quantity | None = None
    change_per_kelvin: ChangePerKelvin | None = None

    @model_validator(mode="after")
    def _check(self) -> "Parameter":
        sense.require_expanded(self.standard_uncertainty, self.coverage_factor, expanded=self.expanded_uncertainty)
        return self


class Bound(Part):
    """Limits of a parameter that the recordings do not determine; null where it is open."""

    lower: Real
    upper: Real
    unit: Literal["s"]


class EdgeDelays(Part):
    """The delay by each of the wheel edges 0 to 3, with standard uncertainties from noise alone."""

    value: list[Real]
    standard_uncertainty: list[Uncertainty]
    unit: Literal["s"]
    reference_event: str
    sign: str


class Correlation(Part):
    """Correlation coefficients, rows and columns in the order of the names."""

    names: list[str]
    matrix: list[list[Real]]

    @model_validator(mode="after")
    def _check(self) -> "Correlation":
        sense.require_correlation(self.names, self.matrix)
        return self


class RelativeDelay(Measured):
    """Delay of a file beyond that of the smallest delay set."""

    unit: Literal["s"]
    file: str
    nominal: float
    deviation: Real = Field(None, description="measured minus nominal, in the generator's own time")
    deviation_standard_uncertainty: Uncertainty = None


class CombinedDelay(Measured):
    """Relative delay of all runs with one delay at one speed."""

    unit: Literal["s"]
    nominal: float
    runs: int
    scatter_of_runs: Real
    rotation_speed: Quantity


class Uncertain(Part):
    """Standard uncertainty of a measured number."""

    standard_uncertainty: float = Field(ge=0)
    unit: str


class BudgetLine(Part):
    """One source of uncertainty; one number for the delay that all wheel edges tell together, or one per parameter."""

    source: str
    type: Literal["A", "B"]
    standard_uncertainty: Uncertainty | dict[str, Uncertainty]
    degrees_of_freedom: Real = Field(description="null: infinite")
    share_percent: Real | dict[str, Real]
    unit: Literal["s"]
    measured: Uncertain | None = Field(
        None, description="a measured quantity, where the line follows from one such number"
    )
    sensitivity: Real | dict[str, Real] = Field(None, description="what it adds over that")


class LastRow(Measured):
    """When the last image row is read."""

    unit: Literal["s"]
    row: int


class Contribution(BudgetLine):
    """The same of every parameter, for every camera."""

    standard_uncertainty: dict[str, Uncertainty]
    share_percent: dict[str, Real]
    sensitivity: dict[str, Real] | None = None


class SplitPart(Uncertain):
    """A number with its uncertainty."""

    value: float


class FallingRising(Part):
    """Delay by falling slopes minus delay by rising ones: the time plus the angle over the wheel's angular frequency."""

    time: SplitPart
    angle: SplitPart
    covariance: Real = Field(description="of time and angle")
    covariance_unit: Literal["s rad"]

    @model_validator(mode="after")
    def _check(self) -> "FallingRising":
        sense.require_covariance(
            self.covariance, u=self.time.standard_uncertainty, other_u=self.angle.standard_uncertainty
        )
        return self


class DelayScatter(Part):
    """Standard deviation of the delay from frame to frame, null where it may be chance, and what it stays below with 95 %."""

    standard_deviation: Uncertainty
    standard_uncertainty: Uncertainty
    upper_limit: float = Field(ge=0)
    unit: Literal["s"]


class Core(Part):
    """What one method found."""

    method: str
    parameters: dict[str, Parameter]
    bounds: dict[str, Bound] = Field({})
    correlation: Correlation
    relative_delays: list[RelativeDelay]
    relative_delays_combined: list[CombinedDelay] = Field([])
    not_in_uncertainty: list[str] = Field(
        [], description="in words, what the uncertainties do not include because it was not stated"
    )
    last_row_read: LastRow | None = None
    budget: list[BudgetLine]
    contributions: list[Contribution] = Field([])
    edge_delays: EdgeDelays | None
    falling_rising: FallingRising | None = None
    delay_scatter: DelayScatter | None = None
    warnings: list[str]

    @model_validator(mode="after")
    def _check_names_and_units(self) -> "Core":
        sense.require_units({name: one.unit for name, one in self.parameters.items()})
        sense.require_same_names(self.correlation.names, self.parameters, what="correlations")
        times = [name for name, one in self.parameters.items() if one.unit == "s"]
        for line in self.contributions:
            sense.require_same_names(line.standard_uncertainty, times, what=f"contributions of '{line.source}'")
        return self


class ShutterEvent(Part):
    """Frames in which the camera's shutter is closed or which follow it."""

    first_frame: int
    end_frame: int
    kind: str


class Item(Part):
    """Which camera it is, as its recordings say; null where none does."""

    manufacturer: str | None = None
    model: str | None = None
    serial_number: str | None = None
    firmware: str | None = None


class Image(Part):
    """Pixels of a frame."""

    rows: int
    columns: int


class Histogram(Part):
    """Counts between edges, s."""

    edges: list[float]
    counts: list[int]


class JitterOfEvents(Part):
    """How events scatter about their grid, s; quantiles by their share."""

    standard_deviation: float = Field(ge=0)
    quantiles: dict[str, float]
    histogram: Histogram


class EventsOfFrames(Part):
    """What the delays of a camera that runs free count from, s; null where the counter itself stamped it."""

    kind: FrameEvent
    period: float
    clock_rate: Real = Field(description="relative, of the clock that stamped against the counter")
    clock_rate_standard_uncertainty: Uncertainty
    clock_offset: Real = Field(description="zero of that clock in the counter's time")
    clock_standard_uncertainty: float = Field(ge=0)
    grid_standard_uncertainty: float = Field(ge=0)
    jitter: JitterOfEvents
    unit: Literal["s"]


class InputSettings(Part):
    """What a camera was set to, SI units; null where the recording does not say."""

    gain_setting: str | None = None
    internal_delay_set: Real = Field(None, description="s, set in the camera itself")
    sensor_temperature: Real = Field(None, description="K, of the focal plane array")
    region_first_row: int | None = None
    region_first_column: int | None = None


class Input(Part):
    """One recording, and what its reduction took."""

    file: str
    sha256: str
    frames: int
    frames_used: int | None = None
    trigger_delay_time_set: float
    integration_time: Real = None
    rotation_speed: float
    blackbody_temperature: Real = None
    roi: list[int]
    threshold: Real = None
    border_px: int
    bad_pixels: int
    blackbody_is_colder: bool | None = None
    shutter_events: list[ShutterEvent] = Field([])
    axle_row_column_px: list[float] | None
    image: Image | None = None
    frame_period: Real = Field(None, description="s, from trigger to trigger")
    bit_depth: int | None = None
    start_time: str | None = Field(None, description="ISO 8601; null: the recording does not say")
    item: Item | None = Field(None, description="the camera that this recording names; null: none")
    simulated: bool = False
    settings: InputSettings = InputSettings()
    event: EventsOfFrames | None = Field(None, description="null: the camera was triggered")


class Source(Part):
    """A file that went in."""

    file: str
    sha256: str


class RigValue(Part):
    """One number or word of rig.toml, by section and key."""

    name: str
    value: float | str
    standard_uncertainty: Uncertainty = Field(None, description="null: none was stated, the number counts as exact")
    unit: str = ""


class RigSource(Source):
    """rig.toml, and what it says."""

    values: list[RigValue] = Field([])


class ResultFinding(Part):
    """One finding; docs/reference/findings.md lists the codes."""

    code: str
    severity: Severity
    recording: str = ""
    where: str
    what: str
    cure: str = ""


class Result(Core):
    """Everything that ``irtiming analyse --json`` writes, SI units."""

    format: Literal["irtiming-result"] = "irtiming-result"
    version: str = Field(VERSION, pattern=r"^\d+\.\d+$")
    camera: CameraType
    readout_mode: ReadoutMode | None = None
    frame_event: FrameEvent = Field("trigger", description="what the delays count from")
    item: Item = Item()
    simulated: bool = Field(False, description="whether a recording says of itself that no camera made it")
    headline: str = Field("", description="the result in one sentence, with what its uncertainties do not include")
    findings: list[ResultFinding] = Field([])
    joint_fit: Evidence | None = None
    likelihood: Evidence | None = None
    prediction: Evidence | None = None
    diagnosis: Evidence | None = None
    other_method: Core | None = None
    two_constants: Evidence | None = None
    noise_correlation: Evidence | None = None
    geometry: Evidence
    wheel: Evidence | None
    opening: Evidence | None = None
    fits: list[Evidence] = Field([])
    published_fits: list[Evidence] = Field([])
    choices: Evidence
    inputs: list[Input]
    rig: RigSource
    software: dict[str, str]
