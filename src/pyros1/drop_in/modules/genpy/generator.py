"""The generator of message modules; pyros1 does not need it because it generates classes when they are imported."""

from genmsg import InvalidMsgSpec, MsgContext, MsgGenerationException, MsgSpec

from genpy.base import SIMPLE_TYPES, is_simple
from pyros1.drop_in.missing import missing

_REASON = "classes are made when they are imported; there are no modules to generate"

__getattr__ = missing(
    __name__,
    Generator=_REASON,
    MsgGenerator=_REASON,
    SrvGenerator=_REASON,
    msg_generator=_REASON,
    srv_generator=_REASON,
)
