"""A bounded queue of messages from ROS 2. No I/O.

Tokens have their own queue, which goes first, so a flood of messages can only displace messages. The removal of a token
must not be lost, since zenoh does not repeat it. Only the last change of each token is kept.
"""

from __future__ import annotations

from collections import deque

from pyros1.ros2.zenoh.names import MAX_KEY_LENGTH, DataKey

MAX_TOKENS = 50_000
"""Maximum number of tokens known at a time."""
MAX_BYTES = 64 << 20
"""Maximum total size in bytes of the waiting messages; a single larger one is accepted."""
MAX_MESSAGES = 10_000
Token = tuple[str, bool]
"""The key of a ROS 2 entity, and whether it exists or is gone."""
Message = tuple[DataKey, bytes, bytes, str]
"""A message: its key, the encoded message, its attachment, and the id of its publisher's session; empty if unknown."""


class Arrivals:
    """Waiting tokens and messages.

    Attributes:
        dropped: how many were dropped because the queue was full.
    """

    def __init__(self, max_bytes: int = MAX_BYTES, max_messages: int = MAX_MESSAGES) -> None:
        self.dropped = 0
        self._max_bytes = max_bytes
        self._max_messages = max_messages
        self._tokens: dict[str, bool] = {}
        self._existing: set[str] = set()  # the tokens that were popped and have not been withdrawn
        self._new = 0  # how many new tokens wait
        self._messages: deque[Message] = deque()
        self._bytes = 0

    @property
    def is_empty(self) -> bool:
        """Whether nothing waits."""
        return not self._tokens and not self._messages

    def put_token(self, key: str, is_there: bool) -> None:
        """Add a token, unless the queue is full or the key is too long to be valid."""
        if not is_there:
            if key in self._existing:
                self._tokens[key] = False
            elif self._tokens.pop(key, False):
                self._new -= 1
        elif key in self._existing:
            self._tokens.pop(key, None)
        elif key not in self._tokens and len(key) <= MAX_KEY_LENGTH:
            if self._new + len(self._existing) >= MAX_TOKENS:
                self.dropped += 1
                return
            self._tokens[key] = True
            self._new += 1

    def put_message(self, key: DataKey, body: bytes, attachment: bytes, session: str = "") -> None:
        """Add a message. If there are too many, the oldest is dropped."""
        self._messages.append((key, body, attachment, session))
        self._bytes += len(body)
        while len(self._messages) > 1 and (self._bytes > self._max_bytes or len(self._messages) > self._max_messages):
            self._bytes -= len(self._messages.popleft()[1])
            self.dropped += 1

    def pop(self) -> tuple[Token | None, Message | None]:
        """Return the next token or message; (None, None) if nothing waits."""
        if self._tokens:
            key = next(iter(self._tokens))
            is_there = self._tokens.pop(key)
            if is_there:
                self._existing.add(key)
                self._new -= 1
            else:
                self._existing.discard(key)
            return (key, is_there), None
        if not self._messages:
            return None, None
        message = self._messages.popleft()
        self._bytes -= len(message[1])
        return None, message
