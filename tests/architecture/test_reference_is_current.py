"""Pages and drawings that are made by a program, against what the program makes now."""

import ast
import re
import runpy
import subprocess
import sys
from functools import cache
from pathlib import Path

from syntax import nodes

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"


def _python(*arguments: str, cwd: Path = ROOT) -> str:
    done = subprocess.run(
        [sys.executable, "-W", "error", *arguments], cwd=cwd, capture_output=True, text=True, timeout=120, check=False
    )
    assert done.returncode == 0, done.stderr
    return done.stdout


def _block(page: str, language: str) -> str:
    """The first block of code in that language on a page below docs/."""
    found = re.search(rf"^```{language}\n(.*?)^```$", (DOCS / page).read_text(), flags=re.MULTILINE | re.DOTALL)
    assert found is not None, f"{page} has no block of {language}"
    return found[1]


@cache
def _messages() -> list[str]:
    """Every text of the program, with an ellipsis for each value that is put into it."""
    in_place_of = runpy.run_path(str(ROOT / "scripts" / "findings-reference"))["in_place_of"]
    texts = []
    for path in (ROOT / "src").rglob("*.py"):
        for node in nodes(path):
            if isinstance(node, ast.JoinedStr):
                texts.append(
                    "".join(str(v.value) if isinstance(v, ast.Constant) else in_place_of(v) for v in node.values)
                )
            elif isinstance(node, ast.Constant) and isinstance(node.value, str):
                texts.append(node.value)
    return texts


def _cells(page: str, column: int) -> list[str]:
    """What stands in code style in one column of the tables of a page below docs/."""
    rows = [line.split(" | ") for line in (DOCS / page).read_text().splitlines() if line.startswith("| ")]
    return [code for row in rows if len(row) > column for code in re.findall(r"`([^`]+)`", row[column])]


def test_the_page_of_the_command_line_is_what_the_commands_say():
    """Oracle: the commands; if this fails, run scripts/command-line-reference > docs/reference/command-line.md."""
    assert (DOCS / "reference" / "command-line.md").read_text() == _python("scripts/command-line-reference")


def test_the_page_of_the_registers_is_what_the_register_map_says():
    """Oracle: the map; if this fails, run scripts/register-map-reference > docs/reference/trigger-generator-registers.md."""
    page = DOCS / "reference" / "trigger-generator-registers.md"
    assert page.read_text() == _python("scripts/register-map-reference")


def test_the_drawing_of_the_definitions_is_what_its_program_draws(tmp_path):
    """Oracle: the program on the page; if this fails, run it in docs/explanation."""
    _python("-c", _block("explanation/definitions.md", "python"), cwd=tmp_path)
    assert (tmp_path / "wheel.svg").read_text() == (DOCS / "explanation" / "wheel.svg").read_text()


def test_the_numbers_of_falling_and_rising_are_what_its_program_prints():
    """Oracle: the program on the page."""
    page = "explanation/falling-and-rising.md"
    assert _python("-c", _block(page, "python")) == _block(page, "text")


def _anchors(page: Path) -> set[str]:
    """What a link may name after the # of a page: its headings in lower case, without punctuation, joined by hyphens."""
    headings = re.findall(r"^#+ +(.+)$", re.sub(r"^```.*?^```$", "", page.read_text(), flags=re.M | re.S), flags=re.M)
    plain = [re.sub(r"\[([^]]*)\]\([^)]*\)", r"\1", heading).lower() for heading in headings]
    return {re.sub(r"[^\w\- ]", "", heading).replace(" ", "-") for heading in plain}


def test_every_link_between_the_pages_leads_somewhere():
    """Oracle: the files and their headings; links to other hosts are left alone."""
    dead = []
    for page in filter(Path.exists, [ROOT / "README.md", *DOCS.rglob("*.md")]):
        for target, anchor in re.findall(r"\]\(([^)#\s]*)#?([^)\s]*)\)", page.read_text()):
            there = page.parent / target if target else page
            if "://" in target or (there.exists() and (not anchor or anchor in _anchors(there))):
                continue
            dead.append(f"{page.relative_to(ROOT)}: {target}#{anchor}")
    assert dead == []


def test_the_list_of_pages_has_every_page():
    """Oracle: the files; the site takes its contents from this list."""
    listed = {(DOCS / link).resolve() for link in re.findall(r"\]\(([^)#\s]+)\)", (DOCS / "README.md").read_text())}
    own = {
        DOCS / "README.md",
        DOCS / "index.md",
        DOCS / "reference" / "security.md",
        DOCS / "reference" / "changelog.md",
    }
    assert [page for page in sorted(DOCS.rglob("*.md")) if page not in listed | own] == []


def test_every_message_in_the_table_of_troubles_is_one_of_the_program():
    """Oracle: the texts in the source."""
    page = (DOCS / "how-to" / "your-own-rig.md").read_text().split("## 7.")[1]
    quoted = re.findall(r"^\| [^|]+ \| `([^`]+)` \|", page, flags=re.MULTILINE)
    texts = _messages()
    assert len(quoted) > 20
    assert [message for message in quoted if not any(message in text for text in texts)] == []


def test_every_complaint_of_the_trigger_generator_is_one_of_the_program():
    """Oracle: the texts in the source, values left out."""
    page = (DOCS / "how-to" / "use-the-trigger-generator.md").read_text().split("## What each complaint means")[1]
    quoted = re.findall(r"^\| `([^`]+)` \|", page, flags=re.MULTILINE)
    texts = _messages()
    assert len(quoted) > 15
    assert [message for message in quoted if not any(message in text for text in texts)] == []


def test_every_place_named_for_the_paper_exists():
    """Oracle: the source; the third column names files, the fourth functions, classes and options in them."""
    page = "explanation/where-is-it-in-the-paper.md"
    files = [code for code in _cells(page, 2) if code.endswith(".py")]
    source = "".join((ROOT / "src" / "irtiming" / file).read_text() for file in set(files))
    names = [code for code in _cells(page, 3) if code.isidentifier()]
    assert len(files) > 20
    assert [name for name in names if not re.search(rf"(def|class) {name}\b", source)] == []


def test_every_source_file_that_the_pages_name_exists():
    """Oracle: the files."""
    homes = (ROOT, ROOT / "src", ROOT / "src" / "irtiming")
    gone = [
        f"{page.relative_to(ROOT)}: {name}"
        for page in (ROOT / "README.md", *DOCS.rglob("*.md"))
        for name in re.findall(r"`((?:[a-z_]+/)+[a-z_]+\.py)`", page.read_text())
        if not any((home / name).exists() for home in homes)
    ]
    assert gone == []


def test_every_class_of_the_python_interface_is_on_its_page():
    """Oracle: the class statements of the interface; without its page, the site is not built, for a signature names it."""
    classes = {
        f"irtiming.interface.{path.stem}.{node.name}"
        for path in (ROOT / "src" / "irtiming" / "interface").glob("*.py")
        for node in nodes(path)
        if isinstance(node, ast.ClassDef) and not node.name.startswith("_")
    }
    named = set(re.findall(r"autoclass:: (irtiming\.interface\.\S+)", (DOCS / "reference" / "api.rst").read_text()))
    assert classes
    assert classes <= named
