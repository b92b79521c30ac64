"""Signatures: nothing travels by its place in a tuple; shapes of arrays and errors stand in the docstring."""

import ast
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).parents[2]
PACKAGE = ROOT / "src" / "irtiming"
SOURCES = sorted(PACKAGE.rglob("*.py"))


SHAPES_OF_LIBRARIES = ("Client",)
"""Names of tuples that a library takes as they are: an address of the socket library."""

OFFENDERS = {
    "estimate/lag_simulation.py:_follow_rows(mask)",
    "estimate/sector_fit.py:_images(lag)",
    "estimate/sector_fit.py:_told(known)",
    "estimate/sector_fit.py:fit(lag)",
    "estimate/sector_fit.py:variations(lag)",
    "estimate/sector_image.py:_point_table(lag)",
    "estimate/sector_image.py:looks(lag)",
    "physics/blurred_sector.py:_row_harmonics(wanted)",
    "plan/prediction.py:_asked(runs)",
    "plan/prediction.py:sizes_s(runs)",
    "plan/prediction.py:uncertainties(runs)",
    "reduce/plateaus.py:inside(plateau)",
    "report/bent_edge.py:draw(marked)",
    "report/fraction_figures.py:_key(entry)",
    "report/tables.py:_plateaus(plateaus)",
    "twin/lag.py:_add_nodes_past_wheel(table)",
    "twin/lag.py:_add_nodes_past_wheel(wheel)",
    "twin/nodes.py:_trace_pixel(place)",
    "twin/pixels.py:_add_open_rays(gain)",
    "twin/pixels.py:_add_open_rays(spans)",
    "twin/pixels.py:_add_open_rays(table)",
    "twin/rays.py:_trace_row(reach)",
    "twin/wide_range.py:_above_substrate(grid)",
    "twin/wide_range.py:_above_substrate(light)",
    "twin/wide_range.py:_look_up(table)",
    "twin/wide_range.py:_step_pixels(table)",
}
"""Parameters that still are tuples of unlike things; this list only gets shorter."""


def _all_functions(path: Path) -> Iterator[ast.FunctionDef]:
    yield from (node for node in ast.walk(ast.parse(path.read_text())) if isinstance(node, ast.FunctionDef))


def _arguments(function: ast.FunctionDef) -> list[ast.arg]:
    arguments = function.args
    return [*arguments.posonlyargs, *arguments.args, *arguments.kwonlyargs]


def _aliases(path: Path) -> dict[str, str]:
    """Names that a module gives to types, such as ``Runs: TypeAlias = Sequence[tuple[Information, int]]``."""
    found = {}
    for node in ast.parse(path.read_text()).body:
        target = node.targets[0] if isinstance(node, ast.Assign) else getattr(node, "target", None)
        if isinstance(node, ast.Assign | ast.AnnAssign) and isinstance(target, ast.Name) and node.value is not None:
            found[target.id] = ast.unparse(node.value)
    return found


ALIASES = {name: text for path in SOURCES for name, text in _aliases(path).items() if "tuple[" in text}


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
    found = {
        f"{path.relative_to(PACKAGE)}:{function.name}({argument.arg})"
        for path in SOURCES
        for aliases in [ALIASES | _aliases(path)]
        for function in _all_functions(path)
        for argument in _arguments(function)
        if argument.annotation is not None and _unlike(argument.annotation, aliases)
    }
    assert sorted(found - OFFENDERS) == [], "give it names"
    assert sorted(OFFENDERS - found) == [], "take these off the list"
