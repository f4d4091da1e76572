"""``$(eval ...)``: a small, safe part of Python's expressions (X71, https://wiki.ros.org/roslaunch/XML).

The text is parsed to a syntax tree and every node of it is interpreted here; what is not listed is refused. Attributes
are those of ``math`` and a few methods of plain values, there is no comprehension or lambda and no name but those
given, and sizes are bounded, so that an expression can neither reach into the interpreter nor keep it busy for long.
"""

from __future__ import annotations

import ast
import math
import operator
from collections.abc import Callable, Mapping
from typing import Any

from pyros1.errors import LaunchError

_MAX_TEXT = 10_000
_MAX_SIZE = 10_000
_MAX_BITS = 4096

_BINARY: dict[type[ast.operator], Callable[[Any, Any], Any]] = {
    ast.Add: operator.add,
    ast.Sub: operator.sub,
    ast.Mult: operator.mul,
    ast.Div: operator.truediv,
    ast.FloorDiv: operator.floordiv,
    ast.Mod: operator.mod,
    ast.Pow: operator.pow,
    ast.LShift: operator.lshift,
    ast.RShift: operator.rshift,
    ast.BitAnd: operator.and_,
    ast.BitOr: operator.or_,
    ast.BitXor: operator.xor,
}
_UNARY: dict[type[ast.unaryop], Callable[[Any], Any]] = {
    ast.UAdd: operator.pos,
    ast.USub: operator.neg,
    ast.Not: operator.not_,
    ast.Invert: operator.invert,
}
_COMPARE: dict[type[ast.cmpop], Callable[[Any, Any], Any]] = {
    ast.Eq: operator.eq,
    ast.NotEq: operator.ne,
    ast.Lt: operator.lt,
    ast.LtE: operator.le,
    ast.Gt: operator.gt,
    ast.GtE: operator.ge,
    ast.Is: operator.is_,
    ast.IsNot: operator.is_not,
    ast.In: lambda left, right: left in right,
    ast.NotIn: lambda left, right: left not in right,
}
_MATH = {
    name: getattr(math, name)
    for name in dir(math)
    if not name.startswith("_") and name not in ("factorial", "comb", "perm")
}
_BUILTINS: dict[str, Any] = {
    "list": list,
    "dict": dict,
    "map": map,
    "str": str,
    "float": float,
    "int": int,
    "true": True,
    "false": False,
    "True": True,
    "False": False,
    **_MATH,
}
# Methods of plain values that launch files use; none of them gives access to anything but its own value.
_STR_METHODS = frozenset(
    (
        *("capitalize", "count", "endswith", "find", "index", "isalnum", "isalpha", "isdigit", "islower", "isspace"),
        *("isupper", "join", "lower", "lstrip", "partition", "replace", "rfind", "rindex", "rpartition", "rsplit"),
        *("rstrip", "split", "splitlines", "startswith", "strip", "swapcase", "title", "upper"),
    )
)
_LIST_METHODS = frozenset(("count", "index"))
_DICT_METHODS = frozenset(("get", "keys", "values", "items"))
_METHODS: dict[type, frozenset[str]] = {
    str: _STR_METHODS,
    list: _LIST_METHODS,
    tuple: _LIST_METHODS,
    dict: _DICT_METHODS,
}


def evaluate(text: str, variables: Mapping[str, Any], functions: Mapping[str, Callable[..., Any]]) -> str:
    """Evaluate the expression of ``$(eval text)``.

    Args:
        text: the expression.
        variables: the launch arguments by name, typed.
        functions: ``arg``, ``env``, ``find``, ...; they win over variables and builtins of the same name.

    Returns:
        The result as a string.

    Raises:
        LaunchError: a syntax error, a construct or name that is not allowed, or the evaluation failed.
    """
    if "__" in text:
        raise LaunchError("$(eval ...) may not contain double-underscore expressions")
    if len(text) > _MAX_TEXT:
        raise LaunchError("$(eval ...) is too long")
    try:
        tree = ast.parse(text.strip(), mode="eval")
        return str(_Interpreter({**_BUILTINS, **variables, **functions}).value(tree.body))
    except LaunchError:
        raise
    except SyntaxError as error:
        raise LaunchError(f"cannot parse $(eval {text}): {error.msg}") from error
    except (ArithmeticError, TypeError, ValueError, LookupError, RecursionError, MemoryError) as error:
        raise LaunchError(f"cannot evaluate $(eval {text}): {error}") from error


