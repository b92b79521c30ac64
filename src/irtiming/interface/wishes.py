"""Wishes given by name, sorted into the records that know them."""

from collections.abc import Mapping
from dataclasses import fields
from difflib import get_close_matches
from typing import Any

from irtiming.errors import PlanError


def several(value: Any) -> tuple[Any, ...]:
    """What may be one or several, as several."""
    return tuple(value) if isinstance(value, list | tuple) else (value,)


def sorted_into(wishes: Mapping[str, Any], *records: type[Any]) -> list[dict[str, Any]]:
    """What each record knows of the wishes; the first takes what several know.

    Raises
    ------
    PlanError
        If none knows a wish.
    """
    known = [[field.name for field in fields(record)] for record in records]
    names = [name for one in known for name in one]
    found: list[dict[str, Any]] = [{} for _ in records]
    for name, value in wishes.items():
        if name not in names:
            near = get_close_matches(name, names, n=1)
            raise PlanError(
                f"'{name}' is no wish; {f'did you mean {near[0]}?' if near else 'see the help of the function'}"
            )
        owner = next(k for k, one in enumerate(known) if name in one)
        found[owner][name] = value
    return found
