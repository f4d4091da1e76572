"""Emits the code that moves runs of fixed-size values from the source to the target.

Each run is unpacked with one ``struct`` and packed with another. Values that are adjacent on both sides are copied as
one piece. In CDR, a number's position is a multiple of its size, which is at most 8, so padding depends on the position
modulo 8, here called the residue. If it varies between messages, for example after a string, there is a struct for each
residue. Positions in the generated code include CDR's header of 4 bytes; residues do not.

The generated code has these variables: ``data``, the source; ``end``, its size; ``p``, the position in it; ``q``, the
position in the target, of which only the residue matters; and, if needed, ``room``, how many bytes may still be added.
All other names are from `Scope.unique_name`.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any, NamedTuple

from pyros1.ground.errors import DefinitionError
from pyros1.msgs.generator import Scope
from pyros1.ros2_types.transcoding.layout import aligned

HEADER_SIZE = 4
"""Size in bytes of CDR's header."""
ANY = frozenset(range(8))
"""All residues."""
_START = frozenset([0])


class Atom(NamedTuple):
    """Adjacent numbers of one size.

    Attributes:
        width: size of each in bytes.
        amount: how many.
        reads: whether the source has them.
        writes: whether the target has them.
        name: the variable to read the value into; empty to copy its bytes.
        expression: what to write; empty to copy the bytes, or to write zeros if the source lacks them.
        code: struct code of the variable and the expression; by default, a uint32.
    """

    width: int
    amount: int
    reads: bool
    writes: bool
    name: str = ""
    expression: str = ""
    code: str = "I"

    @property
    def is_copied(self) -> bool:
        """Whether its bytes are copied."""
        return self.reads and self.writes and not self.name


class _Layout(NamedTuple):
    """The layout of a run on one side, for one initial residue."""

    pads: list[int]
    size: int
    residue: int


