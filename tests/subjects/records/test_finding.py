"""Doubts that were there before a refusal go with it."""

import pytest

from irtiming.errors import ReductionError
from irtiming.records.finding import Finding, doubted, perhaps_therefore

_DOUBT = Finding(code="image-moved", severity="doubt", what="the opening moved", cure="fasten it")
_WARNING = Finding(code="lost-frames", severity="warning", what="3 frames lost")


def test_a_refusal_tells_the_doubts_before_it_and_nothing_else():
    """Oracle: by hand; a warning is no cause, and what was said is not said again."""
    with pytest.raises(ReductionError) as caught, doubted([[_WARNING, _DOUBT], [_DOUBT]]):
        raise ReductionError("no opening found")
    assert caught.value.__notes__ == ["and perhaps therefore: the opening moved; fasten it"]
    perhaps_therefore(caught.value, [_DOUBT])
    assert len(caught.value.__notes__) == 1


def test_where_nothing_was_doubted_a_refusal_stands_alone():
    """Oracle: by hand."""
    with pytest.raises(ReductionError) as caught, doubted([[_WARNING]]):
        raise ReductionError("no opening found")
    assert not hasattr(caught.value, "__notes__")
