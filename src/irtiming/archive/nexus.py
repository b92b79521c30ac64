"""Groups, stacks and attributes as every file of this program has them, and bringing such a file to the disk."""

import os
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

import h5py
import hdf5plugin
import numpy as np

from irtiming.archive import layout
from irtiming.archive.layout import Field


def group(file: h5py.File, path: str) -> h5py.Group:
    """Group of that path, made with its NeXus class and its parents where it is not there yet."""
    if path not in file:
        parent = path.rsplit("/", 1)[0]
        if parent:
            group(file, parent)
        file.create_group(path).attrs["NX_class"] = layout.GROUPS[path]
    return file[path]


def set_units(dataset: h5py.Dataset, unit: str) -> None:
    """Say the unit of a dataset; "" for one that has none."""
    if unit:
        dataset.attrs["units"] = unit


def create_stack(file: h5py.File, field: Field, *, size: tuple[int, int], dtype: str = "uint16") -> h5py.Dataset:
    """Empty stack of frames of that many rows and columns: one per chunk, compressed and guarded by a checksum."""
    return group(file, field.group).create_dataset(
        field.name,
        shape=(0, *size),
        maxshape=(None, *size),
        chunks=(1, *size),
        dtype=np.dtype(dtype),
        fletcher32=True,
        **hdf5plugin.Bitshuffle(cname="lz4"),
    )


def set_temperature(file: h5py.File, field: Field, *, temperature_k: float | None) -> None:
    """Say at which temperature a reference stack was recorded, K; nothing where it is not known or not there."""
    if temperature_k is not None and field.path in file:
        file[field.path].attrs[layout.TEMPERATURE_ATTRIBUTE] = float(temperature_k)
        file[field.path].attrs[layout.TEMPERATURE_UNITS_ATTRIBUTE] = "K"


def describe_for_viewers(file: h5py.File) -> None:
    """NeXus attributes by which a viewer finds the frames and plots them against their number."""
    file.attrs["default"] = "entry"
    file.attrs["creator"] = program_version()
    entry = file[layout.ENTRY]
    entry.attrs["default"] = "data"
    entry.attrs[layout.VERSION_ATTRIBUTE] = layout.VERSION
    plot = group(file, layout.PLOT)
    for field in (layout.FRAMES, layout.FRAME_NUMBER):
        file[field.path].attrs["target"] = field.path
        plot[field.name] = file[field.path]
    plot.attrs["signal"] = layout.FRAMES.name
    plot.attrs["axes"] = [layout.FRAME_NUMBER.name, ".", "."]
    plot.attrs[f"{layout.FRAME_NUMBER.name}_indices"] = 0


def program_version() -> str:
    """Name of the program and its version."""
    try:
        return f"irtiming {version('irtiming')}"
    except PackageNotFoundError:
        return "irtiming not installed"


def bring_to_disk(path: Path) -> None:
    """Return when the disk itself has the file.

    Raises
    ------
    OSError
        If it cannot be written.
    """
    descriptor = os.open(path, os.O_RDWR)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
