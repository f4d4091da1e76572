"""rosbag_main: its verbs as functions, and what they do to bags."""

import glob
import io
import os
import re
import shutil
import subprocess
import sys
import tempfile
import contextlib
import genpy
import rosbag
from rosbag import Bag, Compression, rosbag_main
from std_msgs.msg import String, Int32

os.chdir(tempfile.mkdtemp(dir=os.environ["HOME"]))
here = os.getcwd()


def t(title, call, *arguments, **named):
    out, err = io.StringIO(), io.StringIO()
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            found = repr(call(*arguments, **named))
        except SystemExit as error:
            found = f"exit {error.code}" if error.code else "None"
        except Exception as error:
            found = f"{type(error).__name__}: {error}"
    print(title, found.replace(here, "HERE"))
    return out.getvalue() + "##" + err.getvalue()


def make(name, **k):
    with Bag(name, "w", **k) as b:
        for i in range(20):
            b.write("/a", String("hello %d" % i * 5), genpy.Time(10 + i))
            b.write("/b", Int32(i), genpy.Time(10 + i, 5))


def facts(name):
    with Bag(name) as b:
        return (
            b.get_message_count(),
            sorted(b.get_type_and_topic_info().topics),
            b.get_compression_info().compression,
            [(x.topic, x.timestamp.to_nsec()) for x in b.read_messages()][:3],
        )


print(Compression.NONE, Compression.BZ2, Compression.LZ4, sorted(n for n in dir(Compression) if n[0] != "_"))
for c in (Compression.NONE, Compression.BZ2, Compression.LZ4, "nope"):
    make("x.bag", compression=c) if c != "nope" else None
    t("made", facts, "x.bag")
    t("wrong", lambda: Bag("y.bag", "w", compression=c).close())
make("a.bag")
t("compress", rosbag_main.compress_cmd, ["a.bag"])
print(sorted(os.listdir(".")))
t("f", facts, "a.bag")
t("again", rosbag_main.compress_cmd, ["a.bag"])
t("lz4 force", rosbag_main.compress_cmd, ["--lz4", "-f", "-q", "a.bag"])
t("f", facts, "a.bag")
os.mkdir("out")
t("dir", rosbag_main.compress_cmd, ["--output-dir", "out", "a.bag"])
print(sorted(os.listdir("out")))
t("f", facts, "out/a.bag")
t("none", rosbag_main.compress_cmd, [])
t("reindex", rosbag_main.reindex_cmd, ["a.bag"])
print(sorted(os.listdir(".")))


def recovered(name):
    """Return whether what was complete is back; stock loses a chunk that was still open."""
    with Bag(name) as b:
        return [(x.topic, x.message.data, x.timestamp.to_nsec()) for x in b.read_messages()][:15]


def unclosed(name):
    with Bag("open.bag", "w", chunk_threshold=200) as b:
        for i in range(20):
            b.write("/a", String("hello %d" % i * 5), genpy.Time(10 + i))
        b.flush()
        shutil.copy("open.bag", name)


unclosed("cut.bag")
t("f", facts, "cut.bag")
t("reindex", rosbag_main.reindex_cmd, ["cut.bag"])
print(sorted(os.listdir(".")))
t("f", recovered, "cut.bag")
t("none", rosbag_main.reindex_cmd, [])
t("check", rosbag_main.check_cmd, ["a.bag"])
t("check", rosbag_main.check_cmd, [])
t("fix", rosbag_main.fix_cmd, ["x.bag", "fixed.bag"])
t("f", facts, "fixed.bag") if os.path.exists("fixed.bag") else None
t("fix", rosbag_main.fix_cmd, [])
t("fix", rosbag_main.fix_cmd, ["x.bag"])
t("filter", rosbag_main.filter_cmd, ["x.bag", "filtered.bag", "topic == '/a' and t.secs < 15"])
t("f", facts, "filtered.bag")
t("filter", rosbag_main.filter_cmd, [])
t("filter", rosbag_main.filter_cmd, ["x.bag", "o.bag"])
t("filter", rosbag_main.filter_cmd, ["nope.bag", "o.bag", "True"])
t("decompress", rosbag_main.decompress_cmd, ["out/a.bag"])
t("f", facts, "out/a.bag")
t("info", rosbag_main.info_cmd, [])
t("info", rosbag_main.info_cmd, ["nope.bag"])
for f in ("record_cmd", "play_cmd", "encrypt_cmd", "decrypt_cmd"):
    t(f, getattr(rosbag_main, f), ["--no-such-option"])
t("play", rosbag_main.play_cmd, [])
t("enc", rosbag_main.encrypt_cmd, [])
t("dec", rosbag_main.decrypt_cmd, [])
# what the verbs do, with rosbag.Bag
make("in.bag")


def copy(old, new):
    for topic, message, stamp in old.read_messages():
        new.write(topic, message, stamp)


with Bag("in.bag") as i, Bag("o3.bag", "w", compression=Compression.BZ2) as o:
    t("copy", copy, i, o)
t("f", facts, "o3.bag")
unclosed("cut2.bag")
shutil.copy("cut2.bag", "r.bag")
with Bag("r.bag", "a", allow_unindexed=True) as o:
    t("reindex", lambda: len([None for _ in o.reindex()]) > 0)
t("f", recovered, "r.bag")