class Runs:
    """Collects the values of a run, and emits the code for it.

    Args:
        source_is_cdr: True from CDR to ROS 1, False from ROS 1 to CDR.

    Attributes:
        lines: the emitted lines.
        parts: the expressions, in a tuple, for the parts of the result.
        source: possible residues in the source.
        target: possible residues in the target.
    """

    def __init__(self, *, source_is_cdr: bool) -> None:
        self.scope = Scope()
        self.unique_name = self.scope.unique_name
        self.lines: list[str] = []
        self.parts: list[str] = []
        self.source = self.target = _START
        self._source_is_cdr = source_is_cdr
        self._atoms: list[Atom] = []
        self._indent = ""
        self._depth = 0
        self._add = ""

    @property
    def cdr_residues(self) -> frozenset[int]:
        """Possible residues on the CDR side."""
        return self.source if self._source_is_cdr else self.target

    def emit(self, line: str) -> None:
        """Emit a line."""
        self.lines.append(self._indent + line)

    def ref(self, value: Any, hint: str) -> str:
        """Return a name by which the generated code can use an object."""
        return self.scope.ref(value, hint, object())

    def assign(self, hint: str, expression: str) -> str:
        """Emit an assignment to a new variable; return its name."""
        variable = self.unique_name(hint)
        self.emit(f"{variable} = {expression}")
        return variable

    def add(self, atom: Atom) -> None:
        """Add numbers to the run."""
        if atom.amount:
            self._atoms.append(atom)

    def add_part(self, expression: str, size: str | None) -> None:
        """Flush the run, and then emit a part of the result.

        Args:
            expression: the part.
            size: expression for its size modulo 8; None if ``q`` has already been moved.
        """
        if not self._source_is_cdr:
            if size is not None:
                self.emit(f"q = {self._target_position()} + {size}")
            self.target = ANY
        self._emit_part(expression)

    def _emit_part(self, expression: str) -> None:
        if self._depth:
            self.emit(f"{self._add}({expression})")
        elif expression.isidentifier():
            self.parts.append(expression)
        else:
            self.parts.append(self.assign("part", expression))

    def _target_position(self) -> str:
        return str(*self.target) if len(self.target) == 1 else "q"

    def emit_target_position(self) -> None:
        """Emit the assignment of ``q`` if it is not up to date."""
        if not self._source_is_cdr and len(self.target) == 1:
            self.emit(f"q = {self._target_position()}")

    def flush(self, between: Sequence[str] = ()) -> None:
        """Emit the code for the collected run.

        Args:
            between: lines to run after reading it, before writing it.
        """
        atoms, self._atoms = self._atoms, []
        if not atoms:
            return
        read = [atom for atom in atoms if atom.reads]
        written = [atom for atom in atoms if atom.writes]
        sources = {residue: _layout(read, residue, is_cdr=self._source_is_cdr) for residue in self.source}
        targets = {residue: _layout(written, residue, is_cdr=not self._source_is_cdr) for residue in self.target}
        pieces = _pieces(
            atoms,
            [_by_atom(atoms, layout.pads, "reads") for layout in sources.values()],
            [_by_atom(atoms, layout.pads, "writes") for layout in targets.values()],
        )
        names = ["" if not piece[0].is_copied else self.unique_name("piece") for piece in pieces]
        self._read(pieces, names, atoms, sources)
        for line in between:
            self.emit(line)
        self._write(pieces, names, atoms, targets)

    def _read(self, pieces: list[list[Atom]], names: list[str], atoms: list[Atom], layouts: dict[int, _Layout]) -> None:
        variables = [name or piece[0].name for piece, name in zip(pieces, names, strict=True)]
        variables = [variable for variable in variables if variable]
        self.source = frozenset(layout.residue for layout in layouts.values())
        table = {}
        for residue, layout in layouts.items():
            text = _format(pieces, _by_atom(atoms, layout.pads, "reads"), reads=True)
            table[residue] = (_struct(text).unpack_from, layout.size)
        if len(table) == 1:
            ((unpack, size),) = table.values()
            size_text, unpack_name = str(size), self.ref(unpack, "unpack") if variables else ""
        else:
            rows = [table.get((index - HEADER_SIZE) % 8) for index in range(8)]
            if not variables:
                sizes = tuple(row[1] if row else 0 for row in rows)
                size_text, unpack_name = f"{self.ref(sizes, 'sizes')}[p & 7]", ""
            else:
                size_text, unpack_name = self.unique_name("size"), self.unique_name("unpack")
                self.emit(f"{unpack_name}, {size_text} = {self.ref(tuple(rows), 'unpackers')}[p & 7]")
        if variables:
            self.emit(f"{', '.join(variables)}, = {unpack_name}(data, p)")
        if size_text != "0":
            self.emit(f"p += {size_text}")

    def _write(
        self, pieces: list[list[Atom]], names: list[str], atoms: list[Atom], layouts: dict[int, _Layout]
    ) -> None:
        if not any(atom.writes for atom in atoms):
            return
        values = [name or piece[0].expression for piece, name in zip(pieces, names, strict=True)]
        values = [value for value, piece in zip(values, pieces, strict=True) if value and piece[0].writes]
        table = {}
        for residue, layout in layouts.items():
            text = _format(pieces, _by_atom(atoms, layout.pads, "writes"), reads=False)
            packer = _struct(text)
            table[residue] = (packer.pack if values else packer.pack(), layout.residue)
        if len(table) == 1:
            ((pack, _),) = table.values()
            pack_name = self.ref(pack, "pack")
        else:
            pack_name = self.unique_name("pack")
            rows = tuple(table.get(residue) for residue in range(8))
            self.emit(f"{pack_name}, q = {self.ref(rows, 'packers')}[q & 7]")
        self.target = frozenset(layout.residue for layout in layouts.values())
        self._emit_part(f"{pack_name}({', '.join(values)})" if values else pack_name)

    def copy_array(self, count: str, size: int, alignment: int, *, writes: bool, large: int) -> None:
        """Emit the copy of an array whose elements have the same bytes on both sides.

        Args:
            count: the number of elements, an expression.
            size: size of an element in bytes.
            alignment: size of its first number in bytes.
            writes: whether to write it; otherwise it is skipped.
            large: arrays of at least this size are not sliced out of bytes, which would copy them.
        """
        length = count if size == 1 else self.assign("bytes", f"{count} * {size}")
        residues = self.cdr_residues
        needs_padding = any(residue % alignment for residue in residues)
        if self._source_is_cdr and needs_padding:
            self.emit(f"if {count}: p += {HEADER_SIZE} - p & {alignment - 1}")
        if writes:
            stop = self.assign("stop", f"p + {length}")
            if not self._source_is_cdr:
                self.emit_target_position()
                if needs_padding:
                    padding = self.assign("padding", f"-q & {alignment - 1} if {count} else 0")
                    self._emit_part(f"{self.ref(_PADDINGS, 'paddings')}[{padding}]")
                    self.emit(f"q += {padding} + {length}")
                else:
                    self.emit(f"q += {length}")
            view = self.ref(memoryview, "view")
            self._emit_part(f"data[p:{stop}] if {length} < {large} else {view}(data)[p:{stop}]")
            self.emit(f"p = {stop}")
        else:
            self.emit(f"p += {length}")
        ends = set(residues)
        for residue in residues:
            position = aligned(residue, alignment)
            ends.update((position + number * size) % 8 for number in range(8))
        if self._source_is_cdr:
            self.source = frozenset(ends)
        elif writes:
            self.target = frozenset(ends)

    @contextmanager
    def loop(self, header: str) -> Iterator[int]:
        """Emit a loop; its body is the code emitted within the context. Yields the nesting depth of the loop."""
        self.flush()
        self.emit_target_position()
        indent, add, depth = self._indent, self._add, self._depth
        if not depth:
            parts = self.assign("parts", "[]")
            self._add = self.assign("add", f"{parts}.append")
            self.parts.append(f"*{parts}")
        self.emit(header)
        self._indent, self._depth = indent + " ", depth + 1
        self.source = ANY if self._source_is_cdr else _START
        self.target = _START if self._source_is_cdr else ANY
        size = len(self.lines)
        yield self._depth
        self.flush()
        self.emit_target_position()
        if len(self.lines) == size:
            self.emit("pass")
        self.source = ANY if self._source_is_cdr else _START
        self.target = _START if self._source_is_cdr else ANY
        self._indent, self._add, self._depth = indent, add, depth


