"""What a large record says of itself in a terminal or a notebook: one line, arrays by their shape."""

from collections.abc import Mapping
from dataclasses import MISSING, Field, fields, is_dataclass
from typing import Any

import numpy as np

_LONGEST = 240
_LONGEST_TEXT = 40


def short_repr(record: Any) -> str:
    """Name of the record with the fields that differ from their defaults; for a class body: ``__repr__ = short_repr``."""
    texts = [
        f"{field.name}={_shown(getattr(record, field.name))}"
        for field in fields(record)
        if not _is_usual(record, field)
    ]
    shown: list[str] = []
    for text in texts:
        if sum(map(len, shown)) + len(text) > _LONGEST:
            shown.append("...")
            break
        shown.append(text)
    return f"{type(record).__name__}({', '.join(shown)})"


def _is_usual(record: Any, field: Field[Any]) -> bool:
    """Whether it is as left out; arrays never are, and are not compared."""
    value = getattr(record, field.name)
    return field.default is not MISSING and (value is field.default or (_is_plain(value) and value == field.default))


def _is_plain(value: object) -> bool:
    return value is None or isinstance(value, bool | int | float | str | tuple)


def _shown(value: object) -> str:
    if isinstance(value, np.ndarray):
        return f"<{'×'.join(map(str, value.shape))}>"
    if isinstance(value, str):
        return repr(value if len(value) <= _LONGEST_TEXT else f"{value[:_LONGEST_TEXT]}…")
    if isinstance(value, np.generic):
        return repr(value.item())
    if isinstance(value, tuple | list) and any(is_dataclass(one) or isinstance(one, np.ndarray) for one in value):
        return f"<{len(value)} × {type(value[0]).__name__}>"
    if isinstance(value, Mapping):
        return f"<{len(value)} entries>"
    if is_dataclass(value):
        return f"<{type(value).__name__}>"
    if not _is_plain(value):
        shape = getattr(value, "shape", None)
        return f"<{'×'.join(map(str, shape))}>" if isinstance(shape, tuple) else f"<{type(value).__name__}>"
    text = repr(value)
    return text if len(text) <= _LONGEST_TEXT else f"<{type(value).__name__}>"
