"""Generates the function that converts messages in one direction.

The function walks through the message once. `runs.py` moves runs of fixed-size values; this module emits the code for
the strings, arrays and loops between them. The generated code contains no names from definitions.

As in the decoders of pyros1.msgs, most errors in a message are found without explicit checks: reading a struct beyond
the end fails, and after a slice beyond the end, the final position is wrong. Only before a loop is the number of an
array's elements compared with the number of bytes left.
"""

from __future__ import annotations

import struct
from collections.abc import Callable

from pyros1.ground.errors import DefinitionError, MessageError
from pyros1.ros2_types.transcoding import text as texts
from pyros1.ros2_types.transcoding.layout import bulk_layout, minimum_size, weight
from pyros1.ros2_types.transcoding.plan import Array, Changed, Node, Numbers, Record, Text
from pyros1.ros2_types.transcoding.runs import ANY, HEADER_SIZE, Atom, Runs

MAX_LOOP_DEPTH = 12
"""Maximum depth of nested arrays; Python's compiler limits it, too."""
MAX_EMPTY_ELEMENTS = 16
"""Maximum number of elements of an array whose elements take no bytes."""
MAX_VALUES = 10_000
"""Maximum number of values that one function handles, including those of unrolled fixed arrays."""
MAX_ZEROS = 1 << 16
"""Maximum number of bytes that the source lacks, so that a message cannot take much more memory than its size."""
MAX_ADDED = 1 << 26
"""Maximum number of bytes that array elements may add in total if they are more than `_GROWTH` times as large in the
target.
"""
_GROWTH = 8
MAX_UNROLLED = 64
"""Fixed arrays of at most this many values need no loop."""
_LARGE = 4096
"""Arrays of at least this many bytes are copied once, not twice."""

Convert = Callable[[bytes | memoryview, int], bytes]
"""Converts a message, given its bytes and the ``seq`` of its headers; raises `texts.ERRORS` if it is invalid."""


