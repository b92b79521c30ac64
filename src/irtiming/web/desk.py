"""What all pages share, whoever looks at them: the folder, and the work that goes on in it."""

import asyncio
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass, field
from typing import Any, final

from irtiming.web.folder import Folder
from irtiming.web.jobs import Ending, Jobs
from irtiming.web.work import Task

_PATIENCE_S = 120.0


@final
@dataclass(frozen=True, kw_only=True)
class Desk:
    """One server's folder and jobs; every browser window sees the same."""

    folder: Folder
    jobs: Jobs = field(default_factory=Jobs)

    async def ask(self, task: Task, order: Any) -> Ending:
        """Have something small found out in another process; a file that brings that down brings down nothing else."""
        try:
            future = self.jobs.ask(task, order)
            found: Ending = await asyncio.wait_for(asyncio.wrap_future(future), _PATIENCE_S)
        except BrokenProcessPool:
            return Ending(text="the process that was to find it out has broken down; is the file sound?")
        except TimeoutError:
            return Ending(text=f"it was not found out within {_PATIENCE_S:g} s; try again when less goes on")
        return found
