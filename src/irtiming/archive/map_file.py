"""Maps of every pixel's timing as HDF5: one NXdata for each map, with its standard uncertainties, rows and columns as axes."""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import h5py
import numpy as np

from irtiming.archive.hdf5_output import whole_hdf5
from irtiming.archive.layout import ENTRY
from irtiming.records.arrays import Array
from irtiming.records.pixel_maps import LineMeans, PixelMaps

VERSION = 1
"""Of this layout, the attribute ``irtiming_maps`` of the entry."""

_TITLES = {
    "delay": "delay of each pixel, by its own phases",
    "deviation": "delay less what the fit over all rows says",
    "time_constant": "time constant",
    "contrast": "from covered to open",
    "noise": "standard deviation from frame to frame",
    "shape": "what errors of the opening's shape, which all pixels share, add to the delay's uncertainty",
    "correlation": "of the errors by noise of delay and time constant",
}
_MASKS = ("is_border", "is_dead", "is_deviating")


def write_maps(maps: PixelMaps, path: str | Path, *, recordings: Sequence[str] = ()) -> None:
    """Write maps; a file of that name is replaced when the new one is whole.

    Parameters
    ----------
    maps
        Of one camera.
    path
        The file to make.
    recordings
        Files that the maps come from.

    Raises
    ------
    ArchiveError
        If it cannot be written.
    """
    with whole_hdf5(path) as file:
        _fill(file, maps, recordings)


def _fill(file: h5py.File, maps: PixelMaps, recordings: Sequence[str]) -> None:
    entry = file.create_group(ENTRY)
    file.attrs["default"], entry.attrs["default"] = ENTRY.strip("/"), "delay"
    entry.attrs["NX_class"], entry.attrs["irtiming_maps"] = "NXentry", VERSION
    entry["title"] = f"{maps.delay_name} of every pixel"
    entry["recordings"] = np.array(list(recordings), dtype=h5py.string_dtype())
    for name, (image, errors, unit) in _images(maps):
        _image(entry, name, maps=maps, image=image, errors=errors, unit=unit)
    _masks(entry, maps)
    _lines(entry, "rows", maps.rows, axis="row")
    _lines(entry, "columns", maps.columns, axis="column")
    common = entry.create_group("common")
    common.attrs["NX_class"] = "NXcollection"
    common.attrs["description"] = "what all pixels share: not in the uncertainties of single pixels"
    for name, value, unit in _common(maps):
        common.create_dataset(name, data=value).attrs["units"] = unit
    common["unseen_rows"] = maps.unseen_row_px
    common["findings"] = np.array([f"{one.code}: {one.sentence()}" for one in maps.findings], dtype=h5py.string_dtype())


def _images(maps: PixelMaps) -> Iterator[tuple[str, tuple[Array, Array | None, str]]]:
    yield "delay", (maps.delay_s, maps.u_delay_s, "s")
    yield "deviation", (maps.deviation_s, maps.u_delay_s, "s")
    yield "contrast", (maps.contrast_dn, maps.u_contrast_dn, "DN")
    yield "noise", (maps.noise_dn, None, "DN")
    yield "shape", (maps.u_shape_s, None, "s")
    if maps.time_constant_s is not None and maps.correlation is not None:
        yield "time_constant", (maps.time_constant_s, maps.u_time_constant_s, "s")
        yield "correlation", (maps.correlation, None, "1")


def _image(entry: h5py.Group, name: str, *, maps: PixelMaps, image: Array, errors: Array | None, unit: str) -> None:
    data = _nx_data(entry, name, title=_TITLES[name], axes=("row", "column"))
    data.create_dataset(name, data=image, compression="gzip").attrs["units"] = unit
    if errors is not None:
        data.create_dataset(f"{name}_errors", data=errors, compression="gzip").attrs["units"] = unit
    _axes(data, {"row": np.arange(*maps.roi[:2]), "column": np.arange(*maps.roi[2:])})


def _masks(entry: h5py.Group, maps: PixelMaps) -> None:
    """One byte for each pixel: 1 of the border, 2 dead, 4 deviating, added up."""
    data = _nx_data(entry, "status", title="1 near the border, 2 dead, 4 deviating, added up", axes=("row", "column"))
    value = sum(2**k * getattr(maps, name).astype(np.uint8) for k, name in enumerate(_MASKS))
    data.create_dataset("status", data=value, compression="gzip")
    _axes(data, {"row": np.arange(*maps.roi[:2]), "column": np.arange(*maps.roi[2:])})


def _lines(entry: h5py.Group, name: str, means: LineMeans, *, axis: str) -> None:
    data = _nx_data(entry, name, title=f"means over {name}", axes=(axis,), signal="delay")
    fields = {
        "delay": (means.delay_s, "s"), "delay_errors": (means.u_delay_s, "s"), "deviation": (means.deviation_s, "s"),
        "n_pixels": (means.n_pixels, "1"), "time_constant": (means.time_constant_s, "s"),
        "time_constant_errors": (means.u_time_constant_s, "s"),
    }  # fmt: skip
    for field, (values, unit) in fields.items():
        if values is not None:
            data.create_dataset(field, data=values).attrs["units"] = unit
    _axes(data, {axis: means.line_px})


def _nx_data(
    entry: h5py.Group, name: str, *, title: str, axes: tuple[str, ...], signal: str | None = None
) -> h5py.Group:
    data = entry.create_group(name)
    data.attrs["NX_class"], data.attrs["signal"] = "NXdata", signal or name
    data.attrs["axes"] = np.array(axes, dtype=h5py.string_dtype())
    data["title"] = title
    return data


def _axes(data: h5py.Group, places: Mapping[str, np.ndarray]) -> None:
    for axis, values in places.items():
        data.create_dataset(axis, data=values).attrs["units"] = "px"


def _common(maps: PixelMaps) -> Iterator[tuple[str, float, str]]:
    yield "delay_errors", maps.u_common_delay_s, "s"
    if maps.u_common_time_constant_s is not None:
        yield "time_constant_errors", maps.u_common_time_constant_s, "s"
    yield "row_delay", maps.row_delay_s, "s"
    yield "row_delay_errors", maps.u_row_delay_s, "s"
    yield "fitted_row_delay", maps.fitted_row_delay_s, "s"
    yield "reduced_chi_square", maps.reduced_chi_square, "1"
    yield "noise_degrees_of_freedom", maps.noise_degrees_of_freedom, "1"
    for one in maps.patterns:
        name = one.name.replace(" ", "_")
        yield f"{name}_later", one.later_s, "s"
        yield f"{name}_later_errors", one.u_later_s, "s"
