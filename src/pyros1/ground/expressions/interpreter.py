"""Interprets expressions: defines the allowed subset of Python's syntax, and what it means.

A text is parsed to Python's syntax tree, checked to contain only harmless nodes, and interpreted node by node; nothing
is compiled or executed. Assignments, and attributes that begin with ``_`` (except for some attributes of messages), are
not allowed, and sizes and loops are limited. So an expression can neither access Python's internals nor keep the
program busy for long.

Subclasses of `Interpreter` define the nodes, names, attributes and functions that are available.
"""

from __future__ import annotations

import ast
import functools
from collections.abc import Callable, Iterator, Mapping
from typing import Any, ClassVar

from pyros1.ground.expressions import costs
from pyros1.ground.expressions.functions import (
    MATH_NAMES,
    calls_first_argument,
    calls_key,
    find_method,
    format_field,
    method_owner,
)
from pyros1.ground.expressions.lambdas import Lambda, is_plain
from pyros1.ground.expressions.limits import (
    CALL_COST,
    MAX_ITEMS,
    MAX_TEXT,
    MAX_WORK,
    SCALAR_TYPES,
    STEP_COST,
    TOO_EXPENSIVE,
    ExpressionError,
    LimitError,
    UnknownNameError,
    check_bits,
    check_hashes,
    check_limit,
    measure,
)
from pyros1.ground.expressions.operators import BINARY_OPERATORS, COMPARISON_OPERATORS, UNARY_OPERATORS, check_result

# Type of node -> method of Interpreter that evaluates it.
_EVALUATORS: dict[type[ast.expr], str] = {
    ast.Attribute: "_attribute",
    ast.BinOp: "_binop",
    ast.BoolOp: "_boolop",
    ast.Call: "_call",
    ast.Compare: "_compare",
    ast.Constant: "_constant",
    ast.Dict: "_dict",
    ast.DictComp: "_dictcomp",
    ast.FormattedValue: "_formatted",
    ast.GeneratorExp: "_listcomp",
    ast.IfExp: "_ifexp",
    ast.JoinedStr: "_joined",
    ast.Lambda: "_lambda",
    ast.List: "_list",
    ast.ListComp: "_listcomp",
    ast.Name: "_name",
    ast.Set: "_set",
    ast.SetComp: "_setcomp",
    ast.Slice: "_slice",
    ast.Starred: "_starred",
    ast.Subscript: "_subscript",
    ast.Tuple: "_tuple",
    ast.UnaryOp: "_unaryop",
}
_EVALUATION_ERRORS = (ArithmeticError, AttributeError, LookupError, MemoryError, RecursionError, TypeError, ValueError)
_MAX_SMALL_INT = 1 << 63


def _is_assignable(node: ast.expr) -> bool:
    return isinstance(node, ast.Name) or (isinstance(node, ast.Tuple) and all(map(_is_assignable, node.elts)))


def _assign(target: ast.expr, item: Any, names: dict[str, Any]) -> None:
    """Assign values to the names of a comprehension's target, as in ``for a, (b, c) in``."""
    if isinstance(target, ast.Name):
        names[target.id] = item
    elif isinstance(target, ast.Tuple):
        items = list(item)
        if len(items) != len(target.elts):
            raise ExpressionError(f"cannot assign {len(items)} values to {len(target.elts)} names")
        for name, part in zip(target.elts, items, strict=True):
            _assign(name, part, names)


