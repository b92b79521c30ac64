"""Reading one field of a recording with every check that needs no other field."""

import math
from difflib import get_close_matches
from typing import Any

import h5py
import numpy as np

from irtiming.archive import layout
from irtiming.archive.finding import refuse
from irtiming.archive.hdf5_file import damage_at, missing_filters
from irtiming.archive.layout import Field
from irtiming.records.arrays import Array, Ticks, read_only
from irtiming.records.finding import Finding

_LARGEST_INTEGER = 2**62
_NOT_THERE = ("doesn't exist", "component not found", "not found")


def read_field(file: h5py.File, field: Field) -> Any:
    """Value of one field in SI units, None where an optional field is absent.

    Text gives str, a number float, an integer int, ticks and indices a read-only int64 array (n,), frames
    their shape (frame, row, column): the frames themselves are streamed by `FileFrames`. Numbers give a read-only float
    array (n,).

    Raises
    ------
    Complaint
        If a required field is missing, or its type, shape, unit, filter or value is not as in the layout.
    """
    dataset = _find(file, field)
    if dataset is None:
        return None
    match field.kind:
        case "text":
            return _text(dataset, field)
        case "number":
            return _number(dataset, field)
        case "integer":
            return _integer(dataset, field)
        case "ticks" | "index":
            return _integers(dataset, field)
        case "numbers":
            return _numbers(dataset, field)
        case "frames":
            return _frame_shape(dataset, field)


def read_temperature(file: h5py.File, field: Field) -> float | None:
    """Temperature in K that stands as an attribute beside reference frames, None where it is absent.

    Raises
    ------
    Complaint
        If it is no number, in another unit than K, or outside the range of the blackbody temperature.
    """
    where = f"{field.path}@{layout.TEMPERATURE_ATTRIBUTE}"
    with damage_at(where):
        attributes = dict(file[field.path].attrs)
    if layout.TEMPERATURE_ATTRIBUTE not in attributes:
        return None
    value = np.asarray(attributes[layout.TEMPERATURE_ATTRIBUTE])
    if value.size != 1 or value.dtype.kind not in "iuf":
        raise refuse(
            where, f"is {value.tolist()!r}", code="temperature-not-a-number", cure="it must be one number in kelvin"
        )
    unit = attributes.get(layout.TEMPERATURE_UNITS_ATTRIBUTE, "K")
    limits = layout.BLACKBODY_TEMPERATURE
    return _in_range(float(value.reshape(())) * _factor(where, unit, expected="K"), limits, where=where)


def near_misses(file: h5py.File) -> list[Finding]:
    """Warn of every optional field that is absent while a name much like it stands in its place."""
    findings = []
    for group_path in layout.GROUPS:
        fields = {field.name: field for field in layout.FIELDS if field.group == group_path}
        with damage_at(group_path):
            group = file.get(group_path)
            names = list(group) if isinstance(group, h5py.Group) else []
        strangers = [name for name in names if name not in fields and name not in layout.NEXUS_NEIGHBOURS]
        for name, field in fields.items():
            near = [] if name in names else get_close_matches(name, strangers, n=1, cutoff=0.8)
            if near:
                what = f"is absent, but there is '{near[0]}'"
                cure = f"rename it if it is meant: {field.meaning}"
                findings.append(
                    Finding(code="field-misspelt", severity="warning", where=field.path, what=what, cure=cure)
                )
    return findings


def _find(file: h5py.File, field: Field) -> h5py.Dataset | None:
    try:
        item = file[field.path]
    except KeyError as error:
        if any(words in str(error) for words in _NOT_THERE):
            _complain_if_required(file, field)
            return None
        with damage_at(field.path):
            raise
    except (OSError, RuntimeError, ValueError):
        with damage_at(field.path):
            raise
    if not isinstance(item, h5py.Dataset):
        raise refuse(field.path, "is a group", code="not-a-dataset", cure=f"it must be a dataset: {field.meaning}")
    with damage_at(field.path):
        _ = item.dtype, item.shape, item.chunks  # h5py makes them when asked, and throws if they are damaged
    return item


def _complain_if_required(file: h5py.File, field: Field) -> None:
    if not _is_required(file, field):
        return
    names: list[str] = []
    with damage_at(field.group):
        group = file.get(field.group)
        if isinstance(group, h5py.Group):
            names = list(group)
    near = get_close_matches(field.name, names, n=1)
    hint = f"the file has '{near[0]}' there, rename it" if near else f"write it, see {layout.REFERENCE_PAGE}"
    raise refuse(field.path, f"is missing ({field.meaning})", code="field-missing", cure=hint)


