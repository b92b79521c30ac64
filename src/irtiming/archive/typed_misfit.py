"""What does not fit a typed model, as one line for a person: place, value, what it must be, what to do.

Each key of a model states its limits and, where these do not say enough, its cure in ``json_schema_extra``: ``must`` (what the
value must be), ``each`` (what an entry of it must be), ``limit`` (what its size must be), ``hint`` (what stands behind the
limits). Its unit is the end of its name.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path
from typing import Any, Literal, final, get_args, get_origin

from pydantic import BaseModel, ValidationError
from pydantic.fields import FieldInfo

from irtiming.errors import ArchiveError, IrTimingError

LARGEST = 1e12
_LONGEST = 60
_FIRST = {"model_type": 0, "extra_forbidden": 1}  # a misspelt key is rather that than missing
_UNITS = ("mm", "deg", "rad", "us")
_BOUNDS = ("gt", "ge", "lt", "le")
_KINDS = {
    "int": "a whole number", "float": "a number", "finite": "a finite number", "bool": "true or false", "string": "text",
    "list": "a list", "dict": "a table, such as {Name = value}", "literal": "text",
    "model": "an object", "date": "a day without quotes, such as 2026-11-24",
}  # fmt: skip


class OutOfRange(ValueError):  # noqa: N818 - it never leaves this folder
    """Says of a value of the right kind that it cannot be."""


@final
@dataclass(frozen=True, kw_only=True)
class FileKind:
    """How complaints about a kind of file are worded.

    ``missing`` says what to do about a key, or ``section`` about a section, that is not there. ``out_of_range`` is raised
    for a value that cannot be. A file that programs write is JSON, of a ``format`` and ``version``, and has one ``cure`` for all.
    """

    name: str
    missing: str = "write it there"
    section: str = "write it there"
    out_of_range: type[IrTimingError] = ArchiveError
    cure: str = ""
    format: str = ""
    version: int | str = 1


@final
@dataclass(frozen=True, kw_only=True)
class _Place:
    """Where a value stands: its keys and indices, its field in the model if it has one, and the value."""

    keys: tuple[str | int, ...]
    owner: type[BaseModel]
    field: FieldInfo | None
    is_entry: bool
    value: Any


def misfit(
    error: ValidationError, table: Mapping[str, Any], *, model: type[BaseModel], path: Path, kind: FileKind
) -> IrTimingError:
    """Error that says the first thing that does not fit."""
    details = sorted(error.errors(include_url=False), key=lambda detail: _FIRST.get(detail["type"], len(_FIRST)))
    places = [_place(detail["loc"], table, model) for detail in details]
    deepest = max(
        (i for i, place in enumerate(places) if place.keys[: len(places[0].keys)] == places[0].keys),
        key=lambda i: len(places[i].keys),
    )
    detail, place = details[deepest], places[deepest]
    sort, cause = detail["type"], detail.get("ctx", {}).get("error")
    if sort == "float_type" and isinstance(place.value, int) and abs(place.value) > LARGEST:
        sort = "finite_number"  # so large that it is no float
    is_size = isinstance(cause, OutOfRange) or sort.startswith(("greater", "less", "finite"))
    says = str(cause) if cause else _says(sort, place, kind)
    if kind.cure:
        says = f"{says.replace('; it must', ', must').replace('; must', ', must')}; {kind.cure}"
    where = _named(place.keys, is_json=bool(kind.cure))
    if len(place.keys) == 1 and not kind.cure and sort != "extra_forbidden" and not cause:
        where = f"section {where}" if sort == "missing" else str(place.keys[0])
    line = f"{path}: {where}{'' if says.startswith(('[', '.')) or not where else ' '}{says}"
    return kind.out_of_range(line) if is_size else ArchiveError(line)


def _place(loc: tuple[str | int, ...], table: Mapping[str, Any], model: type[BaseModel]) -> _Place:
    """Follow a place through table and model; what only names the branch of a union is passed over."""
    keys: list[str | int] = []
    value: Any = table
    owner, field, is_entry = model, None, False
    for i, key in enumerate(loc):
        is_there = (isinstance(value, dict) and key in value) or (isinstance(value, list) and isinstance(key, int))
        if not is_there and not (i == len(loc) - 1 and isinstance(value, dict)):
            continue
        keys.append(key)
        value = value[key] if is_there else None
        if isinstance(key, str) and key in owner.model_fields:
            field = owner.model_fields[key]
            owner, is_entry = model_in(field.annotation) or owner, False
        else:
            is_entry = True
    return _Place(keys=tuple(keys), owner=owner, field=field, is_entry=is_entry, value=value)


def model_in(annotation: Any) -> type[BaseModel] | None:
    """The model that a field holds, be it optional or one of a list."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return annotation
    return next((found for part in get_args(annotation) if (found := model_in(part))), None)


def _words(annotation: Any) -> tuple[str, ...]:
    """The words of a literal, be it optional."""
    args = get_args(annotation)
    return args if get_origin(annotation) is Literal else next((words for one in args if (words := _words(one))), ())


