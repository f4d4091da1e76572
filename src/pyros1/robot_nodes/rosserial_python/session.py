"""The protocol between the host and one board, without I/O: takes bytes and times, and returns actions to carry out.

The host requests the board's topics until the board responds, with one rosserial_msgs/TopicInfo for each endpoint. A
board that was reset is silent until the next request, so silent boards get further requests. After 15 s of silence, the
host reports that it lost the board, like stock.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum
from typing import TYPE_CHECKING, Any

from pyros1.ground.errors import MessageError
from pyros1.msgs.rosserial_msgs.msg import Log, TopicInfo
from pyros1.msgs.rosserial_msgs.srv import RequestParam
from pyros1.robot_nodes.rosserial_python.frames import Frame, FrameReader, encode_frame

if TYPE_CHECKING:
    from pyros1.msgs import Message

TOPICS_REQUEST = encode_frame(TopicInfo.ID_PUBLISHER, b"")
STOP_REQUEST = encode_frame(TopicInfo.ID_TX_STOP, b"")
LOST_AFTER = 15.0
"""Seconds of silence until a board counts as lost, as in stock ROS."""
ASK_AGAIN_AFTER = 5.0
"""Seconds of silence until the topics are requested again; boards normally request the time every 2.5 s."""
ASK_PERIOD = 2.0
"""Seconds between requests for the topics while the board does not respond. Boards that are reset when their port is
opened take this long to start."""
MAX_GAP = 1.0
"""Maximum pause in seconds within a frame; after a longer one, the frame is considered cut off."""
MAX_ENDPOINTS = 500


class Kind(IntEnum):
    """The kinds of endpoints; each value is the topic id of the TopicInfo messages about that kind."""

    PUBLISHER = TopicInfo.ID_PUBLISHER
    SUBSCRIBER = TopicInfo.ID_SUBSCRIBER
    SERVER_RESPONSES = TopicInfo.ID_SERVICE_SERVER + TopicInfo.ID_PUBLISHER
    SERVER_REQUESTS = TopicInfo.ID_SERVICE_SERVER + TopicInfo.ID_SUBSCRIBER
    CLIENT_REQUESTS = TopicInfo.ID_SERVICE_CLIENT + TopicInfo.ID_PUBLISHER
    CLIENT_RESPONSES = TopicInfo.ID_SERVICE_CLIENT + TopicInfo.ID_SUBSCRIBER


@dataclass(frozen=True)
class Endpoint:
    """A topic, or one direction of a service, that the board offers or uses.

    Attributes:
        kind: the kind of endpoint, as seen by the board.
        id: the topic id of its messages.
        name: the name of the topic or service.
        type: the type of the messages or of the service.
        md5sum: the md5 sum of the messages, requests or responses in the board's program.
        buffer_size: size in bytes of the largest message that the board can receive or send; 0 or less if unknown.
    """

    kind: Kind
    id: int
    name: str
    type: str
    md5sum: str
    buffer_size: int


@dataclass(frozen=True)
class Send:
    """The action of sending bytes to the board."""

    data: bytes


@dataclass(frozen=True)
class Say:
    """The action of logging a line about the link; ``level`` is one of the constants of rosserial_msgs/Log."""

    level: int
    text: str


@dataclass(frozen=True)
class BoardLog:
    """The action of logging a line that the board sent."""

    level: int
    text: str


@dataclass(frozen=True)
class SetUp:
    """The action of creating an endpoint, or updating an existing one."""

    endpoint: Endpoint


@dataclass(frozen=True)
class Deliver:
    """The action of passing on a message, request or response from the board."""

    endpoint: Endpoint
    data: bytes


@dataclass(frozen=True)
class SendTime:
    """The action of sending the time to the board."""


@dataclass(frozen=True)
class SendParameter:
    """The action of sending a parameter to the board."""

    name: str


Action = Send | Say | BoardLog | SetUp | Deliver | SendTime | SendParameter


class Session:
    """The state of the link to one board.

    Args:
        hint: what the user should check if bytes arrive, but no frames.

    Attributes:
        is_synced: whether the board has responded, and is not lost.
    """

    def __init__(self, hint: str = "") -> None:
        self.is_synced = False
        self._hint = hint
        self._reader = FrameReader()
        self._endpoints: dict[int, Endpoint] = {}
        self._last_frame = self._last_request = self._last_bytes = 0.0
        self._has_complained = False
        self._skipped_before = 0

    @property
    def is_lost(self) -> bool:
        """Whether no valid frame has arrived for `LOST_AFTER`."""
        return self._has_complained

    def start(self, now: float) -> list[Action]:
        """Start the session on a new connection.

        Args:
            now: a monotonic time in seconds, as in the other methods.
        """
        self.is_synced = self._has_complained = False
        self._reader.clear()
        self._skipped_before = self._reader.skipped
        self._last_frame = self._last_bytes = now
        return [self._ask(now)]

    def receive(self, data: bytes, now: float) -> list[Action]:
        """Handle bytes from the board."""
        self._last_bytes = now
        return self._handle(self._reader.feed(data), now)

    def tick(self, now: float) -> list[Action]:
        """Return the actions that are due; to be called several times per second."""
        actions: list[Action] = []
        if self._reader.has_partial_frame and now - self._last_bytes > MAX_GAP:
            actions += self._handle(self._reader.give_up(), now)
        silence = now - self._last_frame
        if silence > LOST_AFTER and not self._has_complained:
            actions.append(Say(Log.ERROR, self._complaint()))
            self.is_synced, self._has_complained = False, True
        period = ASK_AGAIN_AFTER if self.is_synced else ASK_PERIOD
        if silence >= period and now - self._last_request >= period:
            actions.append(self._ask(now))
        return actions

    def _complaint(self) -> str:
        if self.is_synced:
            return f"lost the board: nothing came for {LOST_AFTER:.0f} s; asking it for its topics until it answers"
        garbage = self._reader.skipped - self._skipped_before
        if garbage:
            return f"{garbage} bytes came, but none that rosserial understands: {self._hint}"
        return "nothing came: is the board on, and does its program use rosserial and call spinOnce()?"

    def _ask(self, now: float) -> Send:
        self._last_request = now
        return Send(TOPICS_REQUEST)

    def _handle(self, frames: list[Frame], now: float) -> list[Action]:
        actions: list[Action] = []
        for frame in frames:
            if self._has_complained:
                actions.append(Say(Log.INFO, "the board answers again"))
            self._last_frame, self.is_synced, self._has_complained = now, True, False
            self._skipped_before = self._reader.skipped
            try:
                actions += self._handle_frame(frame, now)
            except MessageError as error:
                actions.append(Say(Log.WARN, f"a message with topic id {frame.topic_id} is not valid: {error}"))
        return actions

    def _handle_frame(self, frame: Frame, now: float) -> list[Action]:
        topic_id = frame.topic_id
        endpoint = self._endpoints.get(topic_id)
        if endpoint is not None:
            return [Deliver(endpoint, frame.data)]
        if topic_id <= max(Kind):
            return self._register(Kind(topic_id), _decode(TopicInfo, frame.data))
        if topic_id == TopicInfo.ID_TIME:
            return [SendTime()]
        if topic_id == TopicInfo.ID_LOG:
            log = _decode(Log, frame.data)
            return [BoardLog(log.level, log.msg)]
        if topic_id == TopicInfo.ID_PARAMETER_REQUEST:
            return [SendParameter(_decode(RequestParam._request_class, frame.data).name)]
        return self._handle_unknown(topic_id, now)

    def _handle_unknown(self, topic_id: int, now: float) -> list[Action]:
        if now - self._last_request < ASK_PERIOD:
            return []  # the request is under way, and the board has not handled it yet
        text = f"the board sends messages with topic id {topic_id}, which it did not announce: asking for its topics"
        return [Say(Log.WARN, text), self._ask(now)]

    def _register(self, kind: Kind, info: Any) -> list[Action]:
        endpoint = Endpoint(kind, info.topic_id, info.topic_name, info.message_type, info.md5sum, info.buffer_size)
        if endpoint.id <= TopicInfo.ID_TX_STOP:
            return [Say(Log.ERROR, f"{endpoint.name} has the topic id {endpoint.id}, which is not for topics: ignored")]
        if len(self._endpoints) >= MAX_ENDPOINTS and endpoint.id not in self._endpoints:
            return [Say(Log.ERROR, f"the board has more than {MAX_ENDPOINTS} topics: {endpoint.name} is ignored")]
        self._endpoints[endpoint.id] = endpoint
        return [SetUp(endpoint)]


def _decode(cls: type[Message], data: bytes) -> Any:
    return cls._decode(data, 0, len(data), True)
