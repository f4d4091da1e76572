"""Computes md5 sums and full texts from the raw definition texts, exactly as stock does (G11, G12, G14).

Two nodes can connect only if the md5 sums of their types are equal. The full text is sent in connection headers and
stored in bags, and other programs parse it. Does no I/O.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

from pyros1.ground.errors import DefinitionError
from pyros1.ground.md5 import md5_hex
from pyros1.msgs.spec import MessageSpec, ServiceSpec

SEPARATOR = "=" * 80
_MAX_DEPTH = 64


class Digests:
    """md5 sums and full texts of messages; the sums are cached.

    Args:
        resolve: returns the spec for a full type name; its errors are passed on.
    """

    def __init__(self, resolve: Callable[[str], MessageSpec]) -> None:
        self._resolve = resolve
        self._sums: dict[str, str] = {}
        self._depths: dict[str, int] = {}

    def md5(self, spec: MessageSpec | ServiceSpec) -> str:
        """Return the md5 sum of a message or service type.

        Raises:
            DefinitionError: a type contains itself, or is nested too deeply.
        """
        parts = _message_specs(spec)
        for part in parts:
            self._compute_sums(part)
        return _md5("".join(map(self._md5_text, parts)))

    def md5_text(self, spec: MessageSpec | ServiceSpec) -> str:
        """Return the text whose md5 sum :meth:`md5` returns; raises the same errors."""
        self.md5(spec)
        return "".join(map(self._md5_text, _message_specs(spec)))

    def dependencies(self, spec: MessageSpec | ServiceSpec) -> list[str]:
        """Return the full names of all message types that a type uses, depth first, each once.

        Raises:
            DefinitionError: as for `md5`.
        """
        names: dict[str, None] = {}
        for part in _message_specs(spec):
            self._compute_sums(part)
            self._collect(part, names)
        return list(names)

    def full_text(self, spec: MessageSpec | ServiceSpec) -> str:
        """Return the definition followed by the definitions of all types used, as in connection headers.

        Raises:
            DefinitionError: as for `md5`.
        """
        parts = [spec.text + "\n"]
        for name in self.dependencies(spec):
            parts.append(f"{SEPARATOR}\nMSG: {name}\n{self._resolve(name).text}\n")
        return "".join(parts)[:-1]

    def _compute_sums(self, root: MessageSpec) -> None:
        """Compute the md5 sums of all types used, without recursion, since peers may send definitions of any depth."""
        path = [(root, _used_types(root))]
        names = {root.name}
        while path:
            spec, used = path[-1]
            name = next((used_name for used_name in used if used_name not in self._sums), None)
            if name is None:
                path.pop()
                names.remove(spec.name)
                depth = 1 + max((self._depths[used_name] for used_name in _used_types(spec)), default=0)
                if depth > _MAX_DEPTH:
                    raise DefinitionError(f"nested more than {_MAX_DEPTH} deep", spec.name)
                if path:  # the request and response of a service are not types of their own
                    self._sums[spec.name], self._depths[spec.name] = _md5(self._md5_text(spec)), depth
            elif name in names:
                cycle = " -> ".join([*(path_spec.name for path_spec, _ in path), name])
                raise DefinitionError(f"the type contains itself: {cycle}", name)
            else:
                spec = self._resolve(name)
                path.append((spec, _used_types(spec)))
                names.add(name)

    def _md5_text(self, spec: MessageSpec) -> str:
        lines = [f"{constant.type} {constant.name}={constant.text}" for constant in spec.constants]
        for field in spec.fields:
            lines.append(f"{field.type if field.is_builtin else self._sums[field.base]} {field.name}")
        return "\n".join(lines).strip()

    def _collect(self, spec: MessageSpec, names: dict[str, None]) -> None:
        for name in _used_types(spec):
            if name not in names:
                names[name] = None
                self._collect(self._resolve(name), names)


def _message_specs(spec: MessageSpec | ServiceSpec) -> tuple[MessageSpec, ...]:
    return (spec.request, spec.response) if isinstance(spec, ServiceSpec) else (spec,)


def _used_types(spec: MessageSpec) -> Iterator[str]:
    """Yield the names of the message types that the fields use."""
    return (field.base for field in spec.fields if not field.is_builtin)


def split_full_text(name: str, full_text: str) -> dict[str, str]:
    """Split a full text into its definitions.

    Args:
        name: full type name of the first definition.
        full_text: text in the format of :meth:`Digests.full_text`.

    Returns:
        Full type name -> definition text; if a type occurs twice, the first text is used.

    Raises:
        DefinitionError: a separator is not followed by a ``MSG:`` line.
    """
    texts: dict[str, str] = {}
    current_name, start, line_index = name, 0, 0
    lines = full_text.split("\n")
    while line_index <= len(lines):
        if line_index == len(lines) or _is_separator(lines[line_index]):
            texts.setdefault(current_name, "\n".join(lines[start:line_index]))
            if line_index == len(lines):
                break
            title = lines[line_index + 1].strip() if line_index + 1 < len(lines) else ""
            if not title.startswith("MSG:"):
                raise DefinitionError("no 'MSG: type' line after a separator", name, line_index + 2)
            current_name = title[len("MSG:") :].strip()
            start = line_index = line_index + 2
        else:
            line_index += 1
    return texts


def _is_separator(line: str) -> bool:
    line = line.rstrip()
    return len(line) >= 80 and not line.strip("=")


def _md5(text: str) -> str:
    return md5_hex(text.encode("utf-8", "surrogateescape"))
