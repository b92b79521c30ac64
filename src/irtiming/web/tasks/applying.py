"""A result put to use on other frames, and both beside each other."""

from typing import Any

from irtiming.records.frame_view import PairOrder
from irtiming.session.apply_frames import FramesOrder, apply_frames
from irtiming.session.apply_time import TimeOrder, apply_time
from irtiming.session.frame_stamps import StampsWanted
from irtiming.session.frame_views import pair
from irtiming.units import seconds
from irtiming.web.orders import ApplyOrder
from irtiming.web.tasks.jpeg import jpeg
from irtiming.web.work import Line, give_way


def apply(line: Line, order: ApplyOrder) -> dict[str, Any]:
    """What ``irtiming apply frames`` does, and ``irtiming apply time`` where a table is wanted."""
    give_way()
    frames = FramesOrder(
        result=order.result,
        source=order.source,
        out=order.out,
        period_s=seconds(order.period) if order.period else None,
        series=order.series,
    )
    if order.times is not None:
        stamps = StampsWanted(source=frames.source, alone=order.alone)
        apply_time(TimeOrder(result=frames.result, stamps=stamps, out=order.times, series=order.series))
        line.says(f"the times are in {order.times.name}")
    done = apply_frames(frames, progress=lambda n, total: line.step(frames.source.name, done=n, total=total))
    return {
        "before": str(frames.source),
        "after": str(frames.out),
        "times": None if order.times is None else str(order.times),
        "n_frames": done.n_frames,
        "n_written": done.n_written,
        "noise": done.noise,
        "mean_gain": done.mean_gain,
        "mean_noise_gain": done.mean_noise_gain,
        "description": list(done.description[1:]),
    }


def compare(line: Line, order: PairOrder) -> dict[str, Any]:
    """A frame before and after, as JPEG."""
    found = pair(order)
    return {
        "index": found.index, "n_frames": found.after.n_frames, "frame": found.before.index,
        "lowest": found.before.lowest, "highest": found.before.highest,
        "before": jpeg(found.before), "after": jpeg(found.after),
    }  # fmt: skip