_PADDINGS = tuple(bytes(size) for size in range(8))


def _layout(atoms: Sequence[Atom], residue: int, *, is_cdr: bool) -> _Layout:
    """Lay out atoms, starting at a residue."""
    position, pads = residue, []
    for atom in atoms:
        pads.append(aligned(position, atom.width) - position if is_cdr else 0)
        position += pads[-1] + atom.width * atom.amount
    return _Layout(pads, position - residue, position % 8 if is_cdr else 0)


def _by_atom(atoms: Sequence[Atom], pads: Sequence[int], side: str) -> list[int]:
    """Return the padding before each atom of a run, given the padding before those that one side has."""
    iterator = iter(pads)
    return [next(iterator) if getattr(atom, side) else 0 for atom in atoms]


def _pieces(atoms: list[Atom], *pads: list[list[int]]) -> list[list[Atom]]:
    """Group the atoms: copied atoms that never have padding between them form one piece."""
    pieces: list[list[Atom]] = []
    for index, atom in enumerate(atoms):
        is_padded = any(layout[index] for side in pads for layout in side)
        if index and atom.is_copied and atoms[index - 1].is_copied and not is_padded:
            pieces[-1].append(atom)
        else:
            pieces.append([atom])
    return pieces


def _format(pieces: list[list[Atom]], pads: list[int], *, reads: bool) -> str:
    """Return the struct format of a run on one side."""
    codes, index = [], 0
    for piece in pieces:
        atom, size = piece[0], sum(part.width * part.amount for part in piece)
        pad, index = pads[index], index + len(piece)
        if not (atom.reads if reads else atom.writes):
            continue
        code = atom.code if (atom.name if reads else atom.expression) else f"{size}s" if atom.is_copied else f"{size}x"
        codes.append(f"{pad}x{code}" if pad else code)
    return "<" + "".join(codes)


def _struct(text: str) -> struct.Struct:
    try:
        return struct.Struct(text)
    except struct.error:
        raise DefinitionError("its fixed arrays are too large") from None
