"""The thread of a bridge that handles tokens and messages from ROS 2."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable

from pyros1.ground.errors import Error
from pyros1.ros2.bridge.arrivals import Arrivals
from pyros1.ros2.zenoh.names import DataKey

POLL_PERIOD = 1.0
"""Seconds between checks of which messages to keep."""
_JOIN_TIME = 3.0


class Worker:
    """A thread and its queue.

    Args:
        on_token: called with the key of a ROS 2 entity, and whether it exists or is gone.
        on_message: called with a message: its key, the encoded message, its attachment, and its publisher's session.
        poll: called periodically, with whether a publisher came or went since the last call.
        on_error: called with each `Error` that one of these raises.
        on_mistake: called with any other exception that one of these raises.
    """

    def __init__(
        self,
        on_token: Callable[[str, bool], object],
        on_message: Callable[[DataKey, bytes, bytes, str], object],
        poll: Callable[[bool], object],
        on_error: Callable[[Error], object],
        on_mistake: Callable[[Exception], object],
    ) -> None:
        self._on_token = on_token
        self._on_message = on_message
        self._poll = poll
        self._on_error = on_error
        self._on_mistake = on_mistake
        self._arrivals = Arrivals()
        self._arrived = threading.Condition()
        self._is_closing = False
        self._next_poll = 0.0
        self._has_changed = False
        self._thread = threading.Thread(target=self._run, name="bridge: messages", daemon=True)

    @property
    def dropped(self) -> int:
        """Number of messages dropped because they arrived too fast."""
        return self._arrivals.dropped

    def start(self) -> None:
        """Start handling the queue."""
        self._thread.start()

    def put_token(self, key: str, is_there: bool) -> None:
        """Queue the appearance or removal of a ROS 2 entity. Called on any thread."""
        with self._arrived:
            self._arrivals.put_token(key, is_there)
            self._arrived.notify()

    def put_message(self, key: DataKey, body: bytes, attachment: bytes, session: str = "") -> None:
        """Queue a message. Called on any thread."""
        with self._arrived:
            self._arrivals.put_message(key, body, attachment, session)
            self._arrived.notify()

    def _run(self) -> None:
        while not self._is_closing:
            with self._arrived:
                self._arrived.wait_for(lambda: self._is_closing or not self._arrivals.is_empty, POLL_PERIOD)
                token, message = self._arrivals.pop()
            try:
                if time.monotonic() >= self._next_poll:
                    self._next_poll = time.monotonic() + POLL_PERIOD
                    has_changed, self._has_changed = self._has_changed, False
                    self._poll(has_changed)
                if token is not None:
                    self._has_changed = True
                    self._on_token(*token)
                elif message is not None:
                    self._on_message(*message)
            except Error as error:
                self._on_error(error)
            except Exception as error:  # noqa: BLE001 - a bug must not end the bridge silently
                if not self._is_closing:
                    self._on_mistake(error)

    def close(self) -> None:
        """End the thread."""
        self._is_closing = True
        with self._arrived:
            self._arrived.notify_all()
        self._thread.join(_JOIN_TIME)