class _Interpreter:
    def __init__(self, names: Mapping[str, Any]) -> None:
        self._names = names

    def value(self, node: ast.expr) -> Any:
        method = getattr(self, "_" + type(node).__name__.lower(), None)
        if method is None:
            raise LaunchError(f"$(eval ...) does not allow {type(node).__name__} expressions")
        return _bounded(method(node))

    def _constant(self, node: ast.Constant) -> Any:
        return node.value

    def _name(self, node: ast.Name) -> Any:
        if node.id == "math":
            raise LaunchError("$(eval ...): 'math' can only be used as in math.sqrt(x)")
        if node.id not in self._names:
            raise LaunchError(f"$(eval ...): name '{node.id}' is not defined")
        return self._names[node.id]

    def _list(self, node: ast.List) -> Any:
        return [self.value(item) for item in node.elts]

    def _tuple(self, node: ast.Tuple) -> Any:
        return tuple(self.value(item) for item in node.elts)

    def _dict(self, node: ast.Dict) -> Any:
        if any(key is None for key in node.keys):
            raise LaunchError("$(eval ...) does not allow ** in a dict")
        return {
            self.value(key): self.value(item)
            for key, item in zip(node.keys, node.values, strict=True)
            if key is not None
        }

    def _unaryop(self, node: ast.UnaryOp) -> Any:
        return _UNARY[type(node.op)](self.value(node.operand))

    def _binop(self, node: ast.BinOp) -> Any:
        if type(node.op) not in _BINARY:
            raise LaunchError("$(eval ...) does not allow this operator")
        left, right = self.value(node.left), self.value(node.right)
        if isinstance(node.op, ast.Pow | ast.LShift) and isinstance(left, int) and isinstance(right, int):
            bits = right + left.bit_length() if isinstance(node.op, ast.LShift) else right * left.bit_length()
            if bits > _MAX_BITS:
                raise LaunchError("$(eval ...): the result is too large")
        if isinstance(node.op, ast.Mult):
            for one, other in ((left, right), (right, left)):
                if isinstance(one, str | list | tuple) and isinstance(other, int) and len(one) * other > _MAX_SIZE:
                    raise LaunchError("$(eval ...): the result is too large")
        if isinstance(node.op, ast.Mod) and isinstance(left, str) and any(digit in left for digit in "0123456789*"):
            raise LaunchError("$(eval ...) does not allow widths in string formatting")
        return _BINARY[type(node.op)](left, right)

    def _boolop(self, node: ast.BoolOp) -> Any:
        stop = isinstance(node.op, ast.Or)
        result: Any = None
        for item in node.values:
            result = self.value(item)
            if bool(result) is stop:
                break
        return result

    def _compare(self, node: ast.Compare) -> Any:
        left = self.value(node.left)
        result: Any = True
        for op, item in zip(node.ops, node.comparators, strict=True):
            right = self.value(item)
            result = _COMPARE[type(op)](left, right)
            if not result:
                break
            left = right
        return result

    def _ifexp(self, node: ast.IfExp) -> Any:
        return self.value(node.body) if self.value(node.test) else self.value(node.orelse)

    def _subscript(self, node: ast.Subscript) -> Any:
        return self.value(node.value)[self._index(node.slice)]

    def _index(self, node: ast.expr) -> Any:
        if isinstance(node, ast.Slice):
            return slice(*(None if part is None else self.value(part) for part in (node.lower, node.upper, node.step)))
        return self.value(node)

    def _attribute(self, node: ast.Attribute) -> Any:
        if isinstance(node.value, ast.Name) and node.value.id == "math" and node.attr in _MATH:
            return _MATH[node.attr]
        value = self.value(node.value)
        allowed = _METHODS.get(type(value))
        if allowed is None or node.attr not in allowed:
            raise LaunchError(f"$(eval ...) does not allow the attribute '{node.attr}'")
        return getattr(value, node.attr)

    def _call(self, node: ast.Call) -> Any:
        function = self.value(node.func)
        if not callable(function) or any(keyword.arg is None for keyword in node.keywords):
            raise LaunchError("$(eval ...): this cannot be called")
        if any(isinstance(argument, ast.Starred) for argument in node.args):
            raise LaunchError("$(eval ...) does not allow * in a call")
        arguments = [self.value(argument) for argument in node.args]
        keywords = {str(keyword.arg): self.value(keyword.value) for keyword in node.keywords}
        return function(*arguments, **keywords)

    def _joinedstr(self, node: ast.JoinedStr) -> Any:
        raise LaunchError("$(eval ...) does not allow f-strings")


def _bounded(value: Any) -> Any:
    if isinstance(value, str | list | tuple | dict) and len(value) > _MAX_SIZE:
        raise LaunchError("$(eval ...): the result is too large")
    return value