def _within(annotation: Any) -> list[FieldInfo]:
    """What the types say that an annotation is made of, such as the limits of an optional number or of a list's entries."""
    own = [one for one in getattr(annotation, "__metadata__", ()) if isinstance(one, FieldInfo)]
    return own + [found for part in get_args(annotation) for found in _within(part)]


def _extra(field: FieldInfo) -> dict[str, Any]:
    """What a field states of its limits and its cure."""
    return field.json_schema_extra if isinstance(field.json_schema_extra, dict) else {}


def _says(sort: str, place: _Place, kind: FileKind) -> str:
    """What is wrong with the value at a place, and what it must be."""
    field, key = place.field, str(place.keys[-1])
    stated = [] if field is None else [field, *_within(field.annotation)]
    extra = dict(item for one in reversed(stated) for item in _extra(one).items())
    example = f'"{field.examples[0]}"' if field and field.examples else ""
    if sort == "missing":
        write = f"write {key} = {example}" if example else kind.missing
        return "is missing" if kind.cure else f"is missing; {kind.section if len(place.keys) == 1 else write}"
    if sort == "extra_forbidden":
        return _unknown(key, place, kind)
    bounds = {
        name: bound
        for info in reversed(stated)
        for one in info.metadata
        for name in _BOUNDS
        if (bound := getattr(one, name, None)) is not None
    }
    if sort.startswith(("greater", "less", "finite")):
        unit = _unit(place.keys)
        number = f"= {place.value:g}{unit}" if abs(place.value) < LARGEST else f"= {shown(place.value)}"
        return f"{number}; {_limits(place.value, bounds, unit=unit, stated=extra)}"
    must = f"it must be {_KINDS.get(sort.split('_')[0], 'another value')}"
    if sort.startswith("int") and {"ge", "le"} <= set(bounds):
        must += f" from {bounds['ge']} to {bounds['le']}"
    if sort in ("string_type", "literal_error") and example:
        must += f", such as {example}"
    if sort == "literal_error" and isinstance(place.value, str) and field:
        must = choice(place.value, _words(field.annotation))
    if not kind.cure and len(place.keys) == 1:
        must = f"it must be a section [{key}]"
    return f"is {shown(place.value)}; {extra.get('each' if place.is_entry else 'must', must)}"


def _limits(value: float, bounds: Mapping[str, float], *, unit: str, stated: Mapping[str, Any]) -> str:
    if not abs(value) <= LARGEST:
        return "it must be a finite number"
    if "limit" in stated:
        return str(stated["limit"])
    hint = stated.get("hint", ", check the unit" if unit else "")
    if "lt" in bounds:
        lowest = f"{bounds['ge']:g} or more" if "ge" in bounds else f"more than {bounds.get('gt', 0):g}"
        return f"it must be {lowest} and less than {bounds['lt']:g}{unit}{hint}"
    if "gt" in bounds and value <= bounds["gt"]:
        return f"it must be greater than {bounds['gt']:g}"
    least, most = bounds.get("ge", bounds.get("gt", 0)), bounds.get("le", LARGEST)
    return f"it must be from {least:g} to {most:g}{unit}{hint}" if most < LARGEST else f"it must be {least:g} or more"


def _unit(keys: tuple[str | int, ...]) -> str:
    name = next((key for key in reversed(keys) if isinstance(key, str)), "")
    ending = name.rsplit("_", 1)[-1]
    return f" {ending}" if ending in _UNITS else ""


def _unknown(key: str, place: _Place, kind: FileKind) -> str:
    known = tuple(place.owner.model_fields)
    near = get_close_matches(key.lower(), known, n=1)
    if kind.cure:
        return "is unknown" + (f", did you mean '{near[0]}'?" if near else "")
    says, sort = "is not a key of this section", "key"
    if len(place.keys) == 1:
        says, sort = f"is not a section of {kind.name}", "section"
    return f"{says}; " + (f"did you mean '{near[0]}'?" if near else f"the {sort}s are {', '.join(known)}")


def _named(keys: tuple[str | int, ...], *, is_json: bool) -> str:
    """Place as people write it: ``[section] key[1]`` in TOML, ``part[0]: key`` in JSON."""
    texts: list[str] = []
    for key in keys:
        if isinstance(key, int):
            texts[-1] += f"[{key}]"
        else:
            texts.append(key)
    if is_json:
        return ": ".join(texts)
    return " ".join([f"[{texts[0]}]", *filter(None, [".".join(texts[1:])])]) if texts else ""


def choice(word: str, known: tuple[str, ...]) -> str:
    """What a word must be, and which was meant."""
    near = get_close_matches(word.lower(), known, n=1)
    return f"it must be {' or '.join(filter(None, known))}" + (f", did you mean '{near[0]}'?" if near else "")


def shown(value: Any) -> str:
    """A value as it stands in a message: one line, not too long."""
    text = " ".join(repr(value).split())
    return text if len(text) <= _LONGEST else f"{text[: _LONGEST - 3]}..."
