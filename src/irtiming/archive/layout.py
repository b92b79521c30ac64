"""Every path, class, unit, range and version of the recording file, in one table."""

from dataclasses import dataclass
from math import inf
from typing import Literal, final

VERSION = 1
"""Version of this layout, the attribute ``irtiming_layout`` of the entry; readers refuse a later one."""

VERSION_ATTRIBUTE = "irtiming_layout"
SUFFIX = ".nxs"
PART = ".part"
"""What a name ends in until its file is finished."""

SET_ASIDE, CONVERTED, APPLIED = "set-aside", "converted", "applied"
NOT_MEASURED = (SET_ASIDE, CONVERTED, APPLIED)
"""Folders of what is not analysed with the recordings beside them: those that are not whole, copies, what was made of others."""

REFERENCE_PAGE = "docs/reference/recording-file.md"

Kind = Literal["text", "number", "integer", "ticks", "index", "numbers", "frames"]


@final
@dataclass(frozen=True, kw_only=True)
class Field:
    """One dataset of the file.

    ``unit`` is the SI unit a number has inside the program; ``lowest`` and ``highest`` are limits in that
    unit, both allowed. ``fewest`` is the least number of entries of a tick stream. ``attribute`` is what a
    `Recording` calls it, empty where it has no such thing or not as it is.
    """

    path: str
    kind: Kind
    meaning: str
    attribute: str = ""
    unit: str = ""
    required: bool = False
    choices: tuple[str, ...] = ()
    lowest: float = -inf
    highest: float = inf
    fewest: int = 1

    @property
    def name(self) -> str:
        """Last part of the path."""
        return self.path.rsplit("/", 1)[1]

    @property
    def group(self) -> str:
        """Path without its last part."""
        return self.path.rsplit("/", 1)[0]


ENTRY = "/entry"
INSTRUMENT = f"{ENTRY}/instrument"
CAMERA = f"{INSTRUMENT}/camera"
CHOPPER = f"{INSTRUMENT}/chopper"
TRIGGER_GENERATOR = f"{INSTRUMENT}/trigger_generator"
BLACKBODY = f"{INSTRUMENT}/blackbody"
REFERENCE = f"{ENTRY}/nonuniformity_reference"
PLOT = f"{ENTRY}/data"
TRUTH = f"{ENTRY}/truth"
ACQUISITION = f"{ENTRY}/acquisition"

GROUPS = {
    ENTRY: "NXentry",
    INSTRUMENT: "NXinstrument",
    CAMERA: "NXdetector",
    CHOPPER: "NXdisk_chopper",
    TRIGGER_GENERATOR: "NXcollection",
    BLACKBODY: "NXcollection",
    REFERENCE: "NXcollection",
    PLOT: "NXdata",
    TRUTH: "NXcollection",
    ACQUISITION: "NXcollection",
}
"""Path of each group and its NeXus class."""

