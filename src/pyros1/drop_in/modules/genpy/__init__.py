"""genpy, by pyros1: base classes of messages, and their times."""

from pyros1.ground.errors import DeserializationError, SerializationError
from pyros1.ground.errors import MessageError as MessageException
from pyros1.ground.timing import Duration, Time, TVal
from pyros1.msgs import Message