class Interpreter:
    """One checked expression.

    Subclasses restrict or extend the language with the class attributes, `check`, `constant`, `name` and `attribute`.
    By default, the given names, literals, methods of plain values, and math are available.

    Args:
        text: the expression.

    Raises:
        ExpressionError: the text is malformed, too long, or uses syntax that is not allowed.
    """

    allowed_nodes: ClassVar[frozenset[type[ast.expr]]] = frozenset(_EVALUATORS)
    """The allowed types of syntax nodes, among those that this class supports."""

    private_attributes: ClassVar[frozenset[str]] = frozenset()
    """The attributes beginning with ``_`` that are allowed."""

    max_items: ClassVar[int] = MAX_ITEMS
    """Maximum `size` of a computed value."""

    max_work: ClassVar[int] = MAX_WORK
    """Maximum work of an evaluation; see `limits`."""

    def __init__(self, text: str) -> None:
        self._work = 0
        self._arguments: list[ast.expr] = []  # the arguments of all calls
        if len(text) > MAX_TEXT:
            raise ExpressionError(f"the expression has more than {MAX_TEXT} characters")
        try:
            self._root = ast.parse(text.strip(), mode="eval").body
            for node in ast.walk(self._root):
                self.check(node)
        except ExpressionError:
            raise
        except SyntaxError as error:
            raise ExpressionError(f"not an expression: {error.msg}") from None
        except (ValueError, RecursionError, MemoryError) as error:
            raise ExpressionError(f"not an expression: {str(error) or 'nested too deeply'}") from None

    def evaluate(self, names: Mapping[str, Any]) -> Any:
        """Evaluate the expression, and return its value.

        Args:
            names: the values of the names in the expression.

        Raises:
            ExpressionError: a name is unknown, types do not match, a result is too large, or the evaluation fails for
                another reason.
        """
        self._work = 0
        try:
            return self.evaluate_node(self._root, names)
        except ExpressionError:
            raise
        except _EVALUATION_ERRORS as error:
            raise ExpressionError(str(error) or type(error).__name__) from error

    # Methods that subclasses can override
    # ------------------------------------------------------------------------------------

    def check(self, node: ast.AST) -> None:
        """Check that a node is allowed; called for each node before the evaluation.

        Raises:
            ExpressionError: the node is not allowed in an expression.
        """
        node_type = type(node).__name__
        if isinstance(node, ast.expr) and type(node) not in self.allowed_nodes:
            raise ExpressionError(f"{node_type} is not allowed in an expression")
        if isinstance(node, ast.operator) and type(node) not in BINARY_OPERATORS:
            raise ExpressionError(f"{node_type} is not allowed in an expression")
        if isinstance(node, ast.Attribute) and node.attr.startswith("_") and node.attr not in self.private_attributes:
            raise ExpressionError(f"{node.attr} is not accessible")
        if isinstance(node, ast.Call) and not isinstance(node.func, ast.Name | ast.Attribute):
            raise ExpressionError("only plain function calls are allowed")
        if (isinstance(node, ast.keyword) and node.arg is None) or (isinstance(node, ast.Dict) and None in node.keys):
            raise ExpressionError("** is not allowed here")
        if isinstance(node, ast.Call):
            self._arguments.extend((*node.args, *(keyword.value for keyword in node.keywords)))
        if isinstance(node, ast.Lambda) and not (is_plain(node.args) and any(node is each for each in self._arguments)):
            raise ExpressionError("Lambda is only allowed as an argument of a function, and with plain arguments")
        if isinstance(node, ast.comprehension) and (node.is_async or not _is_assignable(node.target)):
            raise ExpressionError("a comprehension can only assign its items to names")

    def constant(self, value: Any) -> Any:
        """Return the value of a literal."""
        return value

    def name(self, name: str, names: Mapping[str, Any]) -> Any:
        """Return the value of a name.

        Raises:
            UnknownNameError: the name is unknown.
        """
        if name not in names:
            raise UnknownNameError(f"unknown name {name!r}")
        return names[name]

    def attribute(self, owner: Any, name: str) -> Any:
        """Return a field or method of a value; `name` does not begin with ``_``, unless it is one of
        `private_attributes`.

        Raises:
            ExpressionError: there is no such attribute, or it is not available in expressions.
        """
        member = find_method(owner, name, self.max_items)
        if member is None:
            raise ExpressionError(f"{type(owner).__name__!r} object has no attribute {name!r}")
        return member

    def check_operands(self, *values: Any) -> None:
        """Check values before an operator or function combines them, for languages with values such as arrays.

        Raises:
            ExpressionError: the result would be too large.
        """

    def check_matrices(self, left: Any, right: Any) -> None:
        """Check matrices before they are multiplied; see `check_operands`."""

    def check_formatting(self, *values: Any) -> None:
        """Check values before they are formatted; see `check_operands`."""

    def check_index(self, owner: Any, key: Any) -> None:
        """Check a value and an index before the item is accessed; see `check_operands`."""

    # The nodes -----------------------------------------------------------------------------------------------------

    def evaluate_node(self, node: ast.expr, names: Mapping[str, Any]) -> Any:
        """Evaluate a node of the checked tree, and return its value."""
        self._work += STEP_COST
        if self._work > self.max_work:
            raise LimitError(TOO_EXPENSIVE)
        return _EVALUATOR_FUNCTIONS[type(node)](self, node, names)

    def _checked(self, value: Any) -> Any:
        cls = type(value)
        if cls is float or cls is bool or (cls is int and -_MAX_SMALL_INT < value < _MAX_SMALL_INT):
            return value
        if cls is int:
            self._charge(STEP_COST)
            return check_bits(value)
        size, visited = measure(value, self.max_items)
        self._charge(visited)
        check_limit(size, self.max_items)
        return check_bits(value)

    def _charge(self, items: int) -> None:
        """Add the cost of the next operation; raise LimitError if the expression takes too much work."""
        self._work += items
        if self._work > self.max_work:
            raise LimitError(TOO_EXPENSIVE)

    def _charge_reading(self, *values: Any) -> None:
        """Add the cost of an operation that visits all of the given values, with everything in them."""
        for value in values:
            if type(value) not in SCALAR_TYPES:
                self._charge(costs.deep_size(value, self.max_work - self._work))

    def _constant(self, node: ast.Constant, names: Mapping[str, Any]) -> Any:
        return self._checked(self.constant(node.value))

    def _name(self, node: ast.Name, names: Mapping[str, Any]) -> Any:
        return self.name(node.id, names)

    def _attribute(self, node: ast.Attribute, names: Mapping[str, Any]) -> Any:
        if isinstance(node.value, ast.Name) and node.value.id == "math":  # the module itself is not a value
            if node.attr not in MATH_NAMES:
                raise ExpressionError(
                    f"math.{node.attr} is not available in expressions; use one of: {', '.join(MATH_NAMES)}"
                )
            return MATH_NAMES[node.attr]
        return self.attribute(self.evaluate_node(node.value, names), node.attr)

    def _list(self, node: ast.List, names: Mapping[str, Any]) -> Any:
        return self._checked(list(self._values(node.elts, names)))

    def _tuple(self, node: ast.Tuple, names: Mapping[str, Any]) -> Any:
        return self._checked(tuple(self._values(node.elts, names)))

    def _dict(self, node: ast.Dict, names: Mapping[str, Any]) -> Any:
        pairs = zip(node.keys, node.values, strict=True)
        return self._checked(
            {self.evaluate_node(key, names): self.evaluate_node(item, names) for key, item in pairs if key}
        )

    def _set(self, node: ast.Set, names: Mapping[str, Any]) -> Any:
        items = list(self._values(node.elts, names))
        check_hashes(items)
        return self._checked(set(items))

    def _values(self, nodes: list[ast.expr], names: Mapping[str, Any]) -> Iterator[Any]:
        """Yield the values of items or arguments; ``*value`` yields the items of the value."""
        for node in nodes:
            if not isinstance(node, ast.Starred):
                yield self.evaluate_node(node, names)
                continue
            for count, item in enumerate(self.evaluate_node(node.value, names), 1):
                self._charge(STEP_COST)
                check_limit(count, self.max_items)
                yield item

    def _starred(self, node: ast.Starred, names: Mapping[str, Any]) -> Any:
        raise ExpressionError("* is only allowed before an argument or an item")

    def _lambda(self, node: ast.Lambda, names: Mapping[str, Any]) -> Any:
        return Lambda(self.evaluate_node, node, names)

    # A generator expression is evaluated immediately, so that the limits apply to its result as well.
    def _listcomp(self, node: ast.ListComp | ast.GeneratorExp, names: Mapping[str, Any]) -> Any:
        return self._comprehension(node.generators, names, lambda scope: self.evaluate_node(node.elt, scope))

    def _setcomp(self, node: ast.SetComp, names: Mapping[str, Any]) -> Any:
        items = self._comprehension(node.generators, names, lambda scope: self.evaluate_node(node.elt, scope))
        check_hashes(items)
        return set(items)

    def _dictcomp(self, node: ast.DictComp, names: Mapping[str, Any]) -> Any:
        def pair(scope: Mapping[str, Any]) -> tuple[Any, Any]:
            return self.evaluate_node(node.key, scope), self.evaluate_node(node.value, scope)

        pairs = self._comprehension(node.generators, names, pair)
        check_hashes(key for key, _ in pairs)
        return dict(pairs)

    def _comprehension(
        self, loops: list[ast.comprehension], names: Mapping[str, Any], evaluate: Callable[[Mapping[str, Any]], Any]
    ) -> list[Any]:
        results: list[Any] = []
        total = 0
        for scope in self._loop(loops, dict(names)):
            results.append(evaluate(scope))
            self._charge(len(loops))  # each result goes through all loops
            total += 1
            if type(results[-1]) not in SCALAR_TYPES or type(results[-1]) is int:
                size, visited = measure(results[-1], self.max_items)
                self._charge(visited)
                total += size
            check_limit(total, self.max_items)
        return results

    def _loop(self, loops: list[ast.comprehension], names: dict[str, Any]) -> Iterator[dict[str, Any]]:
        if not loops:
            yield names
            return
        outer_loop, *inner_loops = loops
        for item in self.evaluate_node(outer_loop.iter, names):
            self._charge(STEP_COST)
            _assign(outer_loop.target, item, names)
            if all(self.evaluate_node(condition, names) for condition in outer_loop.ifs):
                yield from self._loop(inner_loops, names)

    def _subscript(self, node: ast.Subscript, names: Mapping[str, Any]) -> Any:
        owner, key = self.evaluate_node(node.value, names), self.evaluate_node(node.slice, names)
        self._charge_reading(key)
        self.check_index(owner, key)
        result = owner[key]
        if type(key) is slice:
            self._charge(costs.shallow_size(result))
        return result

    def _slice(self, node: ast.Slice, names: Mapping[str, Any]) -> Any:
        parts = (node.lower, node.upper, node.step)
        return slice(*(None if part is None else self.evaluate_node(part, names) for part in parts))

    def _boolop(self, node: ast.BoolOp, names: Mapping[str, Any]) -> Any:
        *first, last = node.values
        for operand in first:
            result = self.evaluate_node(operand, names)
            if bool(result) is isinstance(node.op, ast.Or):
                return result
        return self.evaluate_node(last, names)

    def _compare(self, node: ast.Compare, names: Mapping[str, Any]) -> Any:
        left = self.evaluate_node(node.left, names)
        result: Any = True
        for index, (op, comparator) in enumerate(zip(node.ops, node.comparators, strict=True)):
            if index and not result:  # only a chain needs the truth value, which numpy arrays do not have
                break
            right = self.evaluate_node(comparator, names)
            is_membership = isinstance(op, ast.In | ast.NotIn)
            if not isinstance(op, ast.Is | ast.IsNot) and not (is_membership and isinstance(right, dict | set)):
                self.check_operands(left, right)
            if is_membership:
                self._charge(costs.membership_cost(left, right, self.max_work))
            elif type(left) not in SCALAR_TYPES and not isinstance(op, ast.Is | ast.IsNot):
                self._charge_reading(right)
            result = self._checked(COMPARISON_OPERATORS[type(op)](left, right))
            left = right
        return result

    def _ifexp(self, node: ast.IfExp, names: Mapping[str, Any]) -> Any:
        return self.evaluate_node(node.body if self.evaluate_node(node.test, names) else node.orelse, names)

    def _unaryop(self, node: ast.UnaryOp, names: Mapping[str, Any]) -> Any:
        return self._checked(UNARY_OPERATORS[type(node.op)](self.evaluate_node(node.operand, names)))

    def _binop(self, node: ast.BinOp, names: Mapping[str, Any]) -> Any:
        left, right = self.evaluate_node(node.left, names), self.evaluate_node(node.right, names)
        check_result(node.op, left, right, self.max_items)
        if isinstance(node.op, ast.Mod) and isinstance(left, str):
            self.check_formatting(right)
        else:
            self.check_operands(left, right)
        if isinstance(node.op, ast.MatMult):
            self.check_matrices(left, right)
        self._charge(costs.operator_cost(node.op, left, right, self.max_work))
        return self._checked(BINARY_OPERATORS[type(node.op)](left, right))

    def _call(self, node: ast.Call, names: Mapping[str, Any]) -> Any:
        function = self.evaluate_node(node.func, names)
        arguments = list(self._values(node.args, names))
        keywords = {str(keyword.arg): self.evaluate_node(keyword.value, names) for keyword in node.keywords}
        return self._call_function(function, *arguments, **keywords)

    def _call_function(self, function: Callable[..., Any], *arguments: Any, **keywords: Any) -> Any:
        self._charge(CALL_COST + costs.call_cost(function, arguments, keywords, self.max_work))
        if calls_first_argument(function) and arguments and arguments[0] is not None:
            arguments = (functools.partial(self._call_function, arguments[0]), *arguments[1:])
        if calls_key(function) and keywords.get("key") is not None:
            keywords["key"] = self._limited_key(keywords["key"])
        owner = method_owner(function)
        if function is set or isinstance(owner, set):
            for argument in arguments:
                check_hashes(argument)
        elif function is dict and arguments and not isinstance(arguments[0], dict):
            check_hashes(pair[0] for pair in map(tuple, arguments[0]) if pair)
        return self._checked(function(*arguments, **keywords))

    def _limited_key(self, function: Callable[..., Any]) -> Callable[[Any], Any]:
        """Return a key function that limits the total size of its results, which are all in memory while sorting."""
        total = 0

        def key(item: Any) -> Any:
            nonlocal total
            value = self._call_function(function, item)
            total += 1 + measure(value, self.max_items)[0]
            check_limit(total, self.max_items)
            return value

        return key

    def _joined(self, node: ast.JoinedStr, names: Mapping[str, Any]) -> Any:
        return self._checked("".join(self.evaluate_node(part, names) for part in node.values))

    def _formatted(self, node: ast.FormattedValue, names: Mapping[str, Any]) -> Any:
        spec = self.evaluate_node(node.format_spec, names) if node.format_spec else ""
        conversion = chr(node.conversion) if node.conversion > 0 else None
        value = self.evaluate_node(node.value, names)
        self._charge_reading(value)
        self.check_formatting(value)
        return self._checked(format_field(value, conversion, spec, self.max_items))


_EVALUATOR_FUNCTIONS: dict[type[ast.expr], Callable[[Interpreter, Any, Mapping[str, Any]], Any]] = {
    node_type: getattr(Interpreter, name) for node_type, name in _EVALUATORS.items()
}