# fmt: off
TITLE = Field(
    path=f"{ENTRY}/title", kind="text", attribute="name", meaning="name of the recording; default: the file's name"
)
START_TIME = Field(path=f"{ENTRY}/start_time", kind="text", attribute="start_time", meaning="ISO 8601")
ENDING = Field(
    path=f"{ENTRY}/ending", kind="text", attribute="ending", meaning="'complete', or why the recording ended early"
)
PROGRAM_VERSION = Field(
    path=f"{ENTRY}/program_version", kind="text", attribute="program_version",
    meaning="program that recorded, and its version",
)
FRAMES = Field(path=f"{CAMERA}/data", kind="frames", required=True, meaning="frames as the camera gave them")
CAMERA_TYPE = Field(
    path=f"{CAMERA}/type", kind="text", attribute="camera_type", required=True, choices=("photon", "microbolometer"),
    meaning="kind of detector",
)
READOUT_MODE = Field(
    path=f"{CAMERA}/readout_mode", kind="text", attribute="readout_mode", required=True, choices=("snapshot", "rolling"),
    meaning="all rows at once, or one after the other",
)
INTEGRATION_TIME = Field(
    path=f"{CAMERA}/count_time", kind="number", attribute="integration_time_s", unit="s", lowest=1e-9, highest=10.0,
    meaning="integration time of a photon detector",
)
TRIGGER_DELAY_TIME_SET = Field(
    path=f"{CAMERA}/trigger_delay_time_set", kind="number",
    attribute="trigger_delay_time_set_s", unit="s", lowest=0.0, highest=60.0,
    meaning="extra delay set in the trigger generator; default 0",
)
BIT_DEPTH = Field(
    path=f"{CAMERA}/bit_depth_readout", kind="integer", attribute="bit_depth", lowest=1, highest=16,
    meaning="bits of a pixel value; default 16",
)
FRAME_NUMBER = Field(
    path=f"{CAMERA}/frame_number", kind="index", attribute="frame_number",
    meaning="index of the trigger that made each frame; default: frame i belongs to trigger i",
)
FRAME_STATUS = Field(
    path=f"{CAMERA}/frame_status", kind="index",
    meaning="0 whole, 1 damaged, 2 blank: nothing of it arrived, 3 whole but its trigger has no timestamp; default 0",
)
FRAME_ID = Field(
    path=f"{CAMERA}/frame_id", kind="index", attribute="frame_id",
    meaning="what the camera counted, from 0 when it was armed",
)
FRAME_TIMESTAMP = Field(
    path=f"{CAMERA}/frame_timestamp", kind="index", attribute="frame_timestamp_ticks", unit="ticks",
    meaning="ticks of the camera's own clock, 0: unknown",
)
TIMESTAMP_FREQUENCY = Field(
    path=f"{CAMERA}/timestamp_frequency", kind="number", attribute="timestamp_frequency_hz", unit="Hz", lowest=1.0, highest=1e12,
    meaning="ticks per second of the camera's own clock",
)
FRAME_HOST_TIME = Field(
    path=f"{CAMERA}/frame_host_time", kind="numbers", attribute="frame_host_time_s", unit="s",
    meaning="monotonic clock of the computer when the last of the frame had come",
)
FRAME_EVENT = Field(
    path=f"{CAMERA}/frame_event", kind="text", attribute="frame_event", choices=("trigger", "strobe", "stamp", "arrival"),
    meaning="what a frame's delay counts from; default 'trigger', the others where the camera runs free",
)
TIMESTAMP_CLOCK = Field(
    path=f"{CAMERA}/timestamp_clock", kind="text", attribute="timestamp_clock", choices=("camera", "computer"),
    meaning="whose time frame_timestamp is; default 'camera'",
)
CAMERA_EXCHANGE_BEFORE = Field(
    path=f"{CAMERA}/exchange_before", kind="numbers", attribute="camera_exchange_before_s", unit="s",
    meaning="clock of the computer just before each reading of the camera's clock",
)
CAMERA_EXCHANGE = Field(
    path=f"{CAMERA}/exchange_timestamp", kind="index", attribute="camera_exchange_ticks", unit="ticks",
    meaning="the camera's clock as it was read",
)
CAMERA_EXCHANGE_AFTER = Field(
    path=f"{CAMERA}/exchange_after", kind="numbers", attribute="camera_exchange_after_s", unit="s",
    meaning="clock of the computer just after each reading of the camera's clock",
)
CAMERA_VENDOR = Field(path=f"{CAMERA}/vendor", kind="text", meaning="who made the camera")
CAMERA_MODEL = Field(path=f"{CAMERA}/model", kind="text", meaning="model of the camera")
CAMERA_SERIAL_NUMBER = Field(path=f"{CAMERA}/serial_number", kind="text", meaning="serial number of the camera")
CAMERA_FIRMWARE = Field(path=f"{CAMERA}/firmware", kind="text", meaning="version of the camera's firmware")
CAMERA_ADDRESS = Field(path=f"{CAMERA}/address", kind="text", meaning="address at which the camera was reached")
GAIN_SETTING = Field(path=f"{CAMERA}/gain_setting", kind="text", meaning="gain mode, in the camera's own words")
INTERNAL_DELAY_SET = Field(
    path=f"{CAMERA}/internal_delay_set", kind="number", unit="s", lowest=0.0, highest=60.0,
    meaning="delay set in the camera itself, between the edge that it accepts and its start",
)
SENSOR_TEMPERATURE = Field(
    path=f"{CAMERA}/sensor_temperature", kind="number", unit="K", lowest=1.0, highest=500.0,
    meaning="temperature of the focal plane array",
)
REGION_FIRST_ROW = Field(
    path=f"{CAMERA}/region_first_row", kind="integer", lowest=0, highest=2.0**31,
    meaning="row of the sensor that is row 0 of the image",
)
REGION_FIRST_COLUMN = Field(
    path=f"{CAMERA}/region_first_column", kind="integer", lowest=0, highest=2.0**31,
    meaning="column of the sensor that is column 0 of the image",
)
ROTATION_SPEED = Field(
    path=f"{CHOPPER}/rotation_speed", kind="number",
    attribute="rotation_speed_hz", unit="Hz", required=True, lowest=1e-3, highest=1e4,
    meaning="nominal turns of the wheel per second",
)
CLOCK_FREQUENCY = Field(
    path=f"{TRIGGER_GENERATOR}/clock_frequency", kind="number",
    attribute="clock_frequency_hz", unit="Hz", required=True, lowest=1e3, highest=1e12,
    meaning="ticks per second of the counter",
)
CAMERA_TRIGGER = Field(
    path=f"{TRIGGER_GENERATOR}/camera_trigger", kind="ticks", attribute="camera_trigger_ticks", unit="ticks", required=True,
    meaning="nominal trigger, before trigger_delay_time_set is added; none where the camera runs free",
)
CONTROL_SLOT = Field(
    path=f"{TRIGGER_GENERATOR}/control_slot", kind="ticks", attribute="control_slot_ticks", unit="ticks", required=True, fewest=2,
    meaning="control slots passing their light gate",
)
APPLICATION_SLOT = Field(
    path=f"{TRIGGER_GENERATOR}/application_slot", kind="ticks",
    attribute="application_slot_ticks", unit="ticks", required=True, fewest=2,
    meaning="cutout edges 0 and 2 passing the application gate",
)
APPLICATION_EDGES = Field(
    path=f"{TRIGGER_GENERATOR}/application_edges", kind="ticks", attribute="application_edge_ticks", unit="ticks", fewest=2,
    meaning="all four cutout edges passing the application gate",
)
LOST_AFTER = Field(
    path=f"{TRIGGER_GENERATOR}/lost_after", kind="ticks", attribute="lost_after_ticks", unit="ticks", fewest=0,
    meaning="last known time before each loss of timestamps; empty: none was lost, absent: not known",
)
CAMERA_TRIGGER_DELAYED = Field(
    path=f"{TRIGGER_GENERATOR}/camera_trigger_delayed", kind="ticks",
    attribute="camera_trigger_delayed_ticks", unit="ticks", fewest=0,
    meaning="triggers as the camera got them, trigger_delay_time_set after the nominal ones",
)
CAMERA_INPUT = Field(
    path=f"{TRIGGER_GENERATOR}/camera_input", kind="ticks", attribute="camera_input_ticks", unit="ticks", fewest=0,
    meaning="edges that the camera sent back",
)
SPARE = Field(
    path=f"{TRIGGER_GENERATOR}/spare", kind="ticks", attribute="spare_ticks", unit="ticks", fewest=0,
    meaning="edges of the spare input: a pulse per second, a second photodiode, or a trigger that is led back",
)
COUNTER_EXCHANGE_BEFORE = Field(
    path=f"{TRIGGER_GENERATOR}/exchange_before", kind="numbers", attribute="counter_exchange_before_s", unit="s",
    meaning="clock of the computer just before each reading of the counter",
)
COUNTER_EXCHANGE = Field(
    path=f"{TRIGGER_GENERATOR}/exchange_counter", kind="index", attribute="counter_exchange_ticks", unit="ticks",
    meaning="the counter as it was read",
)
COUNTER_EXCHANGE_AFTER = Field(
    path=f"{TRIGGER_GENERATOR}/exchange_after", kind="numbers", attribute="counter_exchange_after_s", unit="s",
    meaning="clock of the computer just after each reading of the counter",
)
CAMERA_PERIOD = Field(
    path=f"{TRIGGER_GENERATOR}/camera_period", kind="integer",
    attribute="camera_period_ticks", unit="ticks", lowest=1, highest=2.0**62,
    meaning="ticks from trigger to trigger, C of the trigger scheme",
)
WHEEL_PERIOD = Field(
    path=f"{TRIGGER_GENERATOR}/wheel_period", kind="integer",
    attribute="wheel_period_ticks", unit="ticks", lowest=1, highest=2.0**62,
    meaning="ticks of a turn of the wheel, T of the trigger scheme",
)
BLACKBODY_TEMPERATURE = Field(
    path=f"{BLACKBODY}/temperature", kind="number", attribute="blackbody_temperature_k", unit="K", lowest=100.0, highest=5000.0,
    meaning="blackbody temperature while recording",
)
REFERENCE_LOW = Field(path=f"{REFERENCE}/low", kind="frames", meaning="bare blackbody, colder")
REFERENCE_HIGH = Field(path=f"{REFERENCE}/high", kind="frames", meaning="bare blackbody, warmer")
# fmt: on

