"""Words that stand for one of a few things, given from Python, where no parser has looked at them."""

from collections.abc import Sequence
from difflib import get_close_matches

from irtiming.errors import IrTimingError


def require_word(
    field: str, word: object, *, known: Sequence[str], error: type[IrTimingError], may_be_none: bool = False
) -> None:
    """Refuse what is none of the known words.

    Parameters
    ----------
    field
        Of the record that has the word, by which a door to the program knows its own name for it.
    word
        What was given.
    known
        What it may be.
    error
        Raised where it is none of them.
    may_be_none
        Whether None, for what is usual, will do as well.

    Raises
    ------
    IrTimingError
        If it is another.
    """
    if (may_be_none and word is None) or (isinstance(word, str) and word in known):
        return
    near = get_close_matches(str(word).lower(), known, n=1)
    hint = f"; did you mean '{near[0]}'?" if near else "; name one of them"
    raise error(f"{{{field}}} is {str(word)[:40]!r}, must be {' or '.join(known)}{hint}", field)
