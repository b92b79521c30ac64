"""The server of the pages: one folder, one token, loopback unless something else is asked for."""

import asyncio
import logging
import secrets
import signal
import socket
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from ipaddress import ip_address
from pathlib import Path
from typing import final

import uvicorn
from fastapi import FastAPI
from nicegui import app as pages_app
from nicegui import ui

from irtiming.errors import ArchiveError, InstrumentError
from irtiming.web import files
from irtiming.web.desk import Desk
from irtiming.web.folder import Folder
from irtiming.web.guard import Guard, Rules
from irtiming.web.pages import (
    analyse_page,
    apply_page,
    campaigns_page,
    certificate_page,
    history_page,
    library_page,
    plan_page,
    record_page,
    rig_page,
    start_page,
)

MOST_CONNECTIONS = 200
_GRACE_S, _PATIENCE_S, _WARM_UP_S = 2, 60.0, 3.0


@final
@dataclass(frozen=True, kw_only=True)
class ServeOrder:
    """What a person wants served: a folder, at an address of this computer; port 0 is any that is free.

    ``name`` is the name or address by which browsers on other computers reach this one. ``upload_bytes`` is the most that is
    dragged in at once.
    """

    folder: Path
    host: str = "127.0.0.1"
    port: int = 0
    name: str | None = None
    upload_bytes: int = 2 * 2**30

    def __post_init__(self) -> None:
        if not self.folder.is_dir():
            raise ArchiveError(f"{self.folder}: is no folder; name one that is there, or make it")
        try:
            ip_address(self.host)
        except ValueError:
            raise InstrumentError(
                f"{{host}} is '{self.host:.80}'; it must be an address of this computer, such as 127.0.0.1", "host"
            ) from None


class _Server(uvicorn.Server):
    """Signals are the caller's."""

    @contextmanager
    def capture_signals(self) -> Iterator[None]:
        yield


def serve(order: ServeOrder, *, ready: Callable[[str], None]) -> None:
    """Serve the pages until Ctrl-C.

    Parameters
    ----------
    order
        What a person wants.
    ready
        Called with the address to open, which has the token in it.

    Raises
    ------
    InstrumentError
        If the address or port cannot be used.
    """
    with _listening(order) as line:
        port = line.getsockname()[1]
        rules = Rules(
            hosts=_hosts(order, port),
            token=secrets.token_urlsafe(32),
            cookie=f"irtiming-{port}",
            upload_bytes=order.upload_bytes,
        )
        asyncio.run(_served(order, rules, line=line, ready=ready))


async def _served(order: ServeOrder, rules: Rules, *, line: socket.socket, ready: Callable[[str], None]) -> None:
    app = FastAPI(openapi_url=None)
    desk = Desk(folder=Folder(order.folder))
    add_pages(desk, upload_bytes=order.upload_bytes)
    ui.run_with(app, title="irtiming", dark=None, tailwind=False, show_welcome_message=False, language="en-GB")
    config = uvicorn.Config(
        Guard(app, rules=rules), lifespan="on", log_level="error", access_log=False, proxy_headers=False, server_header=False,
        limit_concurrency=MOST_CONNECTIONS, timeout_graceful_shutdown=_GRACE_S, ws_max_size=2**20,
        h11_max_incomplete_event_size=16384,
    )  # fmt: skip
    server = _Server(config)
    with _ended_by_signals(server):
        asyncio.get_running_loop().call_later(_WARM_UP_S, desk.jobs.ask, "files:warm_up", None)
        ready(f"http://{rules.hosts[0]}/?token={rules.token}")
        try:
            await server.serve(sockets=[line])
        finally:
            await asyncio.to_thread(desk.jobs.end, 0.0 if server.force_exit else _PATIENCE_S)


def add_pages(desk: Desk, *, upload_bytes: int) -> None:
    """All pages, for a desk."""
    pages_app.add_static_files("/look", Path(__file__).with_name("look"))
    logging.getLogger("nicegui").setLevel(logging.ERROR)  # a page that is not there is reported to who asked
    pages_app.config.socket_io_js_transports = ["websocket"]
    for page in (
        start_page,
        plan_page,
        rig_page,
        record_page,
        files,
        analyse_page,
        campaigns_page,
        history_page,
        certificate_page,
        apply_page,
    ):
        page.add(desk)
    library_page.add(desk, upload_bytes=upload_bytes)


@contextmanager
def _listening(order: ServeOrder) -> Iterator[socket.socket]:
    family = socket.AF_INET6 if ":" in order.host else socket.AF_INET
    with socket.socket(family, socket.SOCK_STREAM) as line:
        if sys.platform != "win32":
            line.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            line.bind((order.host, order.port))
            line.listen(MOST_CONNECTIONS)  # who opens the page before all is loaded waits, and is not turned away
        except OSError as error:
            raise InstrumentError(
                f"{order.host} port {order.port} cannot be used ({error.strerror}); give another {{port}}, or 0 for any",
                "port",
            ) from error
        yield line


def _hosts(order: ServeOrder, port: int) -> tuple[str, ...]:
    """What a request may call this server, the name to print first."""
    own = f"[{order.host}]" if ":" in order.host else order.host
    names = [order.name] if order.name else []
    names += [own, "localhost"] if ip_address(order.host).is_loopback else [own]
    return tuple(f"{name}:{port}" for name in names)


@contextmanager
def _ended_by_signals(server: uvicorn.Server) -> Iterator[None]:
    """Ctrl-C ends the server, the second one at once."""
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}

    def end(*_: object) -> None:
        server.force_exit = server.should_exit
        server.should_exit = True

    for number, was in before.items():
        if number != signal.SIGINT or callable(was):  # a shell lets its jobs ignore it
            signal.signal(number, end)
    try:
        yield
    finally:
        for number, was in before.items():
            signal.signal(number, was)
