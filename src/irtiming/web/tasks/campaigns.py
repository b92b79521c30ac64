"""A campaign measured in a process of its own."""

from typing import Any

from irtiming.distribute.workers import HERE
from irtiming.session.campaign import PAGE, Order, run
from irtiming.web.orders import CampaignOrder
from irtiming.web.work import Line, give_way


def measure(line: Line, order: CampaignOrder) -> dict[str, Any]:
    """What ``irtiming campaign`` does; gives the page and how many are in it."""
    give_way()
    wanted = Order(
        source=order.source, rig=order.rig, out=order.out, limits=order.limits, register=str(order.register),
        workers=order.workers, scheduler=HERE if order.workers == 1 else None, language=order.language,
    )  # fmt: skip
    done = run(wanted, progress=lambda name, done, total: line.step(name, done=done, total=total))
    return {
        "page": str(order.out / PAGE),
        "n_lines": len(done.campaign.lines),
        "n_broken": sum(len(one.files) for one in done.campaign.broken),
        "n_registered": done.n_registered,
    }