def _is_required(file: h5py.File, field: Field) -> bool:
    """Whether the field must be there: a camera that runs free has no triggers."""
    if field is not layout.CAMERA_TRIGGER:
        return field.required
    with damage_at(layout.FRAME_EVENT.path):
        if layout.FRAME_EVENT.path not in file:
            return field.required
    return read_field(file, layout.FRAME_EVENT) == "trigger"


def _text(dataset: h5py.Dataset, field: Field) -> str:
    with damage_at(field.path):
        value = dataset[()]
    text = as_text(value)
    if text is None:
        raise refuse(field.path, f"is {_kind_of(dataset)}", code="not-text", cure="it must be one text in UTF-8")
    if field.choices and text not in field.choices:
        near = get_close_matches(text.lower(), field.choices, n=1)
        words = " or ".join(f"'{word}'" for word in field.choices)
        hint = f", did you mean '{near[0]}'?" if near else ""
        raise refuse(field.path, f"is '{text[:40]}'", code="not-a-choice", cure=f"it must be {words}{hint}")
    return text


def as_text(value: Any) -> str | None:
    """Text from what h5py gives for one string: bytes, str, or an array of one; None if it is no text."""
    if isinstance(value, np.ndarray):
        if value.size != 1:
            return None
        value = value.reshape(-1)[0]
    if isinstance(value, bytes):
        try:
            return value.decode("utf-8").rstrip("\0")
        except UnicodeDecodeError:
            return None
    return str(value) if isinstance(value, str) else None


def _number(dataset: h5py.Dataset, field: Field) -> float:
    factor = _factor(field.path, _units(dataset, field), expected=field.unit)
    return _in_range(float(_one(dataset, field, kinds="iuf")) * factor, field, where=field.path)


def _integer(dataset: h5py.Dataset, field: Field) -> int:
    _refuse_other_than_ticks(dataset, field)
    value = int(_one(dataset, field, kinds="iu"))
    _in_range(value, field, where=field.path)
    return value


def _one(dataset: h5py.Dataset, field: Field, *, kinds: str) -> Any:
    sort = "an integer" if kinds == "iu" else "a number"
    if dataset.size != 1 or dataset.dtype.kind not in kinds:
        raise refuse(
            field.path, f"is {_kind_of(dataset)}", code="not-a-number", cure=f"it must be {sort}: {field.meaning}"
        )
    with damage_at(field.path):
        return np.asarray(dataset[()]).reshape(())[()]


def _in_range(value: float, limits: Field, *, where: str) -> float:
    unit = f" {limits.unit}" if limits.unit else ""
    if not math.isfinite(value):
        raise refuse(
            where, f"is {value}", code="not-finite", cure=f"it must be a finite number{f' in{unit}' if unit else ''}"
        )
    if not limits.lowest <= value <= limits.highest:
        raise refuse(
            where,
            f"= {value:.12g}{unit} is out of range",
            code="out-of-range",
            cure=f"it must be from {limits.lowest:g} to {limits.highest:g}{unit}: check value and unit",
        )
    return value


def _units(dataset: h5py.Dataset, field: Field) -> Any:
    with damage_at(f"{field.path}@units"):
        return dataset.attrs.get("units", field.unit)


def _factor(where: str, unit: Any, *, expected: str) -> float:
    text = as_text(unit)
    known = layout.UNITS[expected]
    if text is None or text not in known:
        shown = unit if text is None else text
        raise refuse(
            where,
            f"is in '{shown}'",
            code="unit-unknown",
            cure=f"it must be in {expected} (or {', '.join(list(known)[1:])})",
        )
    return known[text]


def _numbers(dataset: h5py.Dataset, field: Field) -> Array:
    factor = _factor(field.path, _units(dataset, field), expected=field.unit)
    if dataset.dtype.kind not in "iuf" or dataset.ndim != 1:
        raise refuse(
            field.path,
            f"is {_kind_of(dataset)}",
            code="not-a-list-of-numbers",
            cure="it must be a list of numbers, one dimension",
        )
    _refuse_unwritten(dataset, field)
    with damage_at(field.path):
        return read_only(np.asarray(dataset[()], dtype=np.float64) * factor)


