"""The result of an analysis as it stands in JSON: one structure for every camera, what a camera has none of is left out."""

from typing import Literal

from pydantic import Field

from irtiming.archive.typed_file import Part
from irtiming.records.finding import Severity
from irtiming.records.recording import CameraType, ReadoutMode

FORMAT = "irtiming-result"
VERSION = "1.0"
"""A reader takes any file of its own major version: a later minor one has more keys, which it leaves out."""

Real = float | None
"""A number; null where it is none, for JSON has neither not-a-number nor infinity."""

Settings = dict[str, bool | int | float | str | list[float] | list[str] | None]


class Quantity(Part):
    """A value with its unit."""

    value: Real
    unit: str


class Uncertain(Part):
    """A value with its standard uncertainty (k = 1), in the unit beside it."""

    value: Real
    standard_uncertainty: Real
    unit: str | None = None


class Uncertains(Part):
    """Values with their standard uncertainties, one each."""

    value: list[Real]
    standard_uncertainty: list[Real]
    unit: str | None = None
    reference_event: str | None = None
    sign: str | None = None


class Measured(Uncertain):
    """A value with what it is counted from, and its sign; the sign is null for a length of time."""

    reference_event: str
    sign: str | None


class ChangePerKelvin(Part):
    """By how much a constant would change with a warmer substrate or wheel."""

    substrate: Real
    wheel: Real
    unit: str


class Parameter(Measured):
    """A measurand; U = k u holds it with 95.45 % probability."""

    expanded_uncertainty: Real
    coverage_factor: Real
    effective_degrees_of_freedom: Real = Field(description="null: infinite")
    reference_temperature: Quantity | None = None
    change_per_kelvin: ChangePerKelvin | None = None


class Bound(Part):
    """Limits of a parameter that the recordings do not determine; null where it is open."""

    lower: Real
    upper: Real
    unit: str


class Correlation(Part):
    """Correlation coefficients, rows and columns in the order of the names."""

    names: list[str]
    matrix: list[list[Real]]


class RelativeDelay(Measured):
    """Delay of a file beyond that of the smallest delay set."""

    file: str
    nominal: float
    deviation: Real = Field(None, description="measured minus nominal, in the generator's own time")
    deviation_standard_uncertainty: Real = None


class CombinedDelay(Measured):
    """Relative delay of all runs with one delay at one speed."""

    nominal: float
    runs: int
    scatter_of_runs: Real
    rotation_speed: Quantity


class BudgetLine(Part):
    """One source of uncertainty; one number for the delay that all wheel edges tell together, or one per parameter."""

    source: str
    type: Literal["A", "B"]
    standard_uncertainty: Real | dict[str, Real]
    degrees_of_freedom: Real = Field(description="null: infinite")
    share_percent: Real | dict[str, Real]
    unit: str


class LastRow(Measured):
    """When the last image row is read."""

    row: int


class Core(Part):
    """What one method found."""

    method: str
    parameters: dict[str, Parameter]
    bounds: dict[str, Bound] = Field({})
    correlation: Correlation
    relative_delays: list[RelativeDelay]
    relative_delays_combined: list[CombinedDelay] = Field([])
    last_row_read: LastRow | None = None
    budget: list[BudgetLine]
    edge_delays: Uncertains | None
    warnings: list[str]


class SharedNumber(Uncertain):
    """A number that all recordings share, beside where the search started and what was known before."""

    start: Real
    prior_standard_uncertainty: Real
    value_over_prior: Real
    meaning: str
    sign: str | None


class Profile(Measured):
    """Likelihood along one parameter: twice the logarithm lost at each value that was tried."""

    values: list[Real]
    deviation: list[Real]
    lower: Real
    upper: Real


class Whiteness(Part):
    """Probability of residuals at least as correlated, were they white."""

    file: str
    probability: Real


class Moved(Part):
    """How far a value is from its start."""

    value: Real
    over_standard_uncertainty: Real
    unit: str


class JointFit(Part):
    """The fit of all recordings together."""

    shared: dict[str, SharedNumber]
    correlation: Correlation
    steps: int
    moved: Moved
    reduced_chi_square: Real
    birge: Real
    whiteness: list[Whiteness]
    whiteness_limit: float
    angles: dict[str, SharedNumber]
    angles_measured: bool
    profiles: dict[str, Profile]


class Likelihood(Part):
    """The likelihood of all recordings together, of a camera that is fitted row by row."""

    values: dict[str, Real]
    start: dict[str, Real]
    unit: str
    steps: int
    whiteness: list[Whiteness]
    profiles: dict[str, Profile]


class PredictedPart(Part):
    """One source of a predicted uncertainty."""

    source: str
    standard_uncertainty: Real


