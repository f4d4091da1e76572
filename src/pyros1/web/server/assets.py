"""Serves the page's files. Only files that existed at the start are served, so that no path can lead to other files."""

from __future__ import annotations

import hashlib
from dataclasses import dataclass
from pathlib import Path

PAGE_FOLDER = Path(__file__).parents[1] / "page"
_CONTENT_TYPES = {
    ".html": "text/html; charset=utf-8",
    ".js": "text/javascript; charset=utf-8",
    ".css": "text/css; charset=utf-8",
    ".svg": "image/svg+xml",
    ".json": "application/json",
    ".webp": "image/webp",
    ".LICENSE": "text/plain; charset=utf-8",
}
SECURITY_HEADERS = {
    # With this, browsers run and fetch only the server's own files, whatever a message contains.
    "Content-Security-Policy": "default-src 'self'; img-src 'self' blob: data:; worker-src 'self' blob:; "
    "frame-ancestors 'none'; base-uri 'none'; form-action 'none'",
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
    "Cache-Control": "no-cache",
}
"""Headers that are sent with every response."""


@dataclass(frozen=True)
class Asset:
    """A file that is part of the page; ``tag`` is its ETag."""

    body: bytes
    content_type: str
    tag: str


class Assets:
    """The page's files.

    Args:
        folder: the folder that contains the files.

    Attributes:
        panels: the names of the page's panels.
    """

    def __init__(self, folder: Path = PAGE_FOLDER) -> None:
        self._folder = folder
        self._paths = {"/" + path.relative_to(folder).as_posix(): path for path in folder.rglob("*") if path.is_file()}
        self._paths["/"] = folder / "index.html"
        panels = sorted(path.stem for path in (folder / "panels").glob("*.js"))
        self.panels = [name for name in panels if not name.startswith("_")]

    def get(self, path: str) -> Asset | None:
        """Return the file at a URL's path; None if it does not exist or cannot be read."""
        file = self._paths.get(path)
        content_type = _CONTENT_TYPES.get(file.suffix) if file else None
        if file is None or content_type is None:
            return None
        try:
            body = file.read_bytes()  # read each time, so that developers of panels can edit it and reload the page
        except OSError:
            return None
        return Asset(body, content_type, f'"{hashlib.sha256(body).hexdigest()[:20]}"')
