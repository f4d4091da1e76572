"""tf, by pyros1: the older interface to transforms over time (https://wiki.ros.org/tf)."""

from tf2_ros import ConnectivityException, ExtrapolationException, LookupException
from tf2_ros import TransformException as Exception

from tf import transformations
from tf.broadcaster import TransformBroadcaster
from tf.listener import Transformer, TransformerROS, TransformListener

# Conversions from the C++ extension of 2012, which programs still import.
_REMOVED_SUFFIXES = ("_bt_to_msg", "_msg_to_bt")


def __getattr__(name: str) -> object:
    if name.endswith(_REMOVED_SUFFIXES):
        raise AttributeError(
            f"tf.{name} converted to a C++ type, and was removed when tf became tf2; stock lacks it, too"
        )
    raise AttributeError(f"pyros1 has no tf.{name}")
