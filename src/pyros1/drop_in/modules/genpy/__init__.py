"""genpy, by pyros1: base classes of messages, and their times."""

from pyros1.errors import DeserializationError, MessageError as MessageException, SerializationError
from pyros1.msgs import Message
from pyros1.timing import Duration, Time, TVal
