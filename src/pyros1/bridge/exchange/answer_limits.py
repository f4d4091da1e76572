"""Limits for answers to other sites: small questions with large answers must not come in floods. No I/O."""

from __future__ import annotations

from pyros1.bridge.exchange.allowance import Allowance
from pyros1.bridge.names import SharedName

_PERIOD = 0.1
"""Minimum seconds between answers to a site's questions about the same topic, or for definitions."""
_AGAIN_RATE = 8e6
_AGAIN_BURST = 32e6
"""Bytes of messages per second, and at once, that a site may ask for again."""
_MAX_ENTRIES = 10_000


class AnswerLimits:
    """Notes what was answered. Who gets no answer asks again."""

    def __init__(self) -> None:
        self._answered_at: dict[tuple[str, SharedName | None], float] = {}
        self._again: dict[str, Allowance] = {}  # bytes, for each site

    def may_answer(self, peer: str, topic: SharedName | None, now: float) -> bool:
        """Return whether to answer a site's question about a topic, or for definitions (None); then it is noted."""
        if now - self._answered_at.get((peer, topic), float("-inf")) < _PERIOD:
            return False
        if len(self._answered_at) >= _MAX_ENTRIES:
            self._answered_at.clear()
        self._answered_at[peer, topic] = now
        return True

    def may_send_again(self, peer: str, topic: SharedName, now: float) -> bool:
        """Return whether to send messages again to a site that asks for them; then it is noted."""
        if not self.may_answer(peer, topic, now):
            return False
        if len(self._again) >= _MAX_ENTRIES:
            self._again.clear()
        return self._again.setdefault(peer, Allowance(_AGAIN_RATE, _AGAIN_BURST)).take(now)

    def note_sent_again(self, peer: str, size: int) -> None:
        """Note that so many bytes are sent to a site again."""
        self._again[peer].charge(size)
