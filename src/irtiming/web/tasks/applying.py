"""A result put to use on other frames, and both beside each other."""

import io
from typing import Any

from PIL import Image

from irtiming.session.apply_frames import FramesOrder, apply_frames
from irtiming.session.apply_time import TimeOrder, apply_time
from irtiming.session.frame_stamps import StampsWanted
from irtiming.session.frame_views import FrameView, PairOrder, pair
from irtiming.units import seconds
from irtiming.web.orders import ApplyOrder, CompareOrder
from irtiming.web.work import Line, give_way


def apply(line: Line, order: ApplyOrder) -> dict[str, Any]:
    """What ``irtiming apply frames`` does, and ``irtiming apply time`` where a table is wanted."""
    give_way()
    frames = FramesOrder(
        result=order.result,
        source=order.source,
        out=order.out,
        period_s=seconds(order.period) if order.period else None,
    )
    if order.times is not None:
        apply_time(TimeOrder(result=frames.result, stamps=StampsWanted(source=frames.source), out=order.times))
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


def compare(line: Line, order: CompareOrder) -> dict[str, Any]:
    """A frame before and after, as JPEG."""
    found = pair(PairOrder(before=order.before, after=order.after, index=order.index))
    return {
        "index": found.index, "n_frames": found.after.n_frames, "frame": found.before.index,
        "lowest": found.before.lowest, "highest": found.before.highest,
        "before": _jpeg(found.before), "after": _jpeg(found.after),
    }  # fmt: skip


def _jpeg(view: FrameView) -> bytes:
    file = io.BytesIO()
    Image.fromarray(view.grey).save(file, "JPEG", quality=90)
    return file.getvalue()
