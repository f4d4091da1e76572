"""Service responses that come through zenoh-bridge-ros1.

That bridge passes on the text of an error as if it were a response, so only the contents tell the two apart. No I/O
except for looking up installed types.
"""

from __future__ import annotations

from typing import Any

from pyros1.ground.errors import Error, MessageError
from pyros1.ground.terminal_text import one_line
from pyros1.msgs import load_service

_MAX_TEXT = 1000


class Responses:
    """The responses of a service.

    Args:
        type_name, md5sum: the service's type.

    Attributes:
        is_known: whether the type is installed here, so that errors can be told from responses.
    """

    def __init__(self, type_name: str, md5sum: str) -> None:
        self._class: Any = None
        try:
            service_class = load_service(type_name)
        except Error:
            pass
        else:
            if service_class._md5sum == md5sum:
                self._class = service_class._response_class
        self.is_known = self._class is not None

    def error(self, body: bytes) -> str | None:
        """Return the error that a response stands for; None if it looks like a response."""
        if self._class is None:
            return None
        try:
            self._class._decode(body, 0, len(body), True)
        except MessageError:
            text = one_line(body[:_MAX_TEXT].decode("utf-8", "replace"), _MAX_TEXT)
            return text or "the service has sent an empty response"
        return None
