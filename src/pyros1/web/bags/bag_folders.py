"""The folders whose bags pages may see. Paths are resolved first: no symbolic link can lead out of these folders."""

from __future__ import annotations

import os
import stat
from collections.abc import Container, Iterable
from itertools import islice
from pathlib import Path
from typing import Any

from pyros1.ground.terminal_text import untrusted
from pyros1.web.server.wire import RequestError

BAG_SUFFIXES = (".bag", ".bag.active")
_MAX_SCANNED_ENTRIES = 20_000
"""Maximum number of entries inspected per folder."""
_MAX_LISTED_ENTRIES = 2_000


class BagFolders:
    """The folders and files that pages may see.

    Args:
        roots: paths of folders and of single files; paths that do not exist are ignored.
        also_allowed: further files that pages may see; this collection may grow later.
    """

    def __init__(self, roots: Iterable[str], also_allowed: Container[Path] = ()) -> None:
        self._also_allowed = also_allowed
        paths = [Path(os.path.realpath(root)) for root in roots]
        self.folders = list(dict.fromkeys(path for path in paths if path.is_dir()))
        self._files = {path for path in paths if path.is_file()}

    def find_file(self, raw_path: str) -> Path:
        """Return the resolved path of a bag that pages may see.

        Raises:
            RequestError: the file does not exist, or pages are not allowed to see it.
        """
        path = self._resolve(raw_path)
        if path not in self._files and not self._is_inside(path) and path not in self._also_allowed:
            name = _for_display(raw_path)
            raise RequestError(
                f"{name} is outside the folders that this server shows (--bags); `pyros1 web bag` opens it anyway"
            )
        try:
            mode = path.stat().st_mode
        except OSError as error:
            raise RequestError(f"{_for_display(raw_path)}: {error.strerror}") from None
        if not stat.S_ISREG(mode):
            raise RequestError(f"{_for_display(raw_path)} is not a file")
        return path

    def find_folder(self, raw_path: str) -> Path:
        """Return the resolved path of a folder that pages may see.

        Raises:
            RequestError: the folder does not exist, or pages are not allowed to see it.
        """
        path = self._resolve(raw_path)
        if not self._is_inside(path):
            raise RequestError(f"{_for_display(raw_path)} is outside the folders that this server shows (--bags)")
        if not path.is_dir():
            raise RequestError(f"{_for_display(raw_path)} is not a folder")
        return path

    def listing(self, raw_path: str) -> dict[str, Any]:
        """Return the contents of a folder, for a page.

        Args:
            raw_path: the folder's path. If the path is empty, the result is the contents of the only visible folder or,
                if several folders are visible, a list of these folders.

        Returns:
            ``{"folder", "up", "folders": [{"name", "path"}], "files": [{"name", "path", "size", "time"}], "more",
            "writable"}``. ``up`` is the path of the parent folder, or null for the topmost folder; ``more`` says
            whether entries are omitted because there are too many. Names that are not UTF-8 are always omitted.

        Raises:
            RequestError: see `find_folder`.
        """
        if not raw_path:
            if len(self.folders) != 1:
                roots = [{"name": str(path), "path": str(path)} for path in self.folders]
                return {"folder": "", "up": None, "folders": roots, "files": [], "more": False, "writable": False}
            raw_path = str(self.folders[0])
        folder = self.find_folder(raw_path)
        folders: list[dict[str, Any]] = []
        files: list[dict[str, Any]] = []
        try:
            with os.scandir(folder) as entries:
                scanned = list(islice(entries, _MAX_SCANNED_ENTRIES + 1))
        except OSError as error:
            raise RequestError(f"{_for_display(raw_path)}: {error.strerror}") from None
        for entry in sorted(scanned[:_MAX_SCANNED_ENTRIES], key=lambda entry: entry.name.lower()):
            self._add_entry(entry, folders, files)
        has_more = (
            len(scanned) > _MAX_SCANNED_ENTRIES
            or len(folders) > _MAX_LISTED_ENTRIES
            or len(files) > _MAX_LISTED_ENTRIES
        )
        parent_path = str(folder.parent) if self._is_inside(folder.parent) else "" if len(self.folders) > 1 else None
        return {
            "folder": str(folder),
            "up": parent_path,
            "folders": folders[:_MAX_LISTED_ENTRIES],
            "files": files[:_MAX_LISTED_ENTRIES],
            "more": has_more,
            "writable": os.access(folder, os.W_OK | os.X_OK),
        }

    def _add_entry(self, entry: os.DirEntry[str], folders: list[dict[str, Any]], files: list[dict[str, Any]]) -> None:
        if entry.name.startswith(".") or not entry.name.isprintable():
            return
        try:
            if entry.is_symlink() and not self._is_inside(Path(os.path.realpath(entry.path))):
                return
            if entry.is_dir():
                folders.append({"name": entry.name, "path": entry.path})
            elif entry.name.endswith(BAG_SUFFIXES) and entry.is_file():
                file_status = entry.stat()
                files.append(
                    {"name": entry.name, "path": entry.path, "size": file_status.st_size, "time": file_status.st_mtime}
                )
        except OSError:
            return  # the entry was deleted, or cannot be accessed

    def _is_inside(self, path: Path) -> bool:
        return any(path == folder or folder in path.parents for folder in self.folders)

    @staticmethod
    def _resolve(raw_path: str) -> Path:
        try:
            return Path(os.path.realpath(raw_path))
        except (ValueError, OSError):
            raise RequestError(f"{_for_display(raw_path)} is not a path") from None


def _for_display(raw_path: str) -> str:
    return untrusted(raw_path[:300])
