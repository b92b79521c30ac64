"""What a wheel will hold, and what is said of a release, against the files."""

import re
import subprocess
import sys
import tomllib
from fnmatch import fnmatch
from pathlib import Path

import yaml

ROOT = Path(__file__).parents[2]
PACKAGE = ROOT / "src" / "irtiming"
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text())


def test_every_file_beside_the_modules_is_packed():
    """Oracle: the files; what no pattern of package-data matches would be missing after an installation."""
    patterns = PROJECT["tool"]["setuptools"]["package-data"]["irtiming"]
    files = [
        path.relative_to(PACKAGE) for path in PACKAGE.rglob("*") if path.is_file() and "__pycache__" not in path.parts
    ]
    data = [str(path) for path in files if path.suffix != ".py"]
    assert len(data) > 10
    assert [name for name in data if not any(fnmatch(name, pattern) for pattern in patterns)] == []
    assert [pattern for pattern in patterns if not any(fnmatch(name, pattern) for name in map(str, files))] == []


def test_every_folder_with_modules_is_a_package():
    """Oracle: the files; setuptools leaves a folder without __init__.py out, but for the one that is data for MicroPython."""
    folders = {path.parent for path in PACKAGE.rglob("*.py")}
    bare = sorted(folder.relative_to(PACKAGE).as_posix() for folder in folders if not (folder / "__init__.py").exists())
    assert bare in ([], ["gateware/microcontroller"])


def test_the_citation_is_of_this_version():
    """Oracle: pyproject.toml, and the paper as README.md names it."""
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text())
    assert (citation["version"], citation["license"]) == (PROJECT["project"]["version"], PROJECT["project"]["license"])
    paper = citation["references"][0]
    readme = (ROOT / "README.md").read_text().replace("\n", " ")
    assert f"*{paper['title']}*, Meas. Sci. Technol. {paper['volume']} ({paper['year']}) {paper['start']}" in readme


def test_the_changelog_holds_all_that_is_collected():
    """Oracle: the files in news/."""
    done = subprocess.run(
        [sys.executable, ROOT / "scripts" / "changelog"], capture_output=True, text=True, check=True, cwd=ROOT
    )
    texts = [
        re.sub(r"\s+", " ", path.read_text().strip()).replace("](../", "](") for path in (ROOT / "news").glob("*.md")
    ]
    page = re.sub(r"\s+", " ", done.stdout)
    assert len(texts) > 10
    assert [text for text in texts if text not in page] == []
