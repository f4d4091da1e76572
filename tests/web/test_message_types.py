"""Types that are learned from their publishers."""

from __future__ import annotations

import io
from collections.abc import Callable
from typing import Any

import pytest

from pyros1.ground.errors import UnknownTypeError
from pyros1.msgs import AnyMsg, from_definition
from pyros1.msgs.std_msgs.msg import Float64
from pyros1.observe.decoder import Decoder
from pyros1.web.hub import Arrival
from pyros1.web.message_types import MessageTypes

NAME = "nowhere_msgs/Thing"


class Publisher:
    """Publishes a message to who listens, of a definition that may change."""

    def __init__(self) -> None:
        self.definition: str | None = None
        self.listeners = 0

    def listen(self, topic: str, listener: Callable[[Arrival], object]) -> Callable[[], None]:
        self.listeners += 1
        if self.definition is not None:
            cls = from_definition(NAME, self.definition)
            out = io.BytesIO()
            cls().serialize(out)
            raw = AnyMsg(out.getvalue())
            raw._connection_header = {"type": NAME, "md5sum": cls._md5sum, "message_definition": self.definition}
            listener(Arrival(raw, 0.0, 0.0, Decoder()))

        def end() -> None:
            self.listeners -= 1

        return end


@pytest.fixture
def publisher() -> Publisher:
    return Publisher()


@pytest.fixture
def types(publisher: Publisher) -> MessageTypes:
    return MessageTypes(publisher.listen, timeout=0.01)


def fields(cls: Any) -> list[str]:
    return list(cls.__slots__)


def test_a_type_is_learned_anew_when_its_publisher_is_replaced(types: MessageTypes, publisher: Publisher) -> None:
    with pytest.raises(UnknownTypeError, match="no message"):
        types.find_on("/a", NAME)
    publisher.definition = "int32 one"
    assert fields(types.find_on("/a", NAME)) == ["one"] == fields(types.find(NAME))
    publisher.definition = "int32 two"
    assert fields(types.find_on("/a", NAME)) == ["two"] == fields(types.find(NAME))
    publisher.definition = None
    assert fields(types.find_on("/a", NAME)) == ["two"]  # nobody says anything else
    assert publisher.listeners == 0


def test_a_type_that_is_installed_is_not_learned(types: MessageTypes, publisher: Publisher) -> None:
    publisher.definition = "int32 other"
    assert types.find_on("/a", "std_msgs/Float64") is Float64