class Generator:
    """Emits the statements that convert a message.

    Args:
        to_cdr: True from ROS 1 to CDR, False for the other direction.
    """

    def __init__(self, *, to_cdr: bool) -> None:
        self._to_cdr = to_cdr
        self._runs = Runs(source_is_cdr=not to_cdr)
        self._emit, self._ref = self._runs.emit, self._runs.ref
        self._values_left = MAX_VALUES
        self._zeros_left = MAX_ZEROS
        self._counts_added = False

    def compile(self, record: Record) -> Convert:
        """Return the function that converts a message.

        Raises:
            DefinitionError: the type is too large.
        """
        runs = self._runs
        self._node(record)
        runs.flush()
        joined = "".join(f"{part}, " for part in runs.parts)
        prefix = "b'\\0\\1\\0\\0', " if self._to_cdr else ""
        lines = [
            "def convert(data, seq):",
            "    end = len(data)",
            f"    p = {0 if self._to_cdr else HEADER_SIZE}",
            *([f"    room = {MAX_ADDED}"] if self._counts_added else []),
            *(f"    {line}" for line in runs.lines),
            f"    if p > end: raise {self._ref(MessageError, 'error')}('it ends too early')",
            f"    return b''.join(({prefix}{joined}))",
        ]
        code = compile("\n".join(lines), "<transcoder>", "exec")
        exec(code, runs.scope.objects)
        function: Convert = runs.scope.objects["convert"]
        return function

    def _in_source(self, node: Node) -> bool:
        return node.in_ros1 if self._to_cdr else node.in_ros2

    def _in_target(self, node: Node) -> bool:
        return node.in_ros2 if self._to_cdr else node.in_ros1

    def _lengths(self, node: Array) -> tuple[int | None, int | None]:
        """Return the numbers of elements in the source and in the target, as in `Array`."""
        return (node.ros1, node.ros2) if self._to_cdr else (node.ros2, node.ros1)

    def _node(self, node: Node, *, skip: bool = False) -> None:
        """Emit the conversion of a value, or, with ``skip``, only move the position past it."""
        reads, writes = self._in_source(node), self._in_target(node) and not skip
        self._values_left -= 1
        if isinstance(node, Numbers) and not reads:
            self._zeros_left -= node.width * node.amount
        if self._values_left < 0 or self._zeros_left < 0:
            raise DefinitionError("its fixed arrays are too large")
        if isinstance(node, Numbers):
            is_seq = node.is_sequence_number and writes and not reads
            self._runs.add(Atom(node.width, node.amount, reads, writes, expression="seq" if is_seq else ""))
        elif isinstance(node, Changed):
            self._changed(node, writes)
        elif isinstance(node, Text):
            self._text(node, reads, writes)
        elif isinstance(node, Array):
            self._array(node, reads, writes)
        else:
            self._record(node, skip=skip)

    def _record(self, node: Record, *, skip: bool) -> None:
        source_order, target_order = (node.ros1, node.ros2) if self._to_cdr else (node.ros2, node.ros1)
        if skip or target_order is None:
            for index in source_order or ():
                self._node(node.nodes[index], skip=True)
            return
        source_order = source_order or ()
        common = [index for index in target_order if index in set(source_order)]
        if common != [index for index in source_order if index in set(common)]:
            self._reorder(node, source_order, target_order)
            return
        left = list(source_order)
        for index in target_order:
            if index in left:
                while left[0] != index:
                    self._node(node.nodes[left.pop(0)], skip=True)
                left.pop(0)
            self._node(node.nodes[index])
        for index in left:
            self._node(node.nodes[index], skip=True)

    def _reorder(self, node: Record, source_order: tuple[int, ...], target_order: tuple[int, ...]) -> None:
        """Emit the conversion of a message whose fields have another order in the target."""
        runs = self._runs
        runs.flush()
        places = {}
        for index in source_order:
            places[index] = runs.assign("place", "p"), runs.source
            self._node(node.nodes[index], skip=True)
            runs.flush()
        end = runs.assign("place", "p"), runs.source
        for index in target_order:
            if index in places:
                place, runs.source = places[index]
                self._emit(f"p = {place}")
            self._node(node.nodes[index])
            runs.flush()
        self._emit(f"p = {end[0]}")
        runs.source = end[1]

    def _changed(self, node: Changed, writes: bool) -> None:
        source, target = (node.ros1, node.ros2) if self._to_cdr else (node.ros2, node.ros1)
        name = self._runs.unique_name("number") if writes else ""
        self._runs.add(Atom(struct.calcsize("<" + source), 1, True, False, name=name, code=source))
        if writes:
            convert = self._ref(node.to_ros2 if self._to_cdr else node.to_ros1, "change")
            width = struct.calcsize("<" + target)
            self._runs.add(Atom(width, 1, False, True, expression=f"{convert}({name})", code=target))

    def _text(self, node: Text, reads: bool, writes: bool) -> None:
        runs, wide = self._runs, node.is_wide
        if not reads:
            if self._to_cdr and not wide:
                runs.add(Atom(4, 1, False, True, expression="1"))
                runs.add(Atom(1, 1, False, True))
            else:
                runs.add(Atom(4, 1, False, True))
            return
        size, length = runs.unique_name("size"), runs.unique_name("length")
        is_simple = writes and not wide
        runs.add(Atom(4, 1, True, is_simple, name=size, expression=length))
        runs.flush([f"{length} = {size}" + ("" if wide else " + 1" if self._to_cdr else f" - ({size} > 0)")])
        if not writes:
            self._emit(f"p += {size}" + (" * 4" if wide and not self._to_cdr else ""))
            runs.source = ANY
            return
        if self._to_cdr or not wide:
            taken = size if self._to_cdr else length
            text = runs.assign("text", f"data[p:p + {taken}]")
            self._emit(f"p += {size}")
        else:
            text = runs.assign("text", f"data[p:p + {size} * 4]")
            self._emit(f"p += {size} * 4")
        runs.source = ANY
        if wide:
            convert = texts.to_wide if self._to_cdr else texts.from_wide
            self._emit(f"{text} = {self._ref(convert, 'convert')}({text}, {size})")
            self._emit(f"{length} = len({text})" + (" >> 2" if self._to_cdr else ""))
        if node.bound and self._to_cdr:
            self._check(f"{length} > {node.bound + (not wide)}", node.label, f"is longer than {node.bound}")
        if wide:
            runs.add(Atom(4, 1, False, True, expression=length))
            runs.flush()
        runs.add_part(text, f"len({text})" if wide else size)
        if self._to_cdr and not wide:
            runs.add(Atom(1, 1, False, True))

    def _check(self, condition: str, label: str, problem: str) -> None:
        text = self._ref(f"{label} {problem}", "text")
        self._emit(f"if {condition}: raise {self._ref(MessageError, 'error')}({text})")

    def _array(self, node: Array, reads: bool, writes: bool) -> None:
        runs = self._runs
        source, target = self._lengths(node)
        if not reads:
            if target == -1:
                runs.add(Atom(4, 1, False, True))
                return
            assert target is not None
            for _ in range(target):
                self._node(node.element)
            return
        assert source is not None
        if source >= 0:
            count = str(source)
            if writes and target == -1:
                runs.add(Atom(4, 1, False, True, expression=count))
        else:
            count = runs.unique_name("count")
            runs.add(Atom(4, 1, True, writes and target == -1, name=count, expression=count))
            runs.flush()
            if writes and self._to_cdr and node.bound:
                self._check(f"{count} > {node.bound}", node.label, f"has more than {node.bound} elements")
            if writes and target is not None and target >= 0:
                self._check(f"{count} != {target}", node.label, f"does not have {target} elements")
                source, count = target, str(target)
        self._elements(node, source, count, skip=not writes)

    def _elements(self, node: Array, count: int, variable: str, *, skip: bool) -> None:
        """Emit the conversion of an array's elements; ``count`` is -1 if only known in the variable."""
        runs, element = self._runs, node.element
        if count >= 0 and isinstance(element, Numbers):
            self._node(element._replace(amount=element.amount * count), skip=skip)
            return
        if count >= 0 and count * weight(element) <= MAX_UNROLLED:
            for _ in range(count):
                self._node(element, skip=skip)
            return
        runs.flush()
        bulk = bulk_layout(element, source_is_cdr=not self._to_cdr, skip=skip, residues=runs.cdr_residues)
        if bulk is not None:
            runs.copy_array(variable, *bulk, writes=not skip, large=_LARGE)
            return
        if not skip and isinstance(element, Text) and not element.is_wide and not (element.bound and self._to_cdr):
            self._strings(variable)
            return
        smallest = minimum_size(element, in_ros1=self._to_cdr)
        limit = f"{variable} * {smallest} > end - p" if smallest else f"{variable} > {MAX_EMPTY_ELEMENTS}"
        self._emit(f"if {limit}: raise {self._ref(MessageError, 'error')}('it has too many elements')")
        added = 0 if skip else minimum_size(element, in_ros1=not self._to_cdr)
        if added > _GROWTH * smallest:
            self._counts_added = True
            self._emit(f"room -= {variable} * {added}")
            self._check("room < 0", node.label, "has too many elements that are much larger on the other side")
        with runs.loop(f"for {runs.unique_name('each')} in range({variable}):") as depth:
            if depth > MAX_LOOP_DEPTH:
                raise DefinitionError(f"more than {MAX_LOOP_DEPTH} arrays in arrays", node.label)
            self._node(element, skip=skip)

    def _strings(self, count: str) -> None:
        runs = self._runs
        convert = texts.strings_to_cdr if self._to_cdr else texts.strings_from_cdr
        part = runs.unique_name("strings")
        if self._to_cdr:
            runs.emit_target_position()
            self._emit(f"{part}, p, q = {self._ref(convert, 'convert')}(data, p, {count}, q)")
        else:
            self._emit(f"{part}, p = {self._ref(convert, 'convert')}(data, p, {count})")
        runs.source = ANY
        runs.add_part(part, None)
