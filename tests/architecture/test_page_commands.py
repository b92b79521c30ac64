"""Commands on the pages, against the program's own options."""

import re
import shlex
from pathlib import Path

import pytest
import typer
from typer.core import TyperGroup

from irtiming.cli.main import app

ROOT = Path(__file__).parents[2]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
UsageError = typer.BadParameter.__base__
BLOCK = re.compile(r"^```(?:text|sh|)\n(.*?)^```$", flags=re.MULTILINE | re.DOTALL)


def _commands(page: Path) -> list[str]:
    """What a reader may type: lines of blocks that begin with irtiming, after a prompt where there is one."""
    blocks = [block.replace("\\\n", " ").splitlines() for block in BLOCK.findall(page.read_text())]
    prompts = [any(line.startswith("$ ") for line in block) for block in blocks]
    lines = [
        line
        for block, prompt in zip(blocks, prompts, strict=True)
        for line in block
        if not prompt or line.startswith("$ ")
    ]
    typed = [re.sub(r"^(\$ )?(\.venv/bin/)?", "", line) for line in lines]
    return [line for line in typed if line.startswith("irtiming ") and "[OPTIONS]" not in line]


def _parse(words: list[str]) -> None:
    """Take options and arguments apart as the program does; files are not looked for and values not read.

    Raises
    ------
    UsageError
        If there is no such command or option, or an option lacks its value.
    """
    command, context = typer.main.get_command(app), None
    while words and isinstance(command, TyperGroup):
        context = typer.Context(command, info_name=command.name, parent=context)
        _, words, _ = command.make_parser(context).parse_args(words)
        _, command, words = command.resolve_command(context, words) if words else ("", command, [])
    command.make_parser(typer.Context(command, parent=context)).parse_args(words)


@pytest.mark.parametrize("page", [page for page in PAGES if _commands(page)], ids=lambda page: page.name)
def test_every_command_of_a_page_exists_with_its_options(page):
    """Oracle: the parsers of the program."""
    wrong = []
    for line in _commands(page):
        words = shlex.split(re.split(r" [|>&] ?|;", line)[0], comments=True)[1:]
        try:
            _parse(words)
        except UsageError as error:
            wrong.append(f"{line}: {error.format_message()}")
    assert wrong == []


def test_a_wrong_option_is_seen():
    """Oracle: options that no command has."""
    for words in (
        ["analyse", "--no-such-option", "1"],
        ["no-such-command"],
        ["apply", "time", "--nonsense"],
        ["plan", "--clock-hz"],
    ):
        with pytest.raises(UsageError):
            _parse(words)
