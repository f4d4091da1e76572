"""The state of one viewer: what it was sent and what it requested (pure: no sockets, threads or clocks)."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from itertools import islice
from typing import Any

from pyros1.web.foxglove import frames, parameters, payloads, requests
from pyros1.web.foxglove.frames import Frame, Level
from pyros1.web.foxglove.offers import NO_NODES, Channel, Nodes, Offers, Service
from pyros1.web.foxglove.parameters import ParameterValues
from pyros1.web.foxglove.requests import ClientChannel, FrameError

MAX_SUBSCRIPTIONS = 2_000
MAX_CLIENT_CHANNELS = 200
MAX_WATCHED = 10_000
"""Maximum number of parameters that a viewer can watch."""
_MAX_PROBLEMS = 100
_MAX_PER_FRAME = 200
"""Maximum number of channels or services per frame, since their definitions are long."""
_READ_ONLY = "this server is read-only (--read-only)"


@dataclass(frozen=True)
class Listen:
    """Start a subscription."""

    subscription: int
    channel: Channel


@dataclass(frozen=True)
class StopListening:
    """End a subscription."""

    subscription: int


@dataclass(frozen=True)
class Advertise:
    """Start publishing."""

    channel: ClientChannel


@dataclass(frozen=True)
class Unadvertise:
    """Stop publishing."""

    channel: ClientChannel


@dataclass(frozen=True)
class Publish:
    """Publish a message."""

    channel: ClientChannel
    payload: bytes


@dataclass(frozen=True)
class Call:
    """Call a service."""

    service: Service
    call: int
    encoding: str
    payload: bytes


Action = (
    Listen
    | StopListening
    | Advertise
    | Unadvertise
    | Publish
    | Call
    | requests.GetParameters
    | requests.SetParameters
    | requests.WatchParameters
    | requests.FetchAsset
)
"""Actions to perform for a viewer; requests that need no state are passed on unchanged."""
Result = tuple[list[Action], list[Frame]]


class Machine:
    """The protocol's state machine for one viewer.

    Args:
        read_only: whether the viewer must not change anything.
    """

    def __init__(self, read_only: bool = False) -> None:
        self._read_only = read_only
        self._offers = Offers()
        self._channels: dict[int, Channel] = {}
        self._services: dict[int, Service] = {}
        self._subscriptions: dict[int, int] = {}  # the viewer's id of the subscription -> channel
        self._client_channels: dict[int, ClientChannel] = {}
        self._watched: dict[str, Any] = {}  # parameter -> value as last sent
        self._graph: Nodes | None = None  # the graph as last sent; None if it is not watched
        self._problems: dict[str, str] = {}

    # Connecting -------------------------------------------------------------------------------------------------------

    def hello(self, name: str, session: str, simulated: bool) -> list[Frame]:
        """Return the first frames.

        Args:
            name: name of the server.
            session: an id that is unique to each run of the server.
            simulated: whether time is simulated. With wall time, viewers use their own clock.
        """
        capabilities = ["parameters", "parametersSubscribe", "connectionGraph", "assets"]
        if not self._read_only:
            capabilities += ["clientPublish", "services"]
        if simulated:
            capabilities.append("time")
        return [frames.server_info(name, capabilities, session, {"ROS_DISTRO": "noetic"}), frames.advertise([])]

    # Events -----------------------------------------------------------------------------------------------------------

    def offer(self, offers: Offers) -> Result:
        """Process the current offers."""
        self._offers = offers
        actions: list[Action] = []
        found: list[Frame] = []
        channels = {each.id: each for each in offers.channels.values()}
        stale = [number for number in self._channels if number not in channels]
        for subscription in [each for each, number in self._subscriptions.items() if number not in channels]:
            del self._subscriptions[subscription]
            actions.append(StopListening(subscription))
        if stale:
            found.append(frames.unadvertise(stale))
        new = [each for number, each in channels.items() if number not in self._channels]
        found += [frames.advertise(batch) for batch in _batches(new)]
        self._channels = channels
        if not self._read_only:
            found += self._offer_services({each.id: each for each in offers.services.values()})
        if self._graph is not None:
            found += self._graph_update()
        return actions, [*found, *self.problems(offers.problems)]

    def _offer_services(self, services: dict[int, Service]) -> list[Frame]:
        stale = [number for number in self._services if number not in services]
        new = [each for number, each in services.items() if number not in self._services]
        self._services = services
        unadvertised = [frames.unadvertise_services(stale)] if stale else []
        return [*unadvertised, *(frames.advertise_services(batch) for batch in _batches(new))]

    def _graph_update(self) -> list[Frame]:
        frame = frames.graph_update(self._graph or NO_NODES, self._offers.nodes)
        self._graph = self._offers.nodes
        return [] if frame is None else [frame]

    def problems(self, problems: Mapping[str, str]) -> list[Frame]:
        """Process the current problems, given by id; return frames for the new and the resolved ones."""
        now = dict(islice(problems.items(), _MAX_PROBLEMS))
        resolved = [name for name in self._problems if name not in now]
        found = [
            frames.status(Level.WARNING, text, name) for name, text in now.items() if self._problems.get(name) != text
        ]
        self._problems = now
        return [frames.remove_status(resolved), *found] if resolved else found

    @property
    def watches_parameters(self) -> bool:
        """Whether the viewer watches parameters."""
        return bool(self._watched)

    def parameters(self, values: ParameterValues) -> list[Frame]:
        """Process the current parameters; return frames with those that have changed."""
        changed: dict[str, Any] = {}
        for name, old in self._watched.items():
            new = values.get(name)
            if not _is_same(new, old):
                changed[name] = new
        self._watched.update(changed)
        if not changed:
            return []
        return [frames.parameter_values([parameters.entry(*each) for each in changed.items()])]

    def watch(self, names: Iterable[str], values: ParameterValues) -> list[Frame]:
        """Start reporting changes of parameters.

        Args:
            names: names of the parameters; empty for all.
            values: the current values.

        Returns:
            Frames with the current values of parameters that were not watched yet.
        """
        unwatched = [name for name in (tuple(names) or values.flat) if name not in self._watched]
        capacity = MAX_WATCHED - len(self._watched)
        new = {name: values.get(name) for name in unwatched[:capacity]}
        self._watched.update(new)
        found: list[Frame] = []
        if new:
            found.append(frames.parameter_values([parameters.entry(*each) for each in new.items()]))
        if len(unwatched) > capacity:
            found.append(frames.status(Level.WARNING, f"at most {MAX_WATCHED} parameters can be watched"))
        return found

    def refuse(self, subscription: int) -> None:
        """Remove a subscription that failed."""
        self._subscriptions.pop(subscription, None)

    # Requests of the viewer -------------------------------------------------------------------------------------------

    def handle(self, frame: str | bytes) -> Result:
        """Process a frame; return the actions to perform and the frames of the response."""
        try:
            return self._handle(requests.parse(frame))
        except FrameError as error:
            return [], [frames.status(Level.ERROR, str(error))]

    def _handle(self, request: requests.Request) -> Result:  # noqa: PLR0911 - one line per request
        match request:
            case requests.Subscribe(pairs):
                return self._subscribe(pairs)
            case requests.Unsubscribe(numbers):
                known = [
                    number for number in dict.fromkeys(numbers) if self._subscriptions.pop(number, None) is not None
                ]
                return [StopListening(number) for number in known], []
            case requests.ClientMessage(number, payload):
                channel = self._client_channels.get(number)
                if channel is None:
                    raise FrameError(_READ_ONLY if self._read_only else f"you have not advertised a channel {number}")
                return [Publish(channel, payload)], []
            case requests.CallService():
                return self._call(request)
            case requests.ClientAdvertise(channels):
                return self._advertise(channels)
            case requests.ClientUnadvertise(numbers):
                removed = [self._client_channels.pop(number, None) for number in dict.fromkeys(numbers)]
                return [Unadvertise(channel) for channel in removed if channel is not None], []
            case requests.SetParameters() if self._read_only:
                names = tuple(each.name for each in request.parameters)
                reread: list[Action] = [requests.GetParameters(names, request.id)] if names else []
                return reread, [frames.status(Level.ERROR, _READ_ONLY)]
            case requests.UnwatchParameters(watched):
                for name in watched or tuple(self._watched):
                    self._watched.pop(name, None)
                return [], []
            case requests.WatchGraph():
                self._graph = self._graph or NO_NODES
                return [], self._graph_update()
            case requests.UnwatchGraph():
                self._graph = None
                return [], []
        return [request], []

    def _subscribe(self, pairs: Iterable[tuple[int, int]]) -> Result:
        actions: list[Action] = []
        problems: list[str] = []
        subscribed = {*self._subscriptions.values()}
        for subscription, number in pairs:
            channel = self._channels.get(number)
            if subscription in self._subscriptions:
                problems.append(f"you already have a subscription {subscription}")
            elif channel is None:
                problems.append(f"there is no channel {number}")
            elif number in subscribed:
                problems.append(f"you already have a subscription to {channel.topic}")
            elif len(self._subscriptions) >= MAX_SUBSCRIPTIONS:
                problems.append(f"a viewer can have at most {MAX_SUBSCRIPTIONS} subscriptions")
            else:
                self._subscriptions[subscription] = number
                subscribed.add(number)
                actions.append(Listen(subscription, channel))
        return actions, _warnings(problems)

    def _advertise(self, channels: Iterable[ClientChannel]) -> Result:
        if self._read_only:
            raise FrameError(_READ_ONLY)
        actions: list[Action] = []
        problems: list[str] = []
        for channel in channels:
            try:
                payloads.check_encoding(channel.encoding)
            except FrameError as error:
                problems.append(f"{channel.topic}: {error}")
                continue
            if channel.id in self._client_channels:
                problems.append(f"you already have a channel {channel.id}")
            elif len(self._client_channels) >= MAX_CLIENT_CHANNELS:
                problems.append(f"a viewer can have at most {MAX_CLIENT_CHANNELS} channels")
            else:
                known = self._offers.channels.get(channel.topic)
                if known is not None and known.type != payloads.type_name(channel):
                    problems.append(
                        f"{channel.topic} carries {known.type}, so no subscriber would accept {channel.type}"
                    )
                self._client_channels[channel.id] = channel
                actions.append(Advertise(channel))
        return actions, _warnings(problems)

    def _call(self, request: requests.CallService) -> Result:
        service = self._services.get(request.service)
        reason = ""
        if self._read_only:
            reason = _READ_ONLY
        elif service is None:
            reason = f"there is no service {request.service}"
        else:
            try:
                payloads.check_encoding(request.encoding)
            except FrameError as error:
                reason = str(error)
        if service is None or reason:
            return [], [frames.service_failure(request.service, request.call, reason)]
        return [Call(service, request.call, request.encoding, request.payload)], []


def _is_same(first: Any, second: Any) -> bool:
    """Return whether parameter values have the same type and value; NaN is the same as NaN."""
    if isinstance(first, (float, list, dict)):
        return repr(first) == repr(second)
    return type(first) is type(second) and bool(first == second)


def _batches(items: list[Any]) -> Iterable[list[Any]]:
    return (items[start : start + _MAX_PER_FRAME] for start in range(0, len(items), _MAX_PER_FRAME))


def _warnings(problems: list[str]) -> list[Frame]:
    if not problems:
        return []
    more = f" (and {len(problems) - 1} more such problems)" if len(problems) > 1 else ""
    return [frames.status(Level.WARNING, problems[0][:500] + more)]
