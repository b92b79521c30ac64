"""plan.toml: what it says in SI units, and one line for whatever is wrong with it."""

import hashlib

import pytest

from irtiming.archive.series_file import DEFAULT_NAME, read_series
from irtiming.errors import ArchiveError
from irtiming.records.series_plan import (
    BlackbodyWishes,
    CameraWishes,
    DeviceAddresses,
    ReferenceWishes,
    StopWishes,
    TriggerWishes,
    WiringWishes,
)

LEAST = """
[devices]
camera = "gige:127.0.0.2"
trigger_generator = "/dev/ttyUSB1"

[camera]
type = "photon"

[series]
plan = "plan.json"
"""

ALL = """
[devices]
camera = "gige:127.0.0.2"
trigger_generator = "/dev/ttyUSB1"
chopper = "mc2000b:/dev/ttyUSB0"
blackbody = "sr800r:tcp:host:5200"
speed = 4

[camera]
type = "photon"
readout_mode = "rolling"
integration_time = "250 us"
bit_depth = 14
features = {TriggerSource = "Line1", Gain = 1.5, ReverseX = true}
serial_number = "SN1"

[wiring]
falling = ["control_slot", "camera_output"]
glitch_filter = "1 us"
camera_pulse = "2 ms"
camera_input = true
spare = true

[series]
wheel_hz = [3, 9]
frame_hz = 30.303
samples = 1000
delays = ["0 s", "25 ms"]
repeats = 2

[blackbody]
temperature = "60 C"
settle_within = "20 min"
tolerance = "50 mK"

[references]
low = "25 C"
high = "60 C"
frames = 20
when = "both"
command = "move-wheel"

[stop]
chopper = true
uncertainty = {trigger_delay = "0.5 us"}

[files]
name = "{utc}_r{run}.nxs"
"""


@pytest.fixture
def written(tmp_path):
    """Return a function that writes a plan.toml and gives its path."""

    def write(text):
        path = tmp_path / "plan.toml"
        path.write_text(text)
        return path

    return write


def test_every_key_is_read(written):
    """Oracle: the text above, converted by hand."""
    path = written(ALL)
    plan = read_series(path)
    assert plan.devices == DeviceAddresses(
        camera="gige:127.0.0.2",
        trigger_generator="/dev/ttyUSB1",
        chopper="mc2000b:/dev/ttyUSB0",
        blackbody="sr800r:tcp:host:5200",
        speed=4.0,
    )
    assert plan.camera == CameraWishes(
        camera_type="photon",
        readout_mode="rolling",
        integration_time_s=pytest.approx(250e-6),
        bit_depth=14,
        features=(("TriggerSource", "Line1"), ("Gain", "1.5"), ("ReverseX", "true")),
        serial_number="SN1",
    )
    assert plan.wiring == WiringWishes(
        falling=("control_slot", "camera_output"),
        glitch_filter_s=pytest.approx(1e-6),
        camera_pulse_s=pytest.approx(2e-3),
        camera_input=True,
        spare=True,
    )
    assert plan.triggers == TriggerWishes(
        wheel_hz=("3", "9"), frame_hz="30.303", samples="1000", delays=("0 s", "25 ms"), repeats="2"
    )
    assert plan.blackbody == BlackbodyWishes(
        temperatures_k=(pytest.approx(333.15),), settle_within_s=1200.0, tolerance_k=pytest.approx(0.05)
    )
    assert plan.references == ReferenceWishes(
        low_k=pytest.approx(298.15), high_k=pytest.approx(333.15), frames=20, when="both", command="move-wheel"
    )
    assert plan.stop == StopWishes(chopper=True, uncertainty_s=(("trigger_delay", pytest.approx(0.5e-6)),))
    assert plan.file_name == "{utc}_r{run}.nxs"
    assert plan.sha256 == hashlib.sha256(path.read_bytes()).hexdigest()


