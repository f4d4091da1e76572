"""The services of a simulated site, and calls of them by nodes of others, see `simulation`.

Each request is a text that no other call has, so each run of a service tells which call it belongs to.
"""

from __future__ import annotations

from itertools import count
from typing import TYPE_CHECKING, NamedTuple

from pyros1.bridge.exchange.actions import CallService, Provide, Return, ServiceAction, StopProviding
from pyros1.bridge.exchange.services.served import LocalService
from pyros1.bridge.protocol.calls import Status

if TYPE_CHECKING:
    from .simulated_site import SimulatedSite

SERVICES = ("/add", "/fail")
PATIENCE = 60.0
"""Seconds in which a call must have ended, by the default of the rules."""
MD5 = "a" * 32


class Result(NamedTuple):
    """How a call has ended."""

    status: Status
    text: str
    time: float


class Call:
    """A call that a node has made."""

    def __init__(self, text: str, name: str, run: int, time: float) -> None:
        self.text = text
        self.name = name
        self.run = run
        self.time = time
        self.results: list[Result] = []


class SimulatedServices:
    """What nodes of a site provide, and the calls that they make.

    Attributes:
        there: the services of this site.
        provided: the services of other sites that the bridge provides here.
        taken: services with names of other sites' that nodes of this site provide.
        calls: the calls that nodes here have made.
        runs: the requests that services of this site have got.
    """

    def __init__(self, site: SimulatedSite) -> None:
        self.there = {*SERVICES}
        self.provided: set[str] = set()
        self.taken: set[str] = set()
        self.calls: dict[int, Call] = {}
        self.runs: list[str] = []
        self._site = site
        self._tokens = count(1)

    def start(self) -> None:
        """Note that the bridge starts, or starts again."""
        self.provided.clear()

    def look(self) -> None:
        """Let the bridge look at its master."""
        site = self._site
        services = [LocalService(name, "a/B", MD5, "a/BRequest", "a/BResponse", "/n") for name in sorted(self.there)]
        site.act(site.site.set_services(services, dict.fromkeys(self.taken, "/n"), site.now))
        assert not self.provided & self.taken, f"{site.name} provides what a node here provides"

    def call(self, name: str) -> None:
        """Let a node call a service that the bridge provides."""
        site, token = self._site, next(self._tokens)
        text = f"{site.name} {name} {token}"
        self.calls[token] = Call(text, name, site.run, site.network.now)
        site.act(site.site.services.calls.call(token, name, text.encode(), site.now))

    def happen(self, word: str, other: str) -> None:
        """Let random nodes call, or let services come and go.

        Args:
            word: what happens: ``call`` or ``service``.
            other: another site.
        """
        random = self._site.random
        if word == "call":
            for name in random.sample(sorted(self.provided), min(2, len(self.provided))):
                self.call(name)
        else:
            self.there ^= {random.choice(SERVICES)}
            self.taken ^= {f"/{other}{random.choice(SERVICES)}"}

    def act(self, action: ServiceAction) -> None:
        """Do what the site's machine asks for."""
        site = self._site
        match action:
            case Provide(local):
                assert local not in self.provided, f"{local} is provided twice"
                self.provided.add(local)
            case StopProviding(local):
                self.provided.remove(local)
            case CallService():
                self._run(action)
            case Return(token, status, body):
                self.calls[token].results.append(Result(status, body.decode(), site.network.now))

    def _run(self, action: CallService) -> None:
        """Carry out a call of another site, which takes a while."""
        site, run = self._site, self._site.run
        assert 0 < action.timeout <= PATIENCE
        if action.local not in self.there:
            site.act(site.site.services.served.on_result(action.call, Status.REFUSED, b"gone", site.now))
            return
        self.runs.append(action.body.decode())
        status = Status.FAILED if action.local == "/fail" else Status.OK

        def end() -> None:
            if run == site.run:
                site.act(site.site.services.served.on_result(action.call, status, b"re " + action.body, site.now))

        site.network.at(site.network.now + site.random.choice([0.0, 0.0, 0.3, 4.0]), end)


def check_services(sites: dict[str, SimulatedSite]) -> None:
    """Check what must hold of all calls, after a calm time that is longer than calls may take."""
    runs = [text for site in sites.values() for text in site.services.runs]
    assert len(runs) == len({*runs}), f"carried out twice: {sorted({text for text in runs if runs.count(text) > 1})}"
    for site in sites.values():
        for call in site.services.calls.values():
            if call.run == site.run:
                assert len(call.results) == 1, f"{call.text} has {len(call.results)} results"
            assert len(call.results) <= 1, f"{call.text} has {len(call.results)} results"
            for result in call.results:
                assert result.time - call.time <= PATIENCE + 1.0, f"{call.text} took too long"
                if result.status is not Status.REFUSED:
                    expected = Status.FAILED if call.name.endswith("/fail") else Status.OK
                    assert result.status is expected and result.text == f"re {call.text}", f"{call.text}: {result}"
                    assert call.text in runs, f"{call.text} was never carried out"
        there = {f"/{other.name}{name}" for other in sites.values() for name in other.services.there if other != site}
        assert site.services.provided == there - site.services.taken, f"{site.name} provides {site.services.provided}"


def check_that_calls_succeed(sites: dict[str, SimulatedSite]) -> None:
    """In calm weather, each call is carried out, and soon."""
    called = []
    for site in sites.values():
        for name in sorted(site.services.provided):
            site.services.call(name)
            called.append(site.services.calls[max(site.services.calls)])
    site.network.run_until(site.network.now + 6.0)
    for call in called:
        statuses = [result.status for result in call.results]
        assert statuses == [Status.FAILED if call.name.endswith("/fail") else Status.OK], f"{call.text}: {call.results}"
