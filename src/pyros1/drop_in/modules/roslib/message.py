"""Messages; this module is older than genpy."""

from genpy.message import (
    DeserializationError,
    Duration,
    Message,
    MessageException,
    SerializationError,
    Time,
    TVal,
    check_type,
    fill_message_args,
    get_message_class,
    get_printable_message_args,
    get_service_class,
    strify_message,
)

from pyros1.drop_in.module_attributes import module_getattr

ROSMessageException = MessageException

__getattr__ = module_getattr(__name__)
