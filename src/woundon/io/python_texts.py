"""Write problems as Python scripts."""

from __future__ import annotations

from typing import Any

from ..problems.description import Description, is_unset
from ..problems.problem import Problem
from .case_texts import material_name

__all__ = ["to_python"]

WIDTH = 96


def to_python(problem: Problem) -> str:
    """Return a Python script that solves a problem with the same result.

    >>> import woundon as wo
    >>> to_python(wo.RollerProblem.example()).splitlines()[-2:]
    ['result = wo.solve(problem)', 'print(result)']
    """
    lines = (
        "import woundon as wo",
        "",
        f"problem = {_expression(problem, 0)}",
        "result = wo.solve(problem)",
        "print(result)",
        "",
    )
    return "\n".join(lines)


def _expression(value: Any, depth: int) -> str:
    """Return the expression of a value, on one line if it is short.

    ``depth`` is the number of expressions that contain it, by which its further lines are indented.
    """
    if not isinstance(value, (Description, tuple)):
        return repr(value)
    name = material_name(value)
    if name is not None:
        return f"wo.material({name!r})"
    if isinstance(value, tuple):
        parts, ends = [_expression(item, depth + 1) for item in value], ("[", "]")
    else:
        fields = {name: getattr(value, name) for name in type(value).model_fields}
        parts = [
            f"{name}={_expression(item, depth + 1)}"
            for name, item in fields.items()
            if not is_unset(item)
        ]
        ends = (f"{_class(value)}(", ")")
    line = f"{ends[0]}{', '.join(parts)}{ends[1]}"
    if len(line) + 4 * depth <= WIDTH and "\n" not in line:
        return line
    inner = "".join(f"{'    ' * (depth + 1)}{part},\n" for part in parts)
    return f"{ends[0]}\n{inner}{'    ' * depth}{ends[1]}"


def _class(value: Description) -> str:
    """Return the name of a class as a script writes it; that of a plug-in is without a module."""
    cls = type(value)
    is_of_woundon = cls.__module__.partition(".")[0] == __name__.partition(".")[0]
    return f"wo.{cls.__name__}" if is_of_woundon else cls.__name__
