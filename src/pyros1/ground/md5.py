"""md5 sums without OpenSSL."""


def md5_hex(data: bytes) -> str:
    """Return the md5 sum of data in hexadecimal. It identifies the data, but is no protection against tampering."""
    try:  # hashlib loads OpenSSL: 4 MB of memory, and 5 ms at the start of a node
        from _md5 import md5  # type: ignore[import-not-found]  # noqa: PLC0415
    except ImportError:
        from hashlib import md5  # noqa: PLC0415

    return str(md5(data, usedforsecurity=False).hexdigest())
