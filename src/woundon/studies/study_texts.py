"""Template of a study file for any kind of problem, printed by ``woundon new --study``."""

from __future__ import annotations

import json
from collections.abc import Iterator
from itertools import product
from textwrap import fill

from .. import kinds
from ..io.case_texts import SCHEMA, to_toml, toml_value
from ..problems.paths import field_quantity
from ..problems.problem import Problem
from ..quantities import scalar_outputs
from .model import KindModel, options_of

__all__ = ["study_template"]

_TEXT = """\
# A study: the case below, solved for many values of its fields.
#
#   woundon sweep study.toml --out results             solve it; tables and figures are in results/
#   woundon sweep study.toml --out results --resume    continue after an interruption

schema  = {schema}
outputs = {outputs}
{others}

# All combinations are solved: of ranges, spacing = "log" too, and of lists of values.  For the rows
# of a table write over = "cases.csv" in place of this section (.xlsx too; units in its header).
[over]
{over}

# [design]                      # drawn samples; the ranges above then have no count
# kind    = "latin-hypercube"   # or "sobol"
# samples = 64
# seed    = 1

# [tie]                         # fields that follow others
# "FIELD" = "FIELD"

[solver]
# options: {options}

# The case; any of its fields may be varied above, nested ones by dotted name.
{case}"""


def study_template(kind: str) -> str:
    """Return the text of a study file for the example of a kind of problem.

    Raises
    ------
    InvalidProblem
        For an unknown kind, or one that has no example.
    """
    problem_kind = kinds.named(kind)
    problem = problem_kind.example()
    varied = dict(_varied_fields(problem))
    width = max(map(len, varied), default=0)
    known = [name for name in scalar_outputs(problem_kind.result) if name not in varied]
    outputs = [*problem_kind.result.MAIN] or known[:1]
    others = [name for name in known if name not in outputs]
    return _TEXT.format(
        schema=SCHEMA,
        outputs=json.dumps(outputs),
        others=fill(f"# or any of: {', '.join(others)}", 100, subsequent_indent="# "),
        over="\n".join(f"{name:<{width}} = {values}" for name, values in varied.items()),
        options=", ".join(options_of(problem)),
        case=to_toml(problem, comments=True, under="case"),
    )


def _varied_fields(problem: Problem) -> Iterator[tuple[str, str]]:
    """Yield at most two fields, loads if possible, with values as TOML.

    The first gets a range, the second a list of two values.
    """
    known = {name: field_quantity(problem, name) for name in type(problem).model_fields}
    loads = {
        name: quantity
        for name, quantity in known.items()
        if quantity and getattr(problem, name) and isinstance(getattr(problem, name), (int, float))
    }
    # fields with a unit first, and of these the fields with a usual range
    ranked = sorted(loads, key=lambda name: (loads[name].unit == "1", not loads[name].typical))
    # slices, because there may be fewer than two fields
    other = {name: (getattr(problem, name) / 2, getattr(problem, name)) for name in ranked[1:2]}
    for name in ranked[:1]:
        value = getattr(problem, name)
        # the first range that is admissible together with the values of the other field
        ranges = [loads[name].typical, (value / 2, 2 * value), (value, value)]
        low, high = next(
            pair for pair in ranges if pair and _is_admissible(problem, {name: pair, **other})
        )
        text = f"from = {toml_value(low, loads[name])}, to = {toml_value(high, loads[name])}"
        yield name, f"{{ {text}, count = 5 }}"
    for name, values in other.items():
        yield name, toml_value(values, loads[name])


def _is_admissible(problem: Problem, values: dict[str, tuple[float, float]]) -> bool:
    """Return True if the problem is valid at all corners of the ranges."""
    model, corners = KindModel(problem, outputs=()), product(*values.values())
    return all(model.admits(dict(zip(values, corner, strict=True))) for corner in corners)
