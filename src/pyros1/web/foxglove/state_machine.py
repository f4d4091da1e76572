"""Keeps one viewer's state: what it was sent, and what it has requested (no sockets, threads or clocks)."""

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
MAX_WATCHED_PARAMETERS = 10_000
"""Maximum number of parameters that a viewer can watch."""
_MAX_PROBLEMS = 100
_MAX_ITEMS_PER_FRAME = 200
"""Maximum number of channels or services per frame, since their definitions are long."""
_READ_ONLY_MESSAGE = "this server is read-only (--read-only)"


@dataclass(frozen=True)
class Listen:
    """Start to send a channel's messages to the viewer."""

    subscription: int
    channel: Channel


@dataclass(frozen=True)
class StopListening:
    """Stop sending the messages of a subscription to the viewer."""

    subscription: int


@dataclass(frozen=True)
class Advertise:
    """Start publishing on a topic for the viewer."""

    channel: ClientChannel


@dataclass(frozen=True)
class Unadvertise:
    """Stop publishing on a topic for the viewer."""

    channel: ClientChannel


@dataclass(frozen=True)
class Publish:
    """Publish a message from the viewer."""

    channel: ClientChannel
    payload: bytes


@dataclass(frozen=True)
class Call:
    """Call a service for the viewer."""

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
"""An action to perform for the viewer. Requests that do not depend on the machine's state are actions as they are."""
Result = tuple[list[Action], list[Frame]]
"""The actions to perform, and the frames to send."""