def _integers(dataset: h5py.Dataset, field: Field) -> Ticks | None:
    if dataset.dtype.kind not in "iu" or dataset.ndim != 1:
        raise refuse(
            field.path,
            f"is {_kind_of(dataset)}",
            code="not-a-list-of-integers",
            cure="it must be a list of integers (int64), one dimension",
        )
    _refuse_other_than_ticks(dataset, field)
    if field.kind == "ticks" and dataset.size < field.fewest:
        if dataset.size == 0 and not _is_required(dataset.file, field):
            return None  # nothing is connected to that input
        raise refuse(
            field.path,
            f"has {dataset.size} {'entry' if dataset.size == 1 else 'entries'}",
            code="too-few-entries",
            cure=f"it must have at least {field.fewest}: {field.meaning}; check the cable and record again",
        )
    _refuse_missing_filters(dataset, field)
    _refuse_unwritten(dataset, field)
    with damage_at(field.path):
        values = np.asarray(dataset[()])
    if values.size and max(int(values.max()), -int(values.min())) > _LARGEST_INTEGER:
        raise refuse(
            field.path,
            f"reaches {int(values.max())}, from {int(values.min())}",
            code="integer-too-large",
            cure="it must stay within 2^62, so that differences fit into int64: unwrap the counter",
        )
    return read_only(values.astype(np.int64, copy=False))


def _refuse_other_than_ticks(dataset: h5py.Dataset, field: Field) -> None:
    unit = as_text(_units(dataset, field))
    if field.unit == "ticks" and unit not in layout.TICK_UNITS:
        raise refuse(
            field.path, f"is in '{unit}'", code="not-in-ticks", cure="it must be in ticks of the clock, unwrapped"
        )


def _frame_shape(dataset: h5py.Dataset, field: Field) -> tuple[int, int, int]:
    if dataset.dtype.kind != "u" or dataset.dtype.itemsize != 2:
        raise refuse(
            field.path,
            f"is {_kind_of(dataset)}",
            code="frames-not-uint16",
            cure="it must be uint16 (frame, row, column) as the camera gave it",
        )
    if dataset.ndim != 3:
        raise refuse(
            field.path,
            f"has shape {dataset.shape}",
            code="frames-not-three-dimensional",
            cure="it must have three dimensions: frame, row and column",
        )
    n_frames, rows, columns = (int(length) for length in dataset.shape)
    if min(n_frames, rows, columns) == 0:
        raise refuse(
            field.path,
            f"has shape {dataset.shape}: no frames",
            code="no-frames",
            cure="record again with the camera triggered",
        )
    _refuse_missing_filters(dataset, field)
    _refuse_unwritten(dataset, field)
    return n_frames, rows, columns


def _refuse_missing_filters(dataset: h5py.Dataset, field: Field) -> None:
    if missing := missing_filters(dataset):
        raise refuse(
            field.path,
            f"is compressed with HDF5 filter {' and '.join(missing)}, which is not installed",
            code="filter-not-installed",
            cure="write it with a filter of hdf5plugin, or install that filter and set HDF5_PLUGIN_PATH",
        )


def _refuse_unwritten(dataset: h5py.Dataset, field: Field) -> None:
    """Refuse a dataset of which a part is not in the file: HDF5 would give zeros without a word."""
    if dataset.is_virtual or dataset.external:
        return
    if dataset.chunks is None:
        with damage_at(field.path):
            n_bytes = int(dataset.id.get_storage_size())
        if n_bytes < dataset.nbytes:
            what = f"should have {dataset.nbytes} bytes, {n_bytes} are in the file"
            raise refuse(
                field.path,
                what,
                code="data-incomplete",
                cure="it was never written, or is damaged; copy or record it again",
            )
        return
    lengths = zip(dataset.shape, dataset.chunks, strict=True)
    expected = math.prod(-(-length // chunk) for length, chunk in lengths)
    with damage_at(field.path):
        stored = int(dataset.id.get_num_chunks())
    if stored < expected:
        raise refuse(
            field.path,
            f"has {stored} of {expected} chunks: the others were never written",
            code="chunks-missing",
            cure="the recording was interrupted; record again",
        )


def _kind_of(dataset: h5py.Dataset) -> str:
    kind = "text" if h5py.check_string_dtype(dataset.dtype) else str(dataset.dtype)
    if dataset.shape == ():
        return f"one {kind}"
    return f"{kind} of shape {dataset.shape}"
