"""Small texts that stand for much, or are nested so deeply that a reader that calls itself would crash."""

from __future__ import annotations

DEEP = 5_000


def nested(begin: bytes, end: bytes, inside: bytes = b"", before: bytes = b"", after: bytes = b"") -> bytes:
    """Return a text that is nested deeply."""
    return before + begin * DEEP + inside + end * DEEP + after


def entities(root: bytes, inside: bytes = b"%s") -> list[bytes]:
    """Return XML documents with a root element whose entities stand for gigabytes, name a file, or lead to a server.

    Args:
        root: the tag of the root element.
        inside: where the entity is used in it.
    """
    laughs = b"<!ENTITY a0 'haha'>" + b"".join(
        b"<!ENTITY a%d '%s'>" % (number, b"&a%d;" % (number - 1) * 10) for number in range(1, 10)
    )
    long = b"<!ENTITY a9 '%s'>" % (b"a" * 50_000)
    kinds = [laughs, long, b"<!ENTITY a9 SYSTEM 'file:///etc/passwd'>", b"<!ENTITY a9 SYSTEM 'http://127.0.0.1:9/'>"]
    kinds += [b"<!ENTITY %% p SYSTEM 'file:///etc/passwd'> %p;<!ENTITY a9 'x'>"]
    uses = [inside % (b"&a9;" * (1000 if kind is long else 1)) for kind in kinds]
    return [
        b"<!DOCTYPE %s [%s]><%s>%s</%s>" % (root, kind, root, use, root) for kind, use in zip(kinds, uses, strict=True)
    ]


def yaml() -> list[bytes]:
    """Return YAML texts whose aliases stand for billions of values, or contain themselves."""
    lists = b"a0: &a0 [x]\n" + b"".join(b"a%d: &a%d [%s]\n" % (i, i, b"*a%d, " % (i - 1) * 10) for i in range(1, 12))
    maps = b"a0: &a0 {k0: 1}\n" + b"".join(
        b"a%d: &a%d {<<: [%s], k%d: 1}\n" % (i, i, b"*a%d, " % (i - 1) * 10, i) for i in range(1, 12)
    )
    return [
        lists,
        maps,
        b"&a [*a]",
        b"&a {k: *a}",
        b"[" * 400,
        b"[\n" * DEEP,
        b"{a: " * 200,
        b"- " * DEEP,
        b"\n".join(b" " * i + b"a:" for i in range(300)),
        b"x: " + b"9" * 1000,
        b"1:" * 1000 + b"1",
        b"0b" + b"1" * 5000,
        b"rad(" + b"9**" * 1000 + b"9)",
    ]


def python() -> list[bytes]:
    """Return expressions that are nested deeply, long, or would take for ever."""
    return [
        nested(b"(", b")", b"1"),
        nested(b"[", b"]"),
        b"-" * DEEP + b"1",
        b"not " * DEEP + b"1",
        b"1+" * DEEP + b"1",
        b"i" + b".a" * DEEP,
        b"i" + b"[0]" * DEEP,
        b"9**9**9**9",
        b"'a' * 10**9",
        b"'%999999999d' % 1",
        b"1 << 10**9",
        b"'{:999999999}'.format(1)",
        b"sum(range(10**12))",
        b"str(10**4000)",
    ]
