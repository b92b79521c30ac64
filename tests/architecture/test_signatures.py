"""Signatures: nothing travels by its place in a tuple; shapes of arrays and errors stand in the docstring."""

import ast
import re
from collections.abc import Callable, Iterator
from functools import cache
from pathlib import Path

from syntax import nodes, tree

ROOT = Path(__file__).parents[2]
PACKAGE = ROOT / "src" / "irtiming"
SOURCES = sorted(PACKAGE.rglob("*.py"))


Function = ast.FunctionDef | ast.AsyncFunctionDef

SHAPES_OF_LIBRARIES = ("Client",)
"""Names of tuples that a library takes as they are: an address of the socket library."""

OFFENDERS = {
    "estimate/published/lag_simulation.py:_follow_rows(mask)",
    "plan/prediction.py:_asked(runs)",
    "plan/prediction.py:sizes_s(runs)",
    "plan/prediction.py:uncertainties(runs)",
    "reduce/published/plateaus.py:inside(plateau)",
    "twin/node_picture.py:_add_nodes_past_wheel(table)",
    "twin/node_picture.py:_add_nodes_past_wheel(wheel)",
    "twin/kernels.py:trace_pixel(place)",
    "twin/pixels.py:_add_open_rays(spans)",
    "twin/pixels.py:_add_open_rays(table)",
    "twin/wide_range.py:_above_substrate(grid)",
    "twin/wide_range.py:_above_substrate(light)",
    "twin/wide_range.py:_look_up(table)",
    "twin/wide_range.py:_step_pixels(table)",
}
"""Parameters that still are tuples of unlike things; this list only gets shorter."""


def _all_functions(path: Path) -> Iterator[Function]:
    yield from (node for node in nodes(path) if isinstance(node, Function))


def _arguments(function: Function) -> list[ast.arg]:
    arguments = function.args
    return [*arguments.posonlyargs, *arguments.args, *arguments.kwonlyargs]


@cache
def _aliases(path: Path) -> dict[str, str]:
    """Names that a module gives to types, such as ``Runs: TypeAlias = Sequence[tuple[Information, int]]``."""
    found = {}
    for node in tree(path).body:
        target = node.targets[0] if isinstance(node, ast.Assign) else getattr(node, "target", None)
        if isinstance(node, ast.Assign | ast.AnnAssign) and isinstance(target, ast.Name) and node.value is not None:
            found[target.id] = ast.unparse(node.value)
    return found


def _unlike(annotation: ast.expr, aliases: dict[str, str]) -> bool:
    """Whether an annotation has a tuple of unlike things in it, be it quoted or behind another name."""
    text = annotation.value if isinstance(annotation, ast.Constant) else ast.unparse(annotation)
    text = str(text) if text in SHAPES_OF_LIBRARIES else aliases.get(str(text), str(text))
    return any(
        ast.unparse(node.value) == "tuple"
        and isinstance(node.slice, ast.Tuple)
        and len({ast.unparse(kind) for kind in node.slice.elts} - {"..."}) > 1
        for node in ast.walk(ast.parse(text, mode="eval"))
        if isinstance(node, ast.Subscript)
    )


def test_no_parameter_is_a_tuple_of_unlike_things():
    """Oracle: the annotations; what belongs together is a record with names, the rest are parameters of their own."""
    tuples = {name: text for path in SOURCES for name, text in _aliases(path).items() if "tuple[" in text}
    found = {
        f"{path.relative_to(PACKAGE)}:{function.name}({argument.arg})"
        for path in SOURCES
        for aliases in [tuples | _aliases(path)]
        for function in _all_functions(path)
        for argument in _arguments(function)
        if argument.annotation is not None and _unlike(argument.annotation, aliases)
    }
    assert sorted(found - OFFENDERS) == [], "give it names"
    assert sorted(OFFENDERS - found) == [], "take these off the list"


ARRAYS = {
    "Array", "ComplexArray", "Counts", "Indices", "Level", "Mask", "NDArray", "Offsets", "Pixels", "Ticks", "Values",
    "ndarray",
}  # fmt: skip
"""Names of array types in annotations."""

ERRORS = {node.name for node in tree(PACKAGE / "errors.py").body if isinstance(node, ast.ClassDef)}
ERRORS |= {"Complaint", "archive_error", "as_error", "broken", "refuse", "unwritable"}
"""Errors of this program, and what makes them."""


def _documented(path: Path) -> Iterator[tuple[Function, str]]:
    """Public functions and methods of a file with their docstrings, a method's with that of its class behind it."""
    for node in tree(path).body:
        if isinstance(node, Function) and not node.name.startswith("_"):
            yield node, ast.get_docstring(node) or ""
        elif isinstance(node, ast.ClassDef) and not node.name.startswith("_"):
            for method in node.body:
                if isinstance(method, Function) and not method.name.startswith("_"):
                    yield method, f"{ast.get_docstring(method)}\n{ast.get_docstring(node)}"


def _has_arrays(function: Function) -> bool:
    annotations = [argument.annotation for argument in _arguments(function)] + [function.returns]
    words = {word for one in annotations if one is not None for word in re.findall(r"\w+", ast.unparse(one))}
    return bool(words & ARRAYS)


def _raises(function: Function) -> bool:
    """Whether the body itself raises an error of this program."""
    return any(
        set(re.findall(r"\w+", ast.unparse(node.exc).split("(")[0])) & ERRORS
        for node in ast.walk(function)
        if isinstance(node, ast.Raise) and node.exc is not None
    )


def _lacking(needs: Callable[[Function], bool], pattern: str) -> set[str]:
    """Functions that need something in their docstring and have nothing like it."""
    return {
        f"{path.relative_to(PACKAGE)}:{function.name}"
        for path in SOURCES
        if path.parent.name != "cli"  # the docstring of a command is its help
        for function, text in _documented(path)
        if needs(function) and not re.search(pattern, text)
    }


def test_shapes_of_arrays_are_stated():
    """Oracle: the annotations and docstrings; "shape" with its axes, or the axes in brackets."""
    found = _lacking(_has_arrays, r"[Ss]hape|\(\w+,( \w+)*\)|\(\w+, \w+(, \w+)*\)")
    assert sorted(found) == []


def test_errors_are_told():
    """Oracle: the raise statements of each body; the docstring says under Raises when."""
    found = _lacking(_raises, r"Raises\n *-+")
    assert sorted(found) == []
