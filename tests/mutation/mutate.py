"""Small mistakes that a programmer could make: from the text of a module to its mutants. Pure."""

from __future__ import annotations

import ast
import copy
import hashlib
from collections.abc import Container, Iterator, Sequence
from dataclasses import dataclass

COMPARISONS: dict[type[ast.cmpop], type[ast.cmpop]] = {
    ast.Lt: ast.LtE,
    ast.LtE: ast.Lt,
    ast.Gt: ast.GtE,
    ast.GtE: ast.Gt,
    ast.Eq: ast.NotEq,
    ast.NotEq: ast.Eq,
    ast.Is: ast.IsNot,
    ast.IsNot: ast.Is,
    ast.In: ast.NotIn,
    ast.NotIn: ast.In,
}
ARITHMETIC: dict[type[ast.operator], type[ast.operator]] = {
    ast.Add: ast.Sub,
    ast.Sub: ast.Add,
    ast.Mult: ast.FloorDiv,
    ast.Div: ast.Mult,
    ast.FloorDiv: ast.Mult,
    ast.Mod: ast.Mult,
    ast.LShift: ast.RShift,
    ast.RShift: ast.LShift,
    ast.BitAnd: ast.BitOr,
    ast.BitOr: ast.BitAnd,
}
# Calls whose absence no test needs to notice: what they write is for people.
LOGGING = {"debug", "info", "warning", "error", "exception", "log", "print"}


@dataclass(frozen=True)
class Mutant:
    """One mistake. ``start`` and ``end`` are offsets in the UTF-8 text of the module, ``line`` counts from 1."""

    line: int
    start: int
    end: int
    before: str
    after: str

    def apply(self, source: bytes) -> bytes:
        """Return the text of the module with the mistake."""
        return source[: self.start] + self.after.encode() + source[self.end :]

    def __str__(self) -> str:
        return f"{' '.join(self.before.split())}  ->  {' '.join(self.after.split())}"


def mutants(source: bytes, only: Container[int] | None = None) -> list[Mutant]:
    """Return all mutants of a module, in the order of its text; each of them compiles.

    Args:
        source: the module's text.
        only: numbers of lines to which they are limited.
    """
    lines = [0]
    for line in source.splitlines(keepends=True):
        lines.append(lines[-1] + len(line))
    found: dict[tuple[int, int, str], Mutant] = {}
    for node, texts in _changes(ast.parse(source)):
        if node.end_lineno is None or node.end_col_offset is None or (only is not None and node.lineno not in only):
            continue
        start = lines[node.lineno - 1] + node.col_offset
        end = lines[node.end_lineno - 1] + node.end_col_offset
        for after in texts:
            mutant = Mutant(node.lineno, start, end, source[start:end].decode(), after)
            if mutant.before != after and _compiles(mutant.apply(source)):
                found[start, end, after] = mutant
    return sorted(found.values(), key=lambda mutant: (mutant.start, mutant.end, mutant.after))


def choose(names: Sequence[str], count: int, seed: int) -> list[int]:
    """Return the positions of a random sample of mutants, in random order.

    Whether a mutant is chosen depends on its name, so a change of a module changes the sample only there.

    Args:
        names: the mutants' names; see `equivalent.name_of`.
        count: the size of the sample.
        seed: another seed, another sample.
    """

    def draw(position: int) -> bytes:
        return hashlib.sha256(f"{seed} {names[position]}".encode()).digest()

    return sorted(range(len(names)), key=draw)[:count]


def _compiles(source: bytes) -> bool:
    try:
        compile(source, "mutant", "exec")
    except (SyntaxError, ValueError):
        return False
    return True


def _changes(tree: ast.AST) -> Iterator[tuple[ast.expr | ast.stmt, list[str]]]:
    """Yield nodes with the texts that could stand in their place."""
    waiting: list[ast.AST] = [tree]
    while waiting:
        node = waiting.pop()
        if isinstance(node, ast.stmt):
            yield node, list(_statement(node))
        elif isinstance(node, ast.expr):
            yield node, [f"({ast.unparse(changed)})" for changed in _expression(node)]
        waiting += _children(node)


def _children(node: ast.AST) -> list[ast.AST]:
    """Return the nodes below it that decide what a program does: no annotations, decorators, f-strings, docstrings."""
    match node:
        case ast.JoinedStr() | ast.Expr(value=ast.Constant()) | ast.If(test=ast.Name(id="TYPE_CHECKING")):
            return []
        case ast.AnnAssign(value=value):
            return [value] if value else []
        case ast.FunctionDef() | ast.AsyncFunctionDef():
            return [*node.args.defaults, *(value for value in node.args.kw_defaults if value), *node.body]
        case ast.ClassDef():
            return list(node.body)
    return list(ast.iter_child_nodes(node))


def _statement(node: ast.stmt) -> Iterator[str]:
    match node:
        case ast.Expr(value=ast.Call(func=called)):
            if ast.unparse(called).rpartition(".")[2] not in LOGGING:
                yield "pass"
        case ast.Expr(value=ast.Await()) | ast.Raise() | ast.Delete():
            yield "pass"
        case ast.Return(value=ast.expr() as value) if not (isinstance(value, ast.Constant) and value.value is None):
            yield "return None"
        case ast.AugAssign(op=operator) if type(operator) in ARITHMETIC:
            changed = copy.deepcopy(node)
            changed.op = ARITHMETIC[type(operator)]()
            yield ast.unparse(changed)
        case ast.Break():
            yield "continue"
        case ast.Continue():
            yield "break"


def _expression(node: ast.expr) -> Iterator[ast.expr]:
    match node:
        case ast.Compare():
            for index, comparison in enumerate(node.ops):
                changed = copy.deepcopy(node)
                changed.ops[index] = COMPARISONS[type(comparison)]()
                yield changed
        case ast.BoolOp():
            changed_op = copy.deepcopy(node)
            changed_op.op = ast.Or() if isinstance(node.op, ast.And) else ast.And()
            yield changed_op
            for index in range(len(node.values)):
                rest = node.values[:index] + node.values[index + 1 :]
                yield rest[0] if len(rest) == 1 else ast.BoolOp(node.op, rest)
        case ast.UnaryOp(op=ast.Not() | ast.USub()):
            yield node.operand
        case ast.BinOp(op=operator) if type(operator) in ARITHMETIC and not _is_text(node):
            yield ast.BinOp(node.left, ARITHMETIC[type(operator)](), node.right)
        case ast.Constant(value=bool() as flag):
            yield ast.Constant(not flag)
        case ast.Constant(value=(int() | float()) as number):
            yield ast.Constant(number + 1)
        case ast.IfExp():
            yield ast.IfExp(node.test, node.orelse, node.body)
        case ast.Subscript(slice=ast.Slice(lower=lower, upper=upper, step=step)) if lower or upper:
            yield ast.Subscript(node.value, ast.Slice(upper, lower, step), ast.Load())
        case ast.Call():
            for index in range(len(node.keywords)):
                yield ast.Call(node.func, node.args, node.keywords[:index] + node.keywords[index + 1 :])


def _is_text(node: ast.BinOp) -> bool:
    """Return whether it puts texts together: with another operator that is an error wherever it runs."""
    return any(
        isinstance(side, ast.JoinedStr) or (isinstance(side, ast.Constant) and isinstance(side.value, str | bytes))
        for side in (node.left, node.right)
    )
