"""The inside of the tool rosbag: verbs, options, progress, and work on many bags."""

import io
import os
import sys
import tempfile
from contextlib import redirect_stdout
from optparse import OptionParser, Values

import rosbag
import rosbag.rosbag_main as tool
from std_msgs.msg import String

os.chdir(tempfile.mkdtemp())
sys.stderr = sys.stdout


def t(title, call):
    try:
        print(title, call())
    except BaseException as error:
        print(title, type(error).__name__)


commands = tool.RosbagCmds()
print(sorted(commands), commands.get_valid_cmds())
commands.add_cmd("foo", lambda words: print("foo", words), "does foo")
commands.add_cmd("bar", lambda words: None, "does bar")
print(commands.get_valid_cmds(), commands.help_cmd(["help", "foo"]), commands["foo"](["x"]), len(commands))

for path in ("/some/long/folder/with/a_long_file_name_indeed.bag", "abcdef.bag"):
    for columns in (45, 50, 52, 55, 60, 70, 80, 100):
        os.environ["COLUMNS"] = str(columns)
        for total in (0, 1, 1000, 1024, 1000 * 1024, 1024**2, 1024**3, 10**12, 10**15):
            with redirect_stdout(io.StringIO()) as out:
                meter = tool.ProgressMeter(path, total + 1, 1000.0)
                meter.step(total // 3)
                meter.step(total // 3, True)
                meter.step(total, force_update=True)
                meter.finish()
            print(columns, total, repr(out.getvalue()).replace("00:01", "00:00"))
print(tool.ProgressMeter.terminal_width())

for take in (tool.handle_split, tool.handle_topics, tool.handle_pause_topics):
    for words in ("a b -c d", "-x", "", "1 2", "5", "a -1 b", "a - b", "a -- b", "a --x b", "-1.5"):
        parser = OptionParser()
        parser.values = Values({"split": None, "size": 1, "topics": [], "pause_topics": []})
        parser.rargs = words.split()
        option = parser.add_option("--x", action="callback", callback=take, dest="split")
        take(option, "--x", None, parser)
        print(take.__name__, words, sorted(vars(parser.values).items()), parser.rargs)

tool.print_trans(String, String, 2)
tool.print_trans(String, None, 0)

for name in ("a.bag", "b.bag"):
    with rosbag.Bag(name, "w") as bag:
        for number in range(5):
            bag.write("/a", String(str(number)))
os.mkdir("out")


def work(old, new, quiet):
    print("work", os.path.basename(old.filename), os.path.basename(new.filename), quiet)
    if interrupted:
        raise KeyboardInterrupt
    if new.get_message_count() == 0:
        for topic, message, stamp in old.read_messages():
            new.write(topic, message, stamp)


interrupted = False
for words in (
    {},
    {"force": True},
    {"quiet": True},
    {"output_dir": "out"},
    {"output_dir": "out", "force": True},
    {"output_dir": "no"},
):
    for copied in (False, True) if "no" not in words.values() else (False,):
        t("op", lambda: tool.bag_op(["a.bag", "b.bag"], False, True, lambda bag: copied, work, **words))
        print(
            words, copied, sorted(os.listdir(".")), sorted(os.listdir("out")), rosbag.Bag("a.bag").get_message_count()
        )
os.remove("a.orig.bag")
interrupted = True
t("interrupted", lambda: tool.bag_op(["a.bag"], False, True, lambda bag: False, work))
print(sorted(os.listdir(".")), rosbag.Bag("a.bag").get_message_count())
with open("c.bag", "w") as file:
    file.write("x")
t("broken", lambda: tool.bag_op(["c.bag", "none.bag"], False, True, lambda bag: False, work))
print(sorted(os.listdir(".")))
