"""Files against typed models: TOML that people write, JSON that programs write, and the kinds of values in them."""

import hashlib
import json
import re
import tomllib
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Annotated, Any, TypeVar, final

from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    GetCoreSchemaHandler,
    GetJsonSchemaHandler,
    ValidationError,
)  # fmt: skip
from pydantic.json_schema import JsonSchemaValue
from pydantic_core import core_schema

from irtiming.archive.typed_misfit import LARGEST, FileKind, OutOfRange, misfit, shown
from irtiming.errors import ArchiveError, UnitError
from irtiming.units import kelvin, readable_time, seconds

_Model = TypeVar("_Model", bound="Part")
_MOST_BYTES = 2**25


class Part(BaseModel):
    """Keys that belong together; an unknown one is refused, and nothing is taken for another kind than it is."""

    model_config = ConfigDict(extra="forbid", strict=True, frozen=True, allow_inf_nan=False)


def schema_of(model: type[Part]) -> str:
    """JSON Schema of a file, for editors and other programs: keys, limits, meanings, cures."""
    head = {"$schema": "https://json-schema.org/draft/2020-12/schema"}
    return json.dumps(head | model.model_json_schema(), indent=1, ensure_ascii=False) + "\n"


Number = Annotated[float, Field(ge=-LARGEST, le=LARGEST)]
NOT_NEGATIVE = "a standard uncertainty must be 0 or more"
Uncertainty = Annotated[float, Field(ge=0, le=LARGEST, json_schema_extra={"limit": NOT_NEGATIVE})]


def seconds_within(least_s: float, most_s: float) -> BeforeValidator:
    """Seconds from text such as ``"250 us"``, within limits."""

    def convert(value: object) -> float:
        time_s = _converted(value, of=seconds, example="250 us")
        if not least_s <= time_s <= most_s:
            least, most = readable_time(least_s), readable_time(most_s)
            raise OutOfRange(f"= {readable_time(time_s)}; it must be from {least} to {most}: check the unit")
        return time_s

    return BeforeValidator(convert, json_schema_input_type=str)


def _positive_seconds(value: object) -> float:
    time_s = _converted(value, of=seconds, example="250 us")
    if not time_s > 0:
        raise OutOfRange(f"= {shown(value)}; it must be more than 0")
    return time_s


def _kelvin(value: object) -> float:
    return _converted(value, of=kelvin, example="60 C")


PositiveTime = Annotated[float, BeforeValidator(_positive_seconds, json_schema_input_type=str)]
Temperature = Annotated[float, BeforeValidator(_kelvin, json_schema_input_type=str)]


def _converted(value: object, *, of: Callable[[str], float], example: str) -> float:
    if not isinstance(value, str):
        raise ValueError(f'is {shown(value)}; it must be text with a unit, such as "{example}"')
    try:
        return of(value)
    except UnitError as error:
        raise ValueError(f"cannot be read; {error}") from error


def _exact(value: object) -> str:
    if isinstance(value, bool) or not isinstance(value, int | float | str):
        raise ValueError(f"is {shown(value)}; it must be a number, or one in quotes")
    return value if isinstance(value, str) else repr(value)


Exact = Annotated[str, BeforeValidator(_exact, json_schema_input_type=int | float | str)]
"""Text of a number that was written in TOML or as text; ``30.303`` stays 30.303 and nothing near it."""


@final
class OneOrSeveral:
    """Says of a list that one entry may stand there without brackets."""

    def __get_pydantic_core_schema__(self, source: Any, handler: GetCoreSchemaHandler) -> core_schema.CoreSchema:
        """The list, made of one entry where that stands alone."""
        return core_schema.no_info_before_validator_function(
            lambda value: value if isinstance(value, list) else [value], handler(source)
        )

    def __get_pydantic_json_schema__(
        self, schema: core_schema.CoreSchema, handler: GetJsonSchemaHandler
    ) -> JsonSchemaValue:
        """One entry, or a list of them."""
        several = handler(schema)
        return {"anyOf": [several["items"], several]}


