"""Stock tf2's buffer and tf.transformations, for the tests to ask: a JSON list of questions in, a list of answers out.

Run by the stock interpreter. Times are nanoseconds, transforms lists of seven numbers: x y z qx qy qz qw.
"""

import json
import sys

import rospy
import tf2_py
from geometry_msgs.msg import TransformStamped
from tf import transformations
from tf_values import described, made

_MATHS = transformations.__name__


def time(ns):
    return rospy.Time(*divmod(ns, 10**9))


def stamped(parent, child, ns, numbers):
    message = TransformStamped()
    message.header.frame_id = parent
    message.child_frame_id = child
    message.header.stamp = time(ns)
    v, q = message.transform.translation, message.transform.rotation
    v.x, v.y, v.z, q.x, q.y, q.z, q.w = numbers
    return message


def numbers(message):
    v, q = message.transform.translation, message.transform.rotation
    return [message.header.stamp.to_nsec(), [v.x, v.y, v.z, q.x, q.y, q.z, q.w]]


class Asked:
    def __init__(self):
        self.buffer = tf2_py.BufferCore(rospy.Duration(10.0))

    def new(self, keep):
        self.buffer = tf2_py.BufferCore(rospy.Duration(keep))

    def set(self, parent, child, ns, transform, authority):
        self.buffer.set_transform(stamped(parent, child, ns, transform), authority)

    def static(self, parent, child, ns, transform, authority):
        self.buffer.set_transform_static(stamped(parent, child, ns, transform), authority)

    def clear(self):
        self.buffer.clear()

    def lookup(self, target, source, ns):
        return numbers(self.buffer.lookup_transform_core(target, source, time(ns)))

    def full(self, target, target_ns, source, source_ns, fixed):
        answer = self.buffer.lookup_transform_full_core(target, time(target_ns), source, time(source_ns), fixed)
        return numbers(answer)

    def can(self, target, source, ns):
        return list(self.buffer.can_transform_core(target, source, time(ns)))

    def can_full(self, target, target_ns, source, source_ns, fixed):
        return list(self.buffer.can_transform_full_core(target, time(target_ns), source, time(source_ns), fixed))

    def common(self, target, source):
        return self.buffer.get_latest_common_time(target, source).to_nsec()

    def yaml(self):
        return self.buffer.all_frames_as_yaml()

    def string(self):
        return self.buffer.all_frames_as_string()

    def maths(self, name, *arguments):
        return described(getattr(transformations, name)(*map(made, arguments)))

    def maths_names(self):
        """The functions and classes of its own."""
        own = [name for name, thing in vars(transformations).items() if getattr(thing, "__module__", "") == _MATHS]
        return [name for name in own if name[0] != "_"]


def main():
    asked = Asked()
    answers = []
    for word, *arguments in json.load(sys.stdin):
        try:
            answers.append([word, getattr(asked, word)(*arguments)])
        except Exception as error:  # noqa: BLE001 - an answer, too
            answers.append([type(error).__name__, str(error)])
    json.dump(answers, sys.stdout)


main()
