"""Beacons, by which bridges discover each other's topics and services. No I/O; times are monotonic, in seconds.

A bridge sends a beacon every second for each topic or service of its nodes. Bridges that would send the same beacon
(with the same key) take turns at random, so that not each of a hundred robots sends it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable

from pyros1.bridge.plugin_ros1.keys import Resource, beacon_key, is_source, parse_beacon_key

PERIOD = 1.0
LOSS_TIME = 3.5
"""Seconds without beacons after which a topic or service is gone: three beacons are missing, and late ones would have
arrived. The plugin itself checks every three seconds which ones it has not heard since the last check.
"""
MAX_RESOURCES = 2_000
"""Maximum number of other bridges' topics and services that are used, and of unused ones that are listed."""


class _OwnBeacon:
    """The state of the beacon that this bridge sends for one topic or service."""

    def __init__(self, now: float) -> None:
        self.heard = False  # from another bridge, since the last check
        self.sends_at: float | None = now
        self.looks_at = now + PERIOD
        self.starts_at: float | None = None


class OwnBeacons:
    """The beacons that this bridge sends.

    Args:
        random: returns a random number from 0 to 1.
    """

    def __init__(self, random: Callable[[], float]) -> None:
        self._random = random
        self._beacons: dict[str, _OwnBeacon] = {}

    def set_announced(self, resources: Iterable[Resource], now: float) -> None:
        """Announce exactly these topics and services from now on."""
        keys = {beacon_key(resource) for resource in resources}
        for key in self._beacons.keys() - keys:
            del self._beacons[key]
        for key in sorted(keys - self._beacons.keys()):
            self._beacons[key] = _OwnBeacon(now)

    def on_beacon(self, key: str) -> None:
        """Handle another bridge's beacon."""
        if (beacon := self._beacons.get(key)) is not None:
            beacon.heard = True

    def tick(self, now: float) -> list[str]:
        """Return the keys of the beacons to send now."""
        due = []
        for key, beacon in self._beacons.items():
            if now >= beacon.looks_at:
                self._update_sending(beacon, now)
            if beacon.starts_at is not None and now >= beacon.starts_at:
                beacon.starts_at = None
                if not beacon.heard:
                    beacon.sends_at = now
            if beacon.sends_at is not None and now >= beacon.sends_at:
                late = now - beacon.sends_at >= PERIOD
                beacon.sends_at = (now if late else beacon.sends_at) + PERIOD
                due.append(key)
        return due

    def _update_sending(self, beacon: _OwnBeacon, now: float) -> None:
        """Stop sending, at random, while another bridge sends this beacon; start again if none does for a while."""
        beacon.looks_at = now + PERIOD
        if beacon.heard and beacon.sends_at is not None and self._random() < 0.5:
            beacon.sends_at = None
        elif not beacon.heard and beacon.sends_at is None and beacon.starts_at is None:
            # At a random time, since other bridges have noticed the silence at the same moment.
            beacon.starts_at = now + self._random() * PERIOD
        beacon.heard = False


class HeardBeacons:
    """The topics and services that other bridges announce.

    Args:
        is_used: returns whether this bridge uses a topic or service; unused ones cannot displace used ones.

    Attributes:
        ignored: reason -> how many beacons were ignored for it.
    """

    def __init__(self, is_used: Callable[[Resource], bool]) -> None:
        self.ignored: dict[str, int] = {}
        self._is_used = is_used
        self._used: dict[Resource, float] = {}  # resource -> when its last beacon came
        self._others: dict[Resource, float] = {}
        self._known: dict[str, Resource] = {}  # by key, so that repeated beacons cost little

    def on_beacon(self, key: str, now: float) -> bool:
        """Handle a beacon; return whether it newly announces something that this bridge uses."""
        resource = self._known.get(key)
        if resource is not None:
            (self._used if resource in self._used else self._others)[resource] = now
            return False
        if not is_source(key):
            return False  # receivers need no beacons: zenoh itself reports them
        resource = parse_beacon_key(key)
        if resource is None:
            self._ignore("beacons that cannot be understood")
            return False
        is_used = self._is_used(resource)
        table = self._used if is_used else self._others
        if len(table) >= MAX_RESOURCES:
            self._ignore("beacons of too many topics and services")
            return False
        self._known[key] = resource
        table[resource] = now
        return is_used

    def _ignore(self, reason: str) -> None:
        self.ignored[reason] = self.ignored.get(reason, 0) + 1

    def expire(self, now: float) -> bool:
        """Forget what has not been announced for `LOSS_TIME`; return whether any of it was used."""
        was_used = False
        for table in (self._used, self._others):
            for resource in [each for each, heard_at in table.items() if now - heard_at > LOSS_TIME]:
                del table[resource]
                del self._known[beacon_key(resource)]
                was_used |= table is self._used
        return was_used

    @property
    def used(self) -> list[Resource]:
        """The announced topics and services that this bridge uses, in the order in which they were first heard."""
        return [*self._used]

    @property
    def unused(self) -> list[Resource]:
        """The announced topics and services that this bridge does not use."""
        return [*self._others]
