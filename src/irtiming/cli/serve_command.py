"""`irtiming serve`: the program as pages in a browser."""

from pathlib import Path
from typing import Annotated

import typer

from irtiming.cli.options import in_options
from irtiming.cli.screen import say
from irtiming.errors import InstrumentError


@in_options
def serve(
    folder: Annotated[
        Path,
        typer.Argument(
            metavar="[FOLDER]", help="Whose files are shown, and where all is written; no other is touched."
        ),
    ] = Path(),
    host: Annotated[
        str,
        typer.Option(metavar="IP", help="Address of this computer to listen at; 127.0.0.1 is for this computer alone."),
    ] = "127.0.0.1",
    port: Annotated[int, typer.Option(min=0, max=65535, help="0 for any that is free.")] = 8321,
    name: Annotated[
        str | None, typer.Option(metavar="NAME", help="By which browsers on other computers call this one.")
    ] = None,
    upload_mib: Annotated[
        int, typer.Option(min=1, max=2**20, metavar="MIB", help="The most that is dragged into the library at once.")
    ] = 2048,
) -> None:
    """Serve the program as pages to a browser, until Ctrl-C.

    The address that is printed has a token in it: whoever has it can use the rig and the folder, so keep it. Closing a page
    stops nothing; a second window sees the same recording.
    """
    try:
        from irtiming.web.server import ServeOrder
        from irtiming.web.server import serve as serve_pages
    except ModuleNotFoundError as error:
        if (error.name or "").split(".")[0] == "irtiming":
            raise
        raise InstrumentError(f"the pages need {error.name}; install it with pip install 'irtiming[web]'") from error
    order = ServeOrder(folder=folder, host=host, port=port, name=name, upload_bytes=upload_mib * 2**20)
    serve_pages(order, ready=lambda address: say(f"open {address}"))
    say("the server has ended")
