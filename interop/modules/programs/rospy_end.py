"""Answers of services that are not as they should be, sizes of queues of one topic, and hooks that add hooks."""

import logging
import socket
import struct
import threading
import warnings

warnings.simplefilter("ignore")
import rospy
import rospy.core
from std_msgs.msg import String
from std_srvs.srv import Trigger


def t(title, call):
    try:
        print(title, call())
    except Exception as error:
        print(title, type(error).__name__, str(error).partition("DeserializationError")[0][:40])


rospy.init_node("ends")
for sizes in ((3, 7), (None, 7), (2, None), (7, 3)):
    name = "/sizes_%s_%s" % sizes
    one, two = (rospy.Publisher(name, String, queue_size=size) for size in sizes)
    print(sizes, one.impl.queue_size, one.impl is two.impl, one.impl.is_latch)
    one.unregister()
    print(two.impl.ref_count, rospy.Publisher(name, String, queue_size=1, latch=True).impl.is_latch)

# A provider that answers as it is told
listener = socket.create_server(("127.0.0.1", 0))
rospy.get_master().registerService("/odd", "rosrpc://127.0.0.1:%d" % listener.getsockname()[1], rospy.get_node_uri())


def receive(connection):
    size = struct.unpack("<I", connection.recv(4, socket.MSG_WAITALL))[0]
    return connection.recv(size, socket.MSG_WAITALL) if size else b""


def serve(answers, over):
    connection, _ = listener.accept()
    with connection:
        receive(connection)
        fields = [b"callerid=/p", b"md5sum=" + Trigger._md5sum.encode(), b"type=std_srvs/Trigger"]
        fields += [b"response_type=std_srvs/TriggerResponse", b"request_type=std_srvs/TriggerRequest"]
        header = b"".join(struct.pack("<I", len(field)) + field for field in fields)
        connection.sendall(struct.pack("<I", len(header)) + header)
        for answer in answers:
            receive(connection)
            connection.sendall(answer)
        if answers[-1] != CUT:
            over.wait(10)


GOOD = b"\1" + struct.pack("<I", 5) + b"\1\0\0\0\0"
CUT = GOOD[:4]
ANSWERS = {
    "good": [GOOD],
    "left over": [b"\1" + struct.pack("<I", 7) + b"\1\0\0\0\0zz"],
    "short": [b"\1" + struct.pack("<I", 3) + b"\1\0\0"],
    "empty": [b"\1" + struct.pack("<I", 0)],
    "error": [b"\0" + struct.pack("<I", 3) + b"abc"],
    "empty error": [b"\0" + struct.pack("<I", 0)],
    "behind": [GOOD + b"zz"],
    "cut": [CUT],
    "persistent": [GOOD, GOOD],
    "persistent left over": [b"\1" + struct.pack("<I", 7) + b"\1\0\0\0\0zz", GOOD],
}
for title, answers in ANSWERS.items():
    over = threading.Event()
    thread = threading.Thread(target=serve, args=(answers, over))
    thread.start()
    proxy = rospy.ServiceProxy("/odd", Trigger, persistent=len(answers) > 1)
    for _ in answers:
        t(title, lambda: proxy().success)
    over.set()
    proxy.close()
    thread.join(10)
rospy.get_master().unregisterService("/odd", "rosrpc://127.0.0.1:%d" % listener.getsockname()[1])
listener.close()

# Hooks that add hooks
said = []


def hook(name, *more):
    def call(*reason):
        said.append((name, *reason, rospy.is_shutdown()))
        for add, inner in more:
            add(inner)

    return call


client, before, after = rospy.on_shutdown, rospy.core.add_preshutdown_hook, rospy.core.add_shutdown_hook
client(hook("client 1", (client, hook("client of client")), (before, hook("before of client"))))
client(hook("client 2", (after, hook("after of client"))))
before(hook("before 1", (before, hook("before of before")), (after, hook("after of before"))))
after(
    hook(
        "after 1", (after, hook("after of after")), (client, hook("client of after")), (before, hook("before of after"))
    )
)
after(hook("after 2"))
rospy.signal_shutdown("the end")
for add in (client, before, after):
    add(hook("late"))
print(*said, sep="\n")
for wrong in (None, 3, "x"):
    for add in (client, before, after):
        t("no hook", lambda: add(wrong))