ACQUISITION_MODE = f"{CAMERA}/acquisition_mode"
NEXUS_NEIGHBOURS = ("trigger_delay_time", "trigger_internal_delay_time", "frame_start_number", "frame_time")
"""Names of NeXus that resemble a field of ours but are not meant as one."""

TEMPERATURE_ATTRIBUTE = "temperature"
TEMPERATURE_UNITS_ATTRIBUTE = "temperature_units"

FIELDS = (
    TITLE, START_TIME, ENDING, PROGRAM_VERSION,
    FRAMES, CAMERA_TYPE, READOUT_MODE, INTEGRATION_TIME, TRIGGER_DELAY_TIME_SET, BIT_DEPTH, FRAME_NUMBER,
    FRAME_STATUS, FRAME_ID, FRAME_TIMESTAMP, TIMESTAMP_FREQUENCY, FRAME_HOST_TIME, FRAME_EVENT, TIMESTAMP_CLOCK,
    CAMERA_EXCHANGE_BEFORE, CAMERA_EXCHANGE, CAMERA_EXCHANGE_AFTER,
    CAMERA_VENDOR, CAMERA_MODEL, CAMERA_SERIAL_NUMBER, CAMERA_FIRMWARE, CAMERA_ADDRESS,
    GAIN_SETTING, INTERNAL_DELAY_SET, SENSOR_TEMPERATURE, REGION_FIRST_ROW, REGION_FIRST_COLUMN,
    ROTATION_SPEED,
    CLOCK_FREQUENCY, CAMERA_TRIGGER, CONTROL_SLOT, APPLICATION_SLOT, APPLICATION_EDGES, LOST_AFTER,
    CAMERA_TRIGGER_DELAYED, CAMERA_INPUT, SPARE,
    COUNTER_EXCHANGE_BEFORE, COUNTER_EXCHANGE, COUNTER_EXCHANGE_AFTER,
    CAMERA_PERIOD, WHEEL_PERIOD,
    BLACKBODY_TEMPERATURE,
    REFERENCE_LOW, REFERENCE_HIGH,
)  # fmt: skip
"""Every field that this program reads, in the order in which it is checked."""