def test_the_least_plan(written, tmp_path):
    """Oracle: the defaults of the records; a plan beside the file is found from its folder."""
    plan = read_series(written(LEAST))
    assert plan.plan_file == str(tmp_path / "plan.json")
    assert plan.triggers is plan.blackbody is plan.references is None
    assert plan.file_name == DEFAULT_NAME
    assert plan.wiring == WiringWishes()
    assert plan.stop == StopWishes()


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (("[camera]", "[kamera]"), r"\[kamera\] is not a section of plan.toml; did you mean 'camera'\?"),
        (("type =", "typ ="), r"\[camera\] typ is not a key of this section; did you mean 'type'\?"),
        (('"photon"', '"foton"'), r"type is 'foton'; it must be photon or microbolometer, did you mean 'photon'\?"),
        (
            ('"photon"', '"photon"\nreadout_mode = "roling"'),
            r"'roling'; it must be snapshot or rolling, did you mean 'rolling'",
        ),
        (('"photon"', "3"), r"\[camera\] type is 3; it must be text"),
        (('camera = "gige:127.0.0.2"', ""), r"\[devices\] camera is missing; write camera = "),
        (('"photon"', '"photon"\nintegration_time = "250"'), r"integration_time cannot be read; '250' has no unit"),
        (('"photon"', '"photon"\nintegration_time = 250'), r"integration_time is 250; it must be text with a unit"),
        (('"photon"', '"photon"\nintegration_time = "20 min"'), r"= 20 min; it must be from 1 ns to 10 s"),
        (('"photon"', '"microbolometer"\nintegration_time = "1 ms"'), "only a photon camera has one"),
        (('"photon"', '"photon"\nbit_depth = 17'), "bit_depth = 17; it must be from 1 to 16"),
        (('"photon"', '"photon"\nfeatures = "x"'), "features is 'x'; it must be a table"),
        (('"photon"', '"photon"\nfeatures = {A = [1]}'), r"features.A is \[1\]; it must be text"),
        (('plan = "plan.json"', ""), "wheel_hz is missing"),
        (('"plan.json"', '"plan.json"\nsamples = 10'), "plan stands beside samples; name a plan, or wish"),
        (
            ("[series]", "[wiring]\nfalling = [1]\n[series]"),
            r"falling\[0\] is 1; it must be text, such as \"control_slot\"",
        ),
        (("[series]", '[blackbody]\ntemperature = "60 C"\n[series]'), r"but \[devices\] names no blackbody"),
        (("[series]", '[references]\nlow = "60 C"\nhigh = "25 C"\n[series]'), "low must be the colder one"),
        (("[series]", '[references]\nlow = "2 C"\nhigh = "25 C"\n[series]'), "needs a blackbody that can be set"),
        (("[series]", '[references]\nfile = "a.nxs"\nhigh = "25 C"\n[series]'), "file stands beside high"),
        (("[series]", "[stop]\nchopper = true\n[series]"), r"\[devices\] names no chopper"),
        (("[series]", "[stop]\nchopper = 1\n[series]"), "chopper is 1; it must be true or false"),
        (("[series]", '[stop]\nuncertainty = {trigger_delay = "0 s"}\n[series]'), "it must be more than 0"),
        (("[series]", '[files]\nname = "a.nxs"\n[series]'), r"it must have \{run\} in it"),
        (("[series]", '[files]\nname = "{rum}.nxs"\n[series]'), r"has \{rum\}; it must be .* did you mean 'run'\?"),
        (("[series]", '[files]\nname = "{run.nxs"\n[series]'), "its braces do not match"),
        (("[series]", '[files]\nname = "../{run}.nxs"\n[series]'), "a name without folder that ends in .nxs"),
        (('"/dev/ttyUSB1"', '"/dev/ttyUSB1"\nspeed = 0'), "speed is 0; it must be from 0.001 to 1000"),
        (("[series]", "[series"), "is not valid TOML"),
    ],
)
def test_each_complaint_is_one_line_with_a_cure(written, change, says):
    """Oracle: one thing broken in a plan that is good; the words for it."""
    assert change[0] in LEAST
    with pytest.raises(ArchiveError, match=says) as error:
        read_series(written(LEAST.replace(*change, 1)))
    assert "\n" not in str(error.value)
    assert str(error.value).count("plan.toml")


def test_a_file_that_is_not_there(tmp_path):
    """Oracle: the words."""
    with pytest.raises(ArchiveError, match=r"plan.toml: does not exist; name the plan.toml"):
        read_series(tmp_path / "plan.toml")
    with pytest.raises(ArchiveError, match="is a folder"):
        read_series(tmp_path)
