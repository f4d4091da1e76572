"""Finds message classes. For types that are not installed, it uses the definitions that publishers send."""

from __future__ import annotations

import queue
import threading
from collections.abc import Callable
from time import monotonic
from typing import TYPE_CHECKING

from pyros1.ground import msgs_imports
from pyros1.ground.errors import UnknownTypeError
from pyros1.msgs import Message, load_message

if TYPE_CHECKING:
    from pyros1.web.hub import Arrival

_MESSAGE_TIMEOUT = 2.0
_PACKAGES_MAX_AGE = 5.0
"""Seconds for which the list of packages is cached."""
_MAX_LEARNED_CLASSES = 1_000


class MessageTypes:
    """Finds message classes, and keeps those learned from publishers.

    Args:
        listen: see `pyros1.web.robot.Robot.listen`.
        timeout: maximum number of seconds to wait for a message.
    """

    def __init__(
        self,
        listen: Callable[[str, Callable[[Arrival], object]], Callable[[], None]],
        timeout: float = _MESSAGE_TIMEOUT,
    ) -> None:
        self._listen = listen
        self._timeout = timeout
        self._learned_classes: dict[str, type[Message]] = {}
        self._lock = threading.Lock()
        self._packages: list[str] = []
        self._packages_listed_at = float("-inf")

    def packages(self) -> list[str]:
        """Return the names of the installed packages that define messages; the list is cached for a few seconds."""
        with self._lock:  # listing takes a while, and pages request this at each keystroke
            if monotonic() - self._packages_listed_at >= _PACKAGES_MAX_AGE:
                self._packages = msgs_imports.finder().library.packages()
                self._packages_listed_at = monotonic()
            return self._packages

    def find(self, name: str) -> type[Message]:
        """Return the class of a message type that is installed or was learned by `find_on`.

        Raises:
            UnknownTypeError: the type is neither installed nor learned.
            DefinitionError: the type's definition is invalid.
        """
        learned = self._learned_classes.get(name)
        return load_message(name) if learned is None else learned

    def find_on(self, topic: str, name: str) -> type[Message]:
        """Return the class of a message type; if it is not installed, learn it from a message on a topic.

        The class is learned anew each time, since another publisher may have another definition. If no message arrives
        soon, the last learned class is returned.

        Raises:
            UnknownTypeError: the type is not installed, and no message has arrived, now or before.
            DefinitionError: the type's definition is invalid.
            MessageError: the publisher's definition cannot be used.
            RequestError: there is no master yet, or pages are not allowed to see the topic.
        """
        try:
            return load_message(name)
        except UnknownTypeError:
            received: queue.SimpleQueue[Arrival] = queue.SimpleQueue()
            unsubscribe = self._listen(topic, received.put)
            try:
                cls = type(received.get(timeout=self._timeout).message)
            except queue.Empty:
                if name in self._learned_classes:
                    return self._learned_classes[name]
                raise UnknownTypeError(
                    f"{name} is not installed here, and no message with its definition has been received on {topic}"
                ) from None
            finally:
                unsubscribe()
        if cls._type == name:
            self._learned_classes.pop(name, None)
            while len(self._learned_classes) >= _MAX_LEARNED_CLASSES:
                del self._learned_classes[next(iter(self._learned_classes))]
            self._learned_classes[name] = cls
        return cls
