"""genpy, by pyros1: the base class of messages, and the time types (https://wiki.ros.org/genpy)."""

from genpy.message import DeserializationError, Message, MessageException, SerializationError, struct_I
from genpy.rostime import Duration, Time, TVal
from pyros1.drop_in.module_attributes import module_getattr

__all__ = [
    "DeserializationError",
    "Duration",
    "Message",
    "MessageException",
    "SerializationError",
    "TVal",
    "Time",
    "struct_I",
]

__getattr__ = module_getattr(__name__)
