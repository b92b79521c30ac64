"""Frames of the bare blackbody at two temperatures."""

import asyncio
from types import SimpleNamespace

import numpy as np
import pytest

from irtiming.acquire import references
from irtiming.errors import InstrumentError
from irtiming.records.series_plan import ReferenceWishes


@pytest.mark.parametrize(
    ("levels_dn", "message"),
    [
        ((3000, 2000), "at 60.00 °C is 1000 DN darker than at 25.00 °C.* its contrast is turned over"),
        ((3000, 3001), "at 60.00 °C is 1 DN brighter than at 25.00 °C.* take wheel and mask out of the way"),
    ],
)
def test_frames_that_do_not_rise_with_the_temperature_are_refused(monkeypatch, levels_dn, message):
    """Oracle: by hand; frames of two levels with noise of 10 DN."""
    noise = np.random.default_rng(1).normal(0, 10, (20, 16, 16))
    stacks = iter([(level + noise).astype(np.uint16) for level in levels_dn])

    async def settled(rig, target_k, **_):
        return SimpleNamespace(temperature_k=target_k)

    async def frames(*_, **__):
        return next(stacks)

    monkeypatch.setattr(references, "settled", settled)
    monkeypatch.setattr(references, "_bare_frames", frames)
    wheel = SimpleNamespace(move_wheel=_nothing, says=lambda text: None)
    wishes = ReferenceWishes(low_k=298.15, high_k=333.15, frames=20)
    with pytest.raises(InstrumentError, match=message):
        asyncio.run(references.record_references(None, wishes, run=None, attendant=wheel))


async def _nothing(what):
    """The wheel is where it is wanted."""
