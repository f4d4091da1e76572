"""Links to the page, and the file in which other commands find the link to a running server."""

from __future__ import annotations

import base64
import contextlib
import json
import os
import time
import urllib.request
from collections.abc import Callable, Iterator, Mapping
from hashlib import sha256
from pathlib import Path
from typing import Any

_TIMEOUT = 2.0
_MAX_BYTES = 10_000
_LOCK_TIMEOUT = 10.0
_LOCK_POLL_PERIOD = 0.05


def panel_link(link: str, panel: str, settings: Mapping[str, Any]) -> str:
    """Return a link that opens the page with a panel.

    Args:
        link: the page's link, with its token.
        panel: the panel's name; empty for the first panel.
        settings: the panel's settings, which its module in ``page/panels`` describes.
    """
    if not settings:
        return f"{link}#{panel}" if panel else link
    return layout_link(link, panel, {"panel": panel, "settings": settings})


def layout_link(link: str, name: str, tree: Mapping[str, Any]) -> str:
    """Return a link that opens the page with a layout of panels.

    Args:
        link: the page's link, with its token.
        name: the layout's name.
        tree: ``{"panel": ..., "settings": {...}}``, or ``{"split": "row" or "column", "sizes": [...], "parts": [...]}``
            of such trees.
    """
    data = json.dumps(tree, separators=(",", ":")).encode()
    return f"{link}#{name}={base64.urlsafe_b64encode(data).decode().rstrip('=')}"


def link_file(home: Path, master_uri: str) -> Path:
    """Return the path of the file, in the ROS home folder, that contains the link to the server for a master."""
    uri = master_uri.rstrip("/")
    return home / "pyros1" / f"web-{sha256(uri.encode()).hexdigest()[:16]}.json"


@contextlib.contextmanager
def link_published(file: Path, link: str) -> Iterator[None]:
    """Publish a server's link in a file while the server runs.

    Only the user who runs the server can read the file, since the link contains the token.
    """
    with contextlib.suppress(OSError):  # if this fails, other commands start their own servers
        file.parent.mkdir(parents=True, exist_ok=True)
        file.unlink(missing_ok=True)
        descriptor = os.open(file, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
        with open(descriptor, "w", encoding="utf-8") as output:
            json.dump({"link": link}, output)
    try:
        yield
    finally:
        with contextlib.suppress(OSError, ValueError):
            if json.loads(file.read_text(encoding="utf-8"))["link"] == link:
                file.unlink()


@contextlib.contextmanager
def startup_lock(file: Path) -> Iterator[Callable[[], None]]:
    """Let only one program at a time look for a server and start its own, so that concurrent programs share one server.

    Args:
        file: the path from `link_file`.

    Yields:
        A function that releases the lock early; otherwise, leaving the context releases it. After a long wait, the
        program continues without the lock.
    """
    with contextlib.ExitStack() as stack:
        with contextlib.suppress(OSError, ImportError):  # the folder is not writable; on Windows, there is no fcntl
            import fcntl  # noqa: PLC0415 - Unix only

            file.parent.mkdir(parents=True, exist_ok=True)
            descriptor = os.open(file.parent, os.O_RDONLY)
            stack.callback(os.close, descriptor)
            deadline = time.monotonic() + _LOCK_TIMEOUT
            while time.monotonic() < deadline:
                try:
                    fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
                    break
                except BlockingIOError:
                    time.sleep(_LOCK_POLL_PERIOD)
        yield stack.close


def running_link(file: Path) -> str | None:
    """Return the URL stored in a server's link file, or None if the server does not respond."""
    try:
        link = json.loads(file.read_text(encoding="utf-8")[:_MAX_BYTES])["link"]
        base = link.partition("?")[0]
        if not base.startswith("http://"):
            return None
        with urllib.request.urlopen(f"{base}panels.json", timeout=_TIMEOUT) as response:
            json.loads(response.read(_MAX_BYTES))
    except (OSError, ValueError, KeyError, TypeError):
        return None
    return str(link)
