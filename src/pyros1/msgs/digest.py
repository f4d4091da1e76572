"""md5 sums and full texts, from the raw definition texts exactly as stock computes them (G11, G12, G14).

The md5 decides whether two nodes may talk; the full text travels in connection headers and bags, and other programs
parse it. Pure.
"""

from __future__ import annotations

from collections.abc import Callable

from pyros1.errors import DefinitionError
from pyros1.msgs.spec import MessageSpec, ServiceSpec

SEPARATOR = "=" * 80
_MAX_DEPTH = 64


class Digests:
    """Computes sums and texts of messages; remembers the sums.

    Args:
        resolve: returns the spec of a full type name; its errors pass through.
    """

    def __init__(self, resolve: Callable[[str], MessageSpec]) -> None:
        self._resolve = resolve
        self._sums: dict[str, str] = {}

    def md5(self, spec: MessageSpec | ServiceSpec) -> str:
        """Return the md5 sum of a message or service type.

        Raises:
            DefinitionError: a type contains itself.
        """
        if isinstance(spec, ServiceSpec):
            text = self._md5_text(spec.request, ()) + self._md5_text(spec.response, ())
        else:
            text = self._md5_text(spec, ())
        return _md5(text)

    def dependencies(self, spec: MessageSpec | ServiceSpec) -> list[str]:
        """Return the full names of all message types used, depth first, each once.

        Raises:
            DefinitionError: a type contains itself.
        """
        found: dict[str, None] = {}
        for part in (spec.request, spec.response) if isinstance(spec, ServiceSpec) else (spec,):
            self._collect(part, found, (part.name,))
        return list(found)

    def full_text(self, spec: MessageSpec | ServiceSpec) -> str:
        """Return the definition followed by those of all types used, as connection headers carry it."""
        parts = [spec.text + "\n"]
        for name in self.dependencies(spec):
            parts.append(f"{SEPARATOR}\nMSG: {name}\n{self._resolve(name).text}\n")
        return "".join(parts)[:-1]

    def _md5_text(self, spec: MessageSpec, outer: tuple[str, ...]) -> str:
        if spec.name in outer:
            raise DefinitionError(f"the type contains itself: {' -> '.join([*outer, spec.name])}", spec.name)
        if len(outer) >= _MAX_DEPTH:
            raise DefinitionError(f"nested more than {_MAX_DEPTH} deep", spec.name)
        lines = [f"{constant.type} {constant.name}={constant.text}" for constant in spec.constants]
        for field in spec.fields:
            if field.is_builtin:
                lines.append(f"{field.type} {field.name}")
                continue
            total = self._sums.get(field.base)
            if total is None:
                inner = self._resolve(field.base)
                total = self._sums[field.base] = _md5(self._md5_text(inner, (*outer, spec.name)))
            lines.append(f"{total} {field.name}")
        return "\n".join(lines).strip()

    def _collect(self, spec: MessageSpec, found: dict[str, None], outer: tuple[str, ...]) -> None:
        for field in spec.fields:
            if field.is_builtin:
                continue
            if field.base in outer:
                raise DefinitionError(f"the type contains itself: {' -> '.join([*outer, field.base])}", spec.name)
            if field.base not in found:
                if len(outer) >= _MAX_DEPTH:
                    raise DefinitionError(f"nested more than {_MAX_DEPTH} deep", spec.name)
                found[field.base] = None
                self._collect(self._resolve(field.base), found, (*outer, field.base))


def split_full_text(name: str, full_text: str) -> dict[str, str]:
    """Cut a full text into the definitions that it is made of.

    Args:
        name: full type name of the first definition.
        full_text: text as :meth:`Digests.full_text` makes it.

    Returns:
        Full type name to definition text; of a type given twice the first counts.

    Raises:
        DefinitionError: a separator is not followed by a ``MSG:`` line.
    """
    texts: dict[str, str] = {}
    current, start, number = name, 0, 0
    lines = full_text.split("\n")
    while number <= len(lines):
        if number == len(lines) or _is_separator(lines[number]):
            texts.setdefault(current, "\n".join(lines[start:number]))
            if number == len(lines):
                break
            title = lines[number + 1].strip() if number + 1 < len(lines) else ""
            if not title.startswith("MSG:"):
                raise DefinitionError("no 'MSG: type' line after a separator", name, number + 2)
            current = title[len("MSG:") :].strip()
            start = number = number + 2
        else:
            number += 1
    return texts


def _is_separator(line: str) -> bool:
    line = line.rstrip()
    return len(line) >= 80 and not line.strip("=")


def _md5(text: str) -> str:
    data = text.encode("utf-8", "surrogateescape")
    try:  # hashlib loads OpenSSL, which every node would wait for when it starts
        from _md5 import md5  # type: ignore[import-not-found]  # noqa: PLC0415
    except ImportError:
        from hashlib import md5  # noqa: PLC0415

    return str(md5(data, usedforsecurity=False).hexdigest())
