"""Syntax trees of source files, each read once: the rules all look at the same ones, and none changes them."""

import ast
from collections.abc import Iterator
from functools import cache
from pathlib import Path


@cache
def tree(path: Path) -> ast.Module:
    """Syntax tree of a file."""
    return ast.parse(path.read_text())


@cache
def nodes(path: Path) -> tuple[ast.AST, ...]:
    """Every node of a file, from the outer ones to the inner ones."""
    return tuple(ast.walk(tree(path)))


@cache
def functions(path: Path) -> tuple[ast.FunctionDef, ...]:
    """Functions of the module and methods of its public classes; a function inside a function is part of that one."""
    return tuple(_functions(tree(path).body))


def _functions(body: list[ast.stmt]) -> Iterator[ast.FunctionDef]:
    classes = [node for node in body if isinstance(node, ast.ClassDef)]
    methods = [method for owner in classes if not owner.name.startswith("_") for method in owner.body]
    yield from (node for node in [*body, *methods] if isinstance(node, ast.FunctionDef))