IDENTITY = (CAMERA_VENDOR, CAMERA_MODEL, CAMERA_SERIAL_NUMBER, CAMERA_FIRMWARE, CAMERA_ADDRESS)
"""What a camera says of itself; each is named as in `CameraIdentity`."""

SETTINGS = {
    "gain_setting": GAIN_SETTING, "internal_delay_set_s": INTERNAL_DELAY_SET, "sensor_temperature_k": SENSOR_TEMPERATURE,
    "region_first_row": REGION_FIRST_ROW, "region_first_column": REGION_FIRST_COLUMN,
}  # fmt: skip
"""What a camera was set to, by the names of `CameraSettings`."""

PER_FRAME = (FRAME_NUMBER, FRAME_ID, FRAME_TIMESTAMP, FRAME_HOST_TIME)
"""Columns with one entry per frame, its status apart."""

EXCHANGES = (
    (CAMERA_EXCHANGE_BEFORE, CAMERA_EXCHANGE, CAMERA_EXCHANGE_AFTER),
    (COUNTER_EXCHANGE_BEFORE, COUNTER_EXCHANGE, COUNTER_EXCHANGE_AFTER),
)
"""Readings of a clock between two readings of the computer's: before, ticks, after."""

COMPLETE = "complete"
"""What `ENDING` says of a recording that ended as planned."""

NOT_TRUSTED = "not trusted: "
"""What `ENDING` begins with where frames cannot be given their triggers beyond doubt: it can be read by eye, not analysed."""

KILLED = "interrupted: the program that recorded it was stopped before its end"
"""`ENDING` of a recording whose writer could not say why, where a person trusts it."""

UNPROVEN = f"{NOT_TRUSTED}{KILLED}, and did not prove that its first frame belongs to the first trigger"
"""`ENDING` of such a recording otherwise: the proof comes with the last frame."""

UNITS: dict[str, dict[str, float]] = {
    "s": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "µs": 1e-6, "μs": 1e-6, "ns": 1e-9},
    "Hz": {"Hz": 1.0, "mHz": 1e-3, "kHz": 1e3, "MHz": 1e6, "GHz": 1e9},
    "K": {"K": 1.0, "mK": 1e-3},
}
"""Spellings of each unit that the attribute ``units`` may have, and the factor to SI."""

TICK_UNITS = ("", "1", "tick", "ticks", "count", "counts")
"""What the attribute ``units`` of a tick stream may say."""

HDF5_FORMAT = ("v110", "v110")
"""Oldest and newest HDF5 format that is written: every HDF5 since 1.10 (2016) reads it."""

BLOCK_BYTES = 32 * 2**20
"""At most this much of a stack of frames is in memory at a time (a larger chunk excepted)."""
