"""Rate limits for small requests with large answers. No I/O."""

from __future__ import annotations

from pyros1.bridge.exchange.token_bucket import TokenBucket
from pyros1.bridge.names import SharedName

_PERIOD = 0.1
"""Minimum seconds between answers to a site's requests for the same topic, or for definitions."""
_RESEND_RATE = 8e6
_RESEND_BURST = 32e6
"""Maximum bytes of messages resent to a site, per second and in one burst."""
_MAX_ENTRIES = 10_000


class AnswerLimits:
    """Limits answers; a site that gets no answer asks again."""

    def __init__(self) -> None:
        self._answered_at: dict[tuple[str, SharedName | None], float] = {}
        self._resent: dict[str, TokenBucket] = {}  # bytes, for each site

    def may_answer(self, peer: str, topic: SharedName | None, now: float) -> bool:
        """Return whether to answer a site's request about a topic, or for definitions (None); if so, record it."""
        if now - self._answered_at.get((peer, topic), float("-inf")) < _PERIOD:
            return False
        if len(self._answered_at) >= _MAX_ENTRIES:
            self._answered_at.clear()
        self._answered_at[peer, topic] = now
        return True

    def may_resend(self, peer: str, topic: SharedName, now: float) -> bool:
        """Return whether to resend messages to a site that requests them; if so, record it."""
        if not self.may_answer(peer, topic, now):
            return False
        if len(self._resent) >= _MAX_ENTRIES:
            self._resent.clear()
        return self._resent.setdefault(peer, TokenBucket(_RESEND_RATE, _RESEND_BURST)).take(now)

    def note_resent(self, peer: str, size: int) -> None:
        """Record how many bytes are resent to a site."""
        self._resent[peer].charge(size)