class StateMachine:
    """The protocol's state machine for one viewer.

    Args:
        read_only: whether the viewer must not change anything.
    """

    def __init__(self, read_only: bool = False) -> None:
        self._read_only = read_only
        self._offers = Offers()
        self._channels: dict[int, Channel] = {}
        self._services: dict[int, Service] = {}
        self._subscriptions: dict[int, int] = {}  # the viewer's id of the subscription -> the channel's id
        self._client_channels: dict[int, ClientChannel] = {}
        self._watched_values: dict[str, Any] = {}  # parameter -> value as last sent
        self._sent_graph: Nodes | None = None  # the graph as last sent; None if it is not watched
        self._sent_problems: dict[str, str] = {}

    # Connecting -------------------------------------------------------------------------------------------------------

    def hello(self, name: str, session: str, simulated: bool) -> list[Frame]:
        """Return the frames to send first: the description of the server, and an empty list of channels.

        Args:
            name: the server's name.
            session: an id that is unique to each run of the server.
            simulated: whether time is simulated, so that it must be sent. With wall time, viewers use their own clock.
        """
        capabilities = ["parameters", "parametersSubscribe", "connectionGraph", "assets"]
        if not self._read_only:
            capabilities += ["clientPublish", "services"]
        if simulated:
            capabilities.append("time")
        return [frames.server_info(name, capabilities, session, {"ROS_DISTRO": "noetic"}), frames.advertise([])]

    # Events -----------------------------------------------------------------------------------------------------------

    def update_offers(self, offers: Offers) -> Result:
        """Process the current offers; return the actions to perform and the frames to send."""
        self._offers = offers
        actions: list[Action] = []
        response: list[Frame] = []
        channels = {item.id: item for item in offers.channels.values()}
        stale = [channel_id for channel_id in self._channels if channel_id not in channels]
        for subscription in [item for item, channel_id in self._subscriptions.items() if channel_id not in channels]:
            del self._subscriptions[subscription]
            actions.append(StopListening(subscription))
        if stale:
            response.append(frames.unadvertise(stale))
        new_channels = [item for channel_id, item in channels.items() if channel_id not in self._channels]
        response += [frames.advertise(batch) for batch in _batches(new_channels)]
        self._channels = channels
        if not self._read_only:
            response += self._offer_services({item.id: item for item in offers.services.values()})
        if self._sent_graph is not None:
            response += self._graph_update()
        return actions, [*response, *self.update_problems(offers.problems)]

    def _offer_services(self, services: dict[int, Service]) -> list[Frame]:
        stale = [service_id for service_id in self._services if service_id not in services]
        new_services = [service for service_id, service in services.items() if service_id not in self._services]
        self._services = services
        unadvertised = [frames.unadvertise_services(stale)] if stale else []
        return [*unadvertised, *(frames.advertise_services(batch) for batch in _batches(new_services))]

    def _graph_update(self) -> list[Frame]:
        frame = frames.graph_update(self._sent_graph or NO_NODES, self._offers.nodes)
        self._sent_graph = self._offers.nodes
        return [] if frame is None else [frame]

    def update_problems(self, problems: Mapping[str, str]) -> list[Frame]:
        """Process the current problems, by id; return frames that report new problems and remove resolved ones."""
        current = dict(islice(problems.items(), _MAX_PROBLEMS))
        resolved = [name for name in self._sent_problems if name not in current]
        updates = [
            frames.status(Level.WARNING, text, name)
            for name, text in current.items()
            if self._sent_problems.get(name) != text
        ]
        self._sent_problems = current
        return [frames.remove_status(resolved), *updates] if resolved else updates

    @property
    def watches_parameters(self) -> bool:
        """Whether the viewer watches parameters."""
        return bool(self._watched_values)

    def update_parameters(self, values: ParameterValues) -> list[Frame]:
        """Process the current parameters; return frames with the watched parameters that have changed."""
        changed: dict[str, Any] = {}
        for name, old in self._watched_values.items():
            new = values.get(name)
            if not _is_same(new, old):
                changed[name] = new
        self._watched_values.update(changed)
        if not changed:
            return []
        return [frames.parameter_values([parameters.entry(*each) for each in changed.items()])]

    def watch(self, names: Iterable[str], values: ParameterValues) -> list[Frame]:
        """Start reporting changes to parameters.

        Args:
            names: names of the parameters; empty for all existing parameters.
            values: the parameters' current values.

        Returns:
            Frames with the current values of those parameters that were not being watched yet.
        """
        unwatched = [name for name in (tuple(names) or values.flat) if name not in self._watched_values]
        capacity = MAX_WATCHED_PARAMETERS - len(self._watched_values)
        new = {name: values.get(name) for name in unwatched[:capacity]}
        self._watched_values.update(new)
        response: list[Frame] = []
        if new:
            response.append(frames.parameter_values([parameters.entry(*each) for each in new.items()]))
        if len(unwatched) > capacity:
            response.append(frames.status(Level.WARNING, f"at most {MAX_WATCHED_PARAMETERS} parameters can be watched"))
        return response

    def remove_subscription(self, subscription: int) -> None:
        """Remove a subscription that could not be started."""
        self._subscriptions.pop(subscription, None)

    # Requests from the viewer -----------------------------------------------------------------------------------------

    def handle(self, frame: str | bytes) -> Result:
        """Process a frame from the viewer; return the actions to perform, and the response's frames."""
        try:
            return self._handle(requests.parse(frame))
        except FrameError as error:
            return [], [frames.status(Level.ERROR, str(error))]

    def _handle(self, request: requests.Request) -> Result:  # noqa: PLR0911 - one line per request
        match request:
            case requests.Subscribe(pairs):
                return self._subscribe(pairs)
            case requests.Unsubscribe(numbers):
                ended = [
                    number for number in dict.fromkeys(numbers) if self._subscriptions.pop(number, None) is not None
                ]
                return [StopListening(number) for number in ended], []
            case requests.ClientMessage(number, payload):
                channel = self._client_channels.get(number)
                if channel is None:
                    raise FrameError(
                        _READ_ONLY_MESSAGE if self._read_only else f"you have not advertised channel {number}"
                    )
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
                get_current_values: list[Action] = [requests.GetParameters(names, request.id)] if names else []
                return get_current_values, [frames.status(Level.ERROR, _READ_ONLY_MESSAGE)]
            case requests.UnwatchParameters(watched):
                for name in watched or tuple(self._watched_values):
                    self._watched_values.pop(name, None)
                return [], []
            case requests.WatchGraph():
                self._sent_graph = self._sent_graph or NO_NODES
                return [], self._graph_update()
            case requests.UnwatchGraph():
                self._sent_graph = None
                return [], []
        return [request], []

    def _subscribe(self, pairs: Iterable[tuple[int, int]]) -> Result:
        actions: list[Action] = []
        problems: list[str] = []
        subscribed = {*self._subscriptions.values()}
        for subscription, channel_id in pairs:
            channel = self._channels.get(channel_id)
            if subscription in self._subscriptions:
                problems.append(f"subscription {subscription} already exists")
            elif channel is None:
                problems.append(f"there is no channel {channel_id}")
            elif channel_id in subscribed:
                problems.append(f"you already have a subscription to {channel.topic}")
            elif len(self._subscriptions) >= MAX_SUBSCRIPTIONS:
                problems.append(f"a viewer can have at most {MAX_SUBSCRIPTIONS} subscriptions")
            else:
                self._subscriptions[subscription] = channel_id
                subscribed.add(channel_id)
                actions.append(Listen(subscription, channel))
        return actions, _warnings(problems)

    def _advertise(self, channels: Iterable[ClientChannel]) -> Result:
        if self._read_only:
            raise FrameError(_READ_ONLY_MESSAGE)
        actions: list[Action] = []
        problems: list[str] = []
        for channel in channels:
            try:
                payloads.check_encoding(channel.encoding)
            except FrameError as error:
                problems.append(f"{channel.topic}: {error}")
                continue
            if channel.id in self._client_channels:
                problems.append(f"channel {channel.id} already exists")
            elif len(self._client_channels) >= MAX_CLIENT_CHANNELS:
                problems.append(f"a viewer can have at most {MAX_CLIENT_CHANNELS} channels")
            else:
                existing = self._offers.channels.get(channel.topic)
                if existing is not None and existing.type != payloads.type_name(channel):
                    problems.append(
                        f"{channel.topic} carries {existing.type}, so no subscriber would accept {channel.type}"
                    )
                self._client_channels[channel.id] = channel
                actions.append(Advertise(channel))
        return actions, _warnings(problems)

    def _call(self, request: requests.CallService) -> Result:
        service = self._services.get(request.service)
        reason = ""
        if self._read_only:
            reason = _READ_ONLY_MESSAGE
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
    """Return whether two parameter values have the same type and value; NaN counts as equal to NaN."""
    if isinstance(first, (float, list, dict)):
        return repr(first) == repr(second)
    return type(first) is type(second) and bool(first == second)


def _batches(items: list[Any]) -> Iterable[list[Any]]:
    return (items[start : start + _MAX_ITEMS_PER_FRAME] for start in range(0, len(items), _MAX_ITEMS_PER_FRAME))


def _warnings(problems: list[str]) -> list[Frame]:
    if not problems:
        return []
    more = f" (and {len(problems) - 1} more such problems)" if len(problems) > 1 else ""
    return [frames.status(Level.WARNING, problems[0][:500] + more)]