def read_toml(path: Path, model: type[_Model], *, kind: FileKind) -> tuple[_Model, str]:
    """What a TOML file says, and the SHA-256 checksum of its bytes.

    Raises
    ------
    IrTimingError
        If it cannot be read, is no TOML, or does not fit the model.
    """
    content = bytes_of(path, kind.name)
    try:
        table = tomllib.loads(content.decode("utf-8"))
    except UnicodeDecodeError as error:
        raise ArchiveError(f"{path}: is not UTF-8 text (byte {error.start}); save it as UTF-8") from error
    except (ValueError, RecursionError) as error:  # the former is also raised for a number of thousands of digits
        raise ArchiveError(f"{path}: is not valid TOML: {error}; correct that place") from error
    return fitted(table, model, path=path, kind=kind), hashlib.sha256(content).hexdigest()


def read_json(path: Path, model: type[_Model], *, kind: FileKind) -> _Model:
    """What a JSON file of a program says; keys that a later minor version has beyond ours are left out.

    Raises
    ------
    ArchiveError
        If it cannot be read, is no JSON, of another format or a later version, or does not fit the model.
    """
    content = json_of(path, what=kind.name, cure=kind.cure)
    if not isinstance(content, dict):
        raise ArchiveError(f"{path}: holds a {type(content).__name__}, must be a {kind.name}; {kind.cure}")
    if content.get("format") != kind.format:
        raise ArchiveError(f"{path}: is no {kind.name} (its format must be '{kind.format}'); {kind.cure}")
    found, known = _numbers(content.get("version")), _numbers(kind.version)
    if found[:1] > known[:1]:
        newer = f"version is {content['version']}, this irtiming knows {kind.version}"
        raise ArchiveError(f"{path}: {newer}: update it, or {kind.cure}")
    return fitted(content, model, path=path, kind=kind, is_newer=found > known)


def json_of(path: Path, *, what: str, cure: str) -> Any:
    """What a JSON file says, whatever that is.

    Parameters
    ----------
    path
        Of the file.
    what, cure
        It is to be, and to do where it is none.

    Raises
    ------
    ArchiveError
        If it cannot be read, or is no JSON.
    """
    text = bytes_of(path, what)
    try:
        return json.loads(text)
    except (ValueError, RecursionError) as error:  # the former is also raised for a number of thousands of digits
        raise ArchiveError(f"{path}: is not valid JSON ({error}); {cure}") from error


def _numbers(version: object) -> tuple[int, ...]:
    """Major and minor number of a version, such as 1 or "1.2"; none of what is no version."""
    return tuple(map(int, re.findall(r"[0-9]{1,9}", str(version)))) if isinstance(version, int | str) else ()


def fitted(
    table: Mapping[str, Any], model: type[_Model], *, path: Path, kind: FileKind, is_newer: bool = False
) -> _Model:
    """The model with the values of a table; unknown keys are refused, or left out where the file is newer than the program.

    Raises
    ------
    IrTimingError
        If they do not fit: an `ArchiveError`, or that of the kind of file for a value that cannot be.
    """
    try:
        return model.model_validate(table, extra="ignore" if is_newer else None)
    except ValidationError as error:
        raise misfit(error, table, model=model, path=path, kind=kind) from error


def bytes_of(path: Path, what: str) -> bytes:
    """All of a file that is small by its nature; ``what`` it is to be.

    Raises
    ------
    ArchiveError
        If it cannot be read, is a pipe or a device, or is larger than any such file.
    """
    try:
        if path.exists() and not (path.is_file() or path.is_dir()):
            raise ArchiveError(f"{path}: is no file but a device or a pipe; name the {what}")
        with path.open("rb") as file:
            content = file.read(_MOST_BYTES + 1)
        if len(content) > _MOST_BYTES:
            raise ArchiveError(f"{path}: has more than {_MOST_BYTES} bytes, which no {what} has; name the {what}")
        return content
    except FileNotFoundError as error:
        raise ArchiveError(f"{path}: does not exist; name the {what}") from error
    except IsADirectoryError as error:
        raise ArchiveError(f"{path}: is a folder; name the {what} in it") from error
    except OSError as error:
        raise ArchiveError(f"{path}: cannot be read ({error.strerror}); check its permissions") from error
