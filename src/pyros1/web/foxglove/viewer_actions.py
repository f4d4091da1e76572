"""Performs a viewer's actions that may take seconds, and so run in threads: publishing, services, parameters, files."""

from __future__ import annotations

import contextlib
from time import monotonic
from typing import Any

from pyros1.ground.errors import Error, ParameterNotSetError
from pyros1.msgs import Message, load_service
from pyros1.web.foxglove import frames, parameters, payloads, requests, state_machine
from pyros1.web.foxglove.frames import Frame, Level
from pyros1.web.foxglove.requests import ClientChannel, FrameError
from pyros1.web.foxglove.viewer_context import ViewerContext
from pyros1.web.service_calls import ServiceCalls

_CONNECT_TIMEOUT = 0.5
"""Seconds to wait for subscribers to connect before the first message on a viewer's channel."""
_CALL_TIMEOUT = 60.0
"""Timeout in seconds for service calls."""


class Publishers:
    """The publishers of one viewer. Not thread-safe."""

    def __init__(self, context: ViewerContext) -> None:
        self._robot = context.robot
        self._publishers: dict[int, tuple[type[Message], Any]] = {}
        # Channel -> monotonic time until which the channel's first message waits for subscribers.
        self._connect_deadlines: dict[int, float] = {}

    def advertise(self, channel: ClientChannel) -> None:
        """Start publishing on a viewer's channel.

        Raises:
            Error: the topic's name or type is invalid, or the server already publishes the topic with another type.
        """
        node = self._robot.node
        name = self._robot.full_name(channel.topic)
        self._robot.check_visible(name)
        cls = payloads.message_class(channel)
        self._publishers[channel.id] = cls, node.advertise(name, cls)
        self._connect_deadlines[channel.id] = monotonic() + _CONNECT_TIMEOUT

    def publish(self, channel: ClientChannel, payload: bytes) -> None:
        """Publish a message on a viewer's channel.

        Raises:
            Error: the payload is not a message of the channel's type, or the channel cannot be advertised.
        """
        if channel.id not in self._publishers:
            self.advertise(channel)  # an earlier attempt failed, but the next may succeed
        cls, publisher = self._publishers[channel.id]
        message = payloads.decode(cls, channel.encoding, payload, self._robot.node.now())
        deadline = self._connect_deadlines.pop(channel.id, None)
        if deadline is not None and deadline > monotonic():
            publisher.wait_for_subscribers(timeout=deadline - monotonic())
        publisher.publish(message)

    def unadvertise(self, channel: ClientChannel) -> None:
        """Stop publishing on a viewer's channel."""
        self._connect_deadlines.pop(channel.id, None)
        _, publisher = self._publishers.pop(channel.id, (None, None))
        if publisher is not None:
            publisher.unregister()

    def close(self) -> None:
        """Stop publishing on all topics."""
        publishers, self._publishers = self._publishers, {}
        for _, publisher in publishers.values():
            publisher.unregister()


def call_service(service_calls: ServiceCalls, context: ViewerContext, call: state_machine.Call) -> Frame:
    """Call a service; return the frame with its response, or with the reason why it failed."""
    service_id = call.service.id
    try:
        node = context.robot.node
        cls = load_service(call.service.type)
        request = payloads.decode(cls._request_class, call.encoding, call.payload, node.now())
        response = service_calls.call(node, call.service.name, cls, request, _CALL_TIMEOUT)
        return frames.service_response(service_id, call.call, call.encoding, payloads.encode(response, call.encoding))
    except Error as error:
        return frames.service_failure(service_id, call.call, str(error))


def fetch(context: ViewerContext, request: requests.FetchAsset) -> Frame:
    """Read a file; return the frame with the file, or with the reason why it cannot be sent."""
    try:
        return frames.asset(request.id, context.files.read(request.uri))
    except Error as error:
        return frames.asset_failure(request.id, str(error))


def get_parameters(context: ViewerContext, request: requests.GetParameters) -> list[Frame]:
    """Return the frame with the values of the requested parameters, in a list.

    Raises:
        MasterUnreachableError: the master does not respond.
    """
    return [frames.parameter_values(parameters.entries(context.parameters(0.0), request.names), request.id)]


def set_parameters(context: ViewerContext, request: requests.SetParameters) -> list[Frame]:
    """Set parameters; return frames that report problems, and one with the new values if the viewer wants them.

    Raises:
        MasterUnreachableError: the master does not respond.
    """
    response: list[Frame] = []
    for parameter in request.parameters:
        try:
            _set_parameter(context, parameter)
        except Error as error:
            response.append(frames.status(Level.ERROR, f"{parameter.name[:200]} cannot be set: {error}"))
    if request.id is not None and request.parameters:
        names = tuple(each.name for each in request.parameters)
        response += get_parameters(context, requests.GetParameters(names, request.id))
    return response


def _set_parameter(context: ViewerContext, parameter: requests.SetParameter) -> None:
    name = "/" + parameter.name.strip("/")
    if name == "/":
        raise FrameError("it would replace all parameters")
    if parameter.value is None:
        with contextlib.suppress(ParameterNotSetError):
            context.robot.parameters.delete(name)
    else:
        context.robot.parameters.set(name, parameters.value_to_set(parameter))
