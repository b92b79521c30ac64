"""Lines on the screen."""

from rich.console import Console
from rich.markup import escape


def say(text: str, screen: Console | None = None) -> None:
    """One line exactly as it is, however long; on standard output where no screen is named."""
    (screen or Console()).print(text, markup=False, highlight=False, soft_wrap=True)


def warn(text: str, screen: Console) -> None:
    """A warning, broken into lines as the screen has room."""
    screen.print(f"[yellow]warning:[/yellow] {escape(text)}", highlight=False)
