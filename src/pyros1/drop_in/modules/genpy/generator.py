"""The generator of message modules. pyros1 does not need it: it creates classes when they are imported."""

from genmsg import InvalidMsgSpec, MsgContext, MsgGenerationException, MsgSpec

from genpy.base import SIMPLE_TYPES, is_simple
from pyros1.drop_in.module_attributes import module_getattr

_REASON = "classes are created when they are imported; no modules are generated"

__getattr__ = module_getattr(
    __name__,
    Generator=_REASON,
    MsgGenerator=_REASON,
    SrvGenerator=_REASON,
    msg_generator=_REASON,
    srv_generator=_REASON,
)