class PredictedParameter(Part):
    """What the recordings should tell of a parameter; ``ratio`` is the stated uncertainty over it."""

    predicted_standard_uncertainty: Real
    ratio: Real
    parts: list[PredictedPart]
    unit: str


class PredictedDelay(Part):
    """What they should tell of a relative delay."""

    nominal: float
    rotation_speed: Quantity
    predicted_standard_uncertainty: Real
    unit: str


class LikeCamera(Part):
    """The camera in the words of ``irtiming plan --like``; times in the unit."""

    camera: CameraType
    noise_to_contrast: Real
    opening_pixels: Real
    unit: str
    integration_time: Real = None
    time_constant: Real = None
    row_delay: Real = None


class Prediction(Part):
    """What the recordings should tell."""

    camera: LikeCamera
    parameters: dict[str, PredictedParameter]
    relative_delays: list[PredictedDelay]


class WheelTemperature(Quantity):
    """Temperature of the wheel, and who says so."""

    source: str = Field(alias="from")


class EffectiveConstant(Uncertain):
    """Time constant at one blackbody temperature, beside the model."""

    blackbody_temperature: float
    pixel_temperature: float
    temperature_unit: str
    model: Real


class TwoConstants(Part):
    """Time constants of substrate and scene."""

    parameters: dict[str, Parameter]
    bounds: dict[str, Bound]
    correlation: Correlation
    scene_share: Real
    least_share: Real
    substrate_temperature: Quantity
    wheel_temperature: WheelTemperature
    effective: list[EffectiveConstant]
    effective_correlation: list[list[Real]]


class NoiseCorrelation(Correlation):
    """What the noise of the frames alone does to the parameters."""

    standard_uncertainty: list[Real]
    trigger_delay_minus_time_constant: dict[str, Real | str]
    trigger_delay_plus_time_constant: dict[str, Real | str]
    unit: str


class Geometry(Part):
    """The rig as the analysis took it; angles in ``angle_unit``."""

    cutout_edges: list[float]
    cutout_edges_from: str
    beta_1: float
    beta_2: float
    gate_height: Quantity
    camera_roll: Real
    opening_angle: Real = None
    opening_angle_fitted: list[Real] = Field([])
    angle_unit: str


class WheelSpeed(Part):
    """A speed at which the wheel's slots were measured."""

    rotation_speed: float
    unit: str
    turns: int


class WheelOrder(Part):
    """One order of the slots' deviations."""

    order: int
    amplitude: Real
    standard_uncertainty: Real
    phase: Real
    separable_from_ripple: bool


class Ripple(Part):
    """Speed variation that repeats every turn, by order from 1."""

    reference_speed: Quantity
    amplitude_by_order: list[Real]
    standard_uncertainty_by_order: list[Real]
    chance_by_order: list[Real]
    chance: Real


class Wheel(Part):
    """The wheel's slots, gates and edges; angles in ``angle_unit``."""

    slots_from: list[str]
    speeds: list[WheelSpeed]
    rms_deviation: Real
    standard_uncertainty: Real
    orders: list[WheelOrder]
    ripple: Ripple | str
    gate_separation: Uncertain
    application_edges: Uncertains | None
    angle_unit: str


class RowFit(Part):
    """The fit of one recording, row by row; ``rows`` are the first and the last."""

    recording: str
    trigger_delay: Real
    time_constant: Real = None
    integration_time: Real = None
    row_delay: Real = None
    search_started_at: list[Real]
    steps: int
    rows: list[int]
    median_noise: Real
    widening: Real
    unit: str


class PublishedFit(Part):
    """The paper's fit of the recordings with one delay."""

    recordings: list[str]
    trigger_delay_time_set: float
    trigger_delay: Real
    time_constant: Real
    row_delay: Real
    time_constants_tried: list[Real]
    rms: list[Real]
    deviation_rms: Real
    unit: str


class ShutterEvent(Part):
    """Frames in which the camera's shutter is closed or which follow it."""

    first_frame: int
    end_frame: int
    kind: str


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


class Source(Part):
    """A file that went in."""

    file: str
    sha256: str


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
    findings: list[ResultFinding] = Field([])
    joint_fit: JointFit | None = None
    likelihood: Likelihood | None = None
    prediction: Prediction | None
    other_method: Core | None = None
    two_constants: TwoConstants | None = None
    noise_correlation: NoiseCorrelation | None = None
    geometry: Geometry
    wheel: Wheel | None
    opening: dict[str, Uncertain | bool | float | None] = Field({})
    fits: list[RowFit] = Field([])
    published_fits: list[PublishedFit] = Field([])
    choices: Settings
    inputs: list[Input]
    rig: Source
    software: dict[str, str]
