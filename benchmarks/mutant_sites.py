"""Where a source file can be made wrong, and how: the operators of the mutation test (mutants.py).

A site is a place in the file (an operator, a number, a comparison, a call, a condition, a returned
value); each has one or several mutations, that is, texts to put in the place of its own.  They are
faults that a programmer of numerical code makes and that mostly run: None for a value, or an
argument of one of our functions left out or swapped, stops at once and tells nothing of the tests.

    arithmetic    a + b: a - b, a, b       a - b: a + b, a, -b       a * b: a / b, a, b
                  a / b: a * b, a          a ** b: a * b, a          a @ b: b @ a, -(a @ b)
                  a // b: -(-a // b)       a % b: a // b, a          a & b: a | b, a, b
    sign          -a: a                    ~a: a
    comparison    a < b: a <= b, a > b     a == b: a != b            the same for is, in
    logic         a and b: a or b, a, b    not a: a                  if a: if not a
    number        whole: one more, one less (also an index)          True: False
                  x: 0, 2 x                0.0: 1.0
                  below 1e-3 or from 1e3 on (tolerances, limits): a thousandfold, a thousandth
    function      min: max, sin: cos, any: all, zeros: ones ...      abs(a), sqrt(a) ...: a
                  min(a, b): a, b          a, b: b, a where both are of one form
                  of NumPy and SciPy: f(a, b): f(b, a); a keyword left out: its default
    slice         a[i:j]: a[i:], a[:j]     a bound that is no number: one more, one less
    return        a number or array: -a, 0 a    a truth: not a       X | None: None
    statement     a += b: a -= b, nothing; f(...): nothing; raise ...: nothing; break: continue

Docstrings and other texts, annotations, decorators, imports, the arguments of what is raised or
warned, ``__all__`` and ``if TYPE_CHECKING`` are left alone.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

SMALL, LARGE = 1e-3, 1e3  # numbers outside are tolerances and limits: twice is no fault there

ARITHMETIC: dict[type, type[ast.operator]] = {
    ast.Add: ast.Sub, ast.Sub: ast.Add, ast.Mult: ast.Div, ast.Div: ast.Mult, ast.Pow: ast.Mult,
    ast.Mod: ast.FloorDiv, ast.BitAnd: ast.BitOr, ast.BitOr: ast.BitAnd,
}  # fmt: skip
COMPARISONS: dict[type, tuple[type[ast.cmpop], ...]] = {
    ast.Lt: (ast.LtE, ast.Gt), ast.LtE: (ast.Lt, ast.Gt),
    ast.Gt: (ast.GtE, ast.Lt), ast.GtE: (ast.Gt, ast.Lt),
    ast.Eq: (ast.NotEq,), ast.NotEq: (ast.Eq,), ast.Is: (ast.IsNot,), ast.IsNot: (ast.Is,),
    ast.In: (ast.NotIn,), ast.NotIn: (ast.In,),
}  # fmt: skip
PAIRS = ("min max", "minimum maximum", "argmin argmax", "nanmin nanmax", "any all", "floor ceil",
         "sin cos", "sinh cosh", "zeros ones", "zeros_like ones_like", "triu tril",
         "logical_and logical_or")  # fmt: skip
PARTNERS = {a: b for pair in PAIRS for a, b in (pair.split(), reversed(pair.split()))}
CHOICES = {"min", "max", "minimum", "maximum"}
UNARY = {"abs", "sqrt", "exp", "expm1", "log", "log1p", "sign", "square", "floor", "ceil", "tan",
         "tanh", "conj", "flip", "cumsum", "diff", "sorted"}  # fmt: skip
# the same whatever the order of their arguments
SYMMETRIC = CHOICES | {"isclose", "allclose", "array_equal", "hypot", "logical_and", "logical_or"}
LIBRARIES = {"np", "scipy", "linalg", "lapack", "special", "sum", "min", "max", "sorted"}
WARNING = {"warn"}
NUMBERS = {"int", "float", "Array", "np.ndarray", "ndarray"}  # annotations of what is returned


@dataclass(frozen=True)
class Site:
    """A place in a source, and what may stand there instead.

    Attributes
    ----------
    operator : str
        The kind of fault, a heading of the list above.
    start, end : int
        The place, in bytes of the source.
    reach : (int, int)
        First and last line of which one must be executed for a test to reach the place.  What is
        executed on import (a constant, a field's default) counts as reached by the tests that
        execute any line of the file; the default of an argument, any line of its function.
    texts : tuple of str
        What to put there, one for each mutation.
    """

    operator: str
    start: int
    end: int
    reach: tuple[int, int]
    texts: tuple[str, ...]

    def old(self, source: str) -> str:
        """Return the text that stands there."""
        return source.encode()[self.start : self.end].decode()

    def line(self, source: str) -> int:
        """Return the number of the line where the place begins."""
        return source.encode().count(b"\n", 0, self.start) + 1

    def applied(self, source: str, text: str) -> str:
        """Return the source with ``text`` at the place."""
        raw = source.encode()
        return (raw[: self.start] + text.encode() + raw[self.end :]).decode()


def find_sites(source: str) -> list[Site]:
    """Return every site of a source file, in the order of the file."""
    walk = _Walk(source)
    walk.visit(ast.parse(source))
    return sorted(walk.sites, key=lambda site: (site.start, site.end, site.operator))


def certificate_sites(source: str, certificates: str) -> list[Site]:
    """Return the sites that make a certificate blind: a law's residual 0, one by one and all.

    Parameters
    ----------
    source : str
    certificates : str
        Pattern of the names of the classes that hold residuals, a keyword for each law.  A function
        ``..._laws`` returns some of these as a dict.
    """
    walk = _Walk(source)
    for call in ast.walk(ast.parse(source)):
        if isinstance(call, ast.FunctionDef) and call.name.endswith("_laws"):
            walk.add_laws_returned(call)
        if not isinstance(call, ast.Call) or not re.fullmatch(certificates, _name(call.func)):
            continue
        zero, laws = ast.Constant(0.0), [word for word in call.keywords if word.arg]
        walk.reach = (call.lineno, call.end_lineno or call.lineno)
        for law in laws:
            walk.add(f"law {law.arg} of {_name(call.func)}", law.value, [zero])
        if laws:
            blind = [_like(law, value=zero) for law in laws]
            walk.add(f"all laws of {_name(call.func)}", call, [_like(call, keywords=blind)])
    return walk.sites


class _Walk(ast.NodeVisitor):
    """Collects the sites of one file."""

    def __init__(self, source: str) -> None:
        lines = source.encode().splitlines(keepends=True)
        self.starts = [sum(map(len, lines[:k])) for k in range(len(lines))]
        self.reach = self.whole = (1, len(lines))
        self.function: ast.FunctionDef | None = None
        self.sites: list[Site] = []

    def add(self, operator: str, node: ast.AST, others: Iterable[ast.AST]) -> None:
        """Note a site: ``others`` are what may stand in the place of ``node``."""
        place: Any = node
        start = self.starts[place.lineno - 1] + place.col_offset
        end = self.starts[place.end_lineno - 1] + place.end_col_offset
        texts = dict.fromkeys(_text(other) for other in others)
        texts.pop(_text(node), None)
        if texts:
            self.sites.append(Site(operator, start, end, self.reach, tuple(texts)))

    def add_laws_returned(self, function: ast.FunctionDef) -> None:
        """Note each value of the dict that a function returns."""
        for node in ast.walk(function):
            if isinstance(node, ast.Return) and isinstance(node.value, ast.Dict):
                self.reach = (node.lineno, node.end_lineno or node.lineno)
                for law, value in zip(node.value.keys, node.value.values, strict=True):
                    name = getattr(law, "value", "")
                    self.add(f"law {name} of {function.name}", value, [ast.Constant(0.0)])

    # statements: what a test must execute to reach them

    def visit(self, node: ast.AST) -> None:
        before = self.reach
        if isinstance(node, ast.stmt):
            self.reach = _own_lines(node) if self.function else self.whole
        super().visit(node)
        self.reach = before

    def visit_FunctionDef(self, node: ast.FunctionDef) -> None:
        outside, self.function = self.function, node
        self.reach = (node.body[0].lineno, node.end_lineno or node.lineno)
        for part in [*node.args.defaults, *node.args.kw_defaults, *node.body]:
            if part is not None:
                self.visit(part)
        self.function = outside

    def visit_ClassDef(self, node: ast.ClassDef) -> None:
        outside, self.function = self.function, None
        for statement in node.body:
            self.visit(statement)
        self.function = outside

    def visit_If(self, node: ast.If) -> None:
        if _name(node.test) != "TYPE_CHECKING":
            self._condition(node.test)
            self.generic_visit(node)

    def visit_While(self, node: ast.While) -> None:
        self._condition(node.test)
        self.generic_visit(node)

    def _condition(self, test: ast.expr) -> None:
        """Turn a condition round; comparisons and negations have better mutations of their own."""
        if not isinstance(test, ast.Compare | ast.UnaryOp | ast.Constant):
            self.add("logic", test, [ast.UnaryOp(ast.Not(), test)])

    def visit_Assign(self, node: ast.Assign) -> None:
        if not any(_name(target) == "__all__" for target in node.targets):
            self.generic_visit(node)

    def visit_AnnAssign(self, node: ast.AnnAssign) -> None:
        if node.value is not None:
            self.visit(node.value)

    def visit_AugAssign(self, node: ast.AugAssign) -> None:
        other = ARITHMETIC.get(type(node.op))
        self.add("statement", node, [*([_like(node, op=other())] if other else []), ast.Pass()])
        self.generic_visit(node)

    def visit_Expr(self, node: ast.Expr) -> None:
        if isinstance(node.value, ast.Call):
            self.add("statement", node, [ast.Pass()])
        self.generic_visit(node)

    def visit_Raise(self, node: ast.Raise) -> None:
        self.add("statement", node, [ast.Pass()])

    def visit_Break(self, node: ast.Break) -> None:
        self.add("statement", node, [ast.Continue()])

    def visit_Continue(self, node: ast.Continue) -> None:
        self.add("statement", node, [ast.Break(), ast.Pass()])

    def visit_Return(self, node: ast.Return) -> None:
        value, promised = node.value, self.function and self.function.returns
        if value is None:
            return
        kinds = re.split(r"\s*\|\s*", ast.unparse(promised)) if promised else []
        others: list[ast.expr] = []
        if NUMBERS.intersection(kinds):
            others = [_minus(value), ast.BinOp(ast.Constant(0), ast.Mult(), value)]
        elif "bool" in kinds:
            others = [ast.UnaryOp(ast.Not(), value)]
        if "None" in kinds:
            others.append(ast.Constant(None))
        self.add("return", value, others)
        self.visit(value)

    # expressions

    def visit_BinOp(self, node: ast.BinOp) -> None:
        self.generic_visit(node)
        a, b, op = node.left, node.right, node.op
        if _is_text(a) or _is_text(b):
            return
        if isinstance(op, ast.MatMult):
            others = [ast.BinOp(b, op, a), _minus(node)]
        elif isinstance(op, ast.FloorDiv):
            others = [_minus(ast.BinOp(_minus(a), op, b))]
        elif type(op) in ARITHMETIC:
            others = [ast.BinOp(a, ARITHMETIC[type(op)](), b), a]
        else:
            others = []
        if isinstance(op, ast.Add | ast.Mult | ast.BitAnd | ast.BitOr):
            others.append(b)
        elif isinstance(op, ast.Sub):
            others.append(_minus(b))
        self.add("arithmetic", node, others)

    def visit_UnaryOp(self, node: ast.UnaryOp) -> None:
        self.generic_visit(node)
        self.add("logic" if isinstance(node.op, ast.Not) else "sign", node, [node.operand])

    def visit_Compare(self, node: ast.Compare) -> None:
        self.generic_visit(node)
        for k, op in enumerate(node.ops):
            others = [other() for other in COMPARISONS[type(op)]]
            changed = [_like(node, ops=_replaced(node.ops, k, other)) for other in others]
            self.add("comparison", node, changed)

    def visit_BoolOp(self, node: ast.BoolOp) -> None:
        self.generic_visit(node)
        other = ast.Or() if isinstance(node.op, ast.And) else ast.And()
        fewer = _without_one(node.values)
        shorter = [_like(node, values=left) if len(left) > 1 else left[0] for left in fewer]
        self.add("logic", node, [_like(node, op=other), *shorter])

    def visit_IfExp(self, node: ast.IfExp) -> None:
        self._condition(node.test)
        self.generic_visit(node)

    def visit_comprehension(self, node: ast.comprehension) -> None:
        for test in node.ifs:
            self._condition(test)
        self.generic_visit(node)

    def visit_Constant(self, node: ast.Constant) -> None:
        value = node.value
        others: list[ast.expr] = []
        if isinstance(value, bool):
            others = [ast.Constant(not value)]
        elif isinstance(value, int):
            others = [ast.Constant(value + 1), ast.Constant(value - 1)]
        elif value == 0.0:
            others = [ast.Constant(1.0)]
        elif isinstance(value, float) and not SMALL <= value < LARGE:
            much = ast.Constant(1000)
            others = [ast.BinOp(node, op, much) for op in (ast.Mult(), ast.Div())]
        elif isinstance(value, float | complex):
            others = [ast.Constant(0.0), ast.BinOp(ast.Constant(2), ast.Mult(), node)]
        self.add("number", node, others)

    def visit_JoinedStr(self, node: ast.JoinedStr) -> None:
        """A text: left alone, and the numbers in it too."""

    def visit_Call(self, node: ast.Call) -> None:
        name, args = _name(node.func), node.args
        if name in WARNING:
            return
        self.generic_visit(node)
        if any(isinstance(arg, ast.Starred) for arg in args):
            return
        others: list[ast.expr] = []
        if name in PARTNERS:
            field = "attr" if isinstance(node.func, ast.Attribute) else "id"
            others.append(_like(node, func=_like(node.func, **{field: PARTNERS[name]})))
        if name in UNARY and len(args) == 1:
            others.append(args[0])
        if name in CHOICES and len(args) > 1:
            others.extend(args)
        self.add("function", node, others)
        if _root(node.func) in LIBRARIES:
            orders = [] if name in SYMMETRIC else _swapped(args)
            self.add("function", node, [_like(node, args=order) for order in orders])
            fewer = _without_one(node.keywords)
            self.add("function", node, [_like(node, keywords=left) for left in fewer])

    def visit_Tuple(self, node: ast.Tuple | ast.List) -> None:
        self.generic_visit(node)
        fixed = any(isinstance(item, ast.Slice | ast.Starred) for item in node.elts)
        if isinstance(node.ctx, ast.Load) and not fixed:
            self.add("function", node, [_like(node, elts=order) for order in _swapped(node.elts)])

    visit_List = visit_Tuple

    def visit_Slice(self, node: ast.Slice) -> None:
        self.generic_visit(node)
        for bound in (node.lower, node.upper):
            if bound is not None and not _is_number(bound):
                one = ast.Constant(1)
                nearby = [ast.BinOp(bound, op, one) for op in (ast.Add(), ast.Sub())]
                self.add("slice", bound, nearby)
        self.add("slice", node, [_like(node, lower=None), _like(node, upper=None)])


def _own_lines(statement: ast.stmt) -> tuple[int, int]:
    """Return the lines of a statement itself, without those of the block it heads."""
    body = getattr(statement, "body", None)
    last = body[0].lineno - 1 if body else statement.end_lineno or statement.lineno
    return statement.lineno, max(statement.lineno, last)


def _like(node: Any, **fields: object) -> Any:
    """Return a node with some fields replaced."""
    return type(node)(**{**dict(ast.iter_fields(node)), **fields})


def _minus(node: ast.expr) -> ast.UnaryOp:
    return ast.UnaryOp(ast.USub(), node)


def _text(node: ast.AST) -> str:
    """Return a node's text, an expression in brackets where its place could tear it apart."""
    text = ast.unparse(node)
    whole = (ast.Name, ast.Attribute, ast.Call, ast.Subscript, ast.List, ast.Tuple, ast.Slice)
    if not isinstance(node, ast.expr) or isinstance(node, whole) or text.isalnum():
        return text
    return f"({text})"


def _replaced(items: Sequence[Any], k: int, item: object) -> list[Any]:
    return [*items[:k], item, *items[k + 1 :]]


def _without_one(items: Sequence[Any]) -> list[list[Any]]:
    return [[*items[:k], *items[k + 1 :]] for k in range(len(items))]


def _swapped(items: Sequence[ast.expr]) -> Iterator[list[ast.expr]]:
    """Yield the items with two neighbours swapped that are of one form, and no texts."""
    for k, (a, b) in enumerate(pairwise(items)):
        if type(a) is type(b) and not (_is_text(a) or _is_text(b)):
            yield [*items[:k], b, a, *items[k + 2 :]]


def _name(node: ast.expr) -> str:
    """Return the last part of a dotted name, "" of anything else."""
    if isinstance(node, ast.Attribute):
        return node.attr
    return node.id if isinstance(node, ast.Name) else ""


def _root(node: ast.expr) -> str:
    """Return the first part of a dotted name."""
    while isinstance(node, ast.Attribute):
        node = node.value
    return _name(node)


def _is_number(node: ast.expr) -> bool:
    value = node.operand if isinstance(node, ast.UnaryOp) else node
    return isinstance(value, ast.Constant)


def _is_text(node: ast.expr) -> bool:
    text = isinstance(node, ast.Constant) and isinstance(node.value, str)
    return text or isinstance(node, ast.JoinedStr)
