"""rosbag.migration: rules, classes, raw messages."""

import io
import os
import sys
import tempfile
import re
import genpy, genpy.dynamic, rosbag, rosbag.migration as migration
from rosbag.migration import BagMigrationException, MessageMigrator, MessageUpdateRule
from std_msgs.msg import String
from geometry_msgs.msg import Point, Pose, PoseStamped

os.chdir(tempfile.mkdtemp(dir=os.environ["HOME"]))
here = os.getcwd()


def t(title, call, *arguments, **named):
    try:
        found = str(call(*arguments, **named))
    except Exception as error:
        found = f"{type(error).__name__}: {error}"
    print(title, found.replace(here, "HERE").replace("\n", "|"), flush=True)


OLD = genpy.dynamic.generate_dynamic("std_msgs/String", "int32 number\n")["std_msgs/String"]
text = '''
class update_std_msgs_String(MessageUpdateRule):
	old_type = "std_msgs/String"
	old_full_text = """
int32 number
"""
	new_type = "std_msgs/String"
	new_full_text = """
string data
"""
	order = 0
	migrated_types = []
	valid = True
	def update(self, old_msg, new_msg):
		new_msg.data = "number %d" % old_msg.number
'''
open("r.bmr", "w").write(text)
m = MessageMigrator(["r.bmr"], plugins=False)
t("valid", m.all_rules_valid)
t("invalid", m.get_invalid_rules)
rule = None


class Rule(MessageUpdateRule):
    old_type = "std_msgs/String"
    old_full_text = "int32 number\n"
    new_type = "std_msgs/String"
    new_full_text = "string data\n"
    order = 0
    migrated_types = []
    valid = True

    def update(self, o, n):
        n.data = "rule %d" % o.number


for cls in (MessageUpdateRule, Rule):
    print(
        repr(cls.old_type),
        repr(cls.old_full_text),
        repr(cls.new_type),
        repr(cls.new_full_text),
        cls.order,
        cls.migrated_types,
        cls.valid,
    )
    t("make", lambda: type(cls(m, "place")).__name__)
r = Rule(m, "place")
print(r.old_type, r.valid, r.order, [getattr(r, n, None) is not None for n in ("old_class", "new_class")])
t("loc", lambda: r.location)
m2 = MessageMigrator([], plugins=False)
t("add", m2.add_update_rule, Rule(m2, "here"))
old = OLD(number=5)
new = String()
old = OLD(number=5)
for mm in (m,):
    n = String()
    t("migrate", mm.migrate, old, n)
    print(repr(n.data))
    t("look", lambda: mm.lookup_type((OLD._type, OLD._md5sum))._type)
    t("look", lambda: mm.lookup_type(("a/b", "c")))
    t("look", lambda: mm.lookup_type((String._type, String._md5sum))._type)
    t("target", lambda: mm.find_target(OLD)._type)
    b = io.BytesIO()
    old.serialize(b)
    raw = ("std_msgs/String", b.getvalue(), OLD._md5sum, 0, OLD)
    t("raw", lambda: mm.migrate_raw(raw, ("std_msgs/String", None, String._md5sum, 7, String))[:4])
    t("raw2", lambda: mm.migrate_raw(raw, raw)[:4])
    t("array", mm.migrate_array, [old, old], [String(), String()])
    t("array", mm.migrate_array, [old], [String(), String()])
    t("bad", mm.migrate, String("x"), Point())
print([c.__name__ for c in BagMigrationException.__mro__])


def raises():
    raise BagMigrationException("text")


t("raise", raises)


class Bad(MessageUpdateRule):
    pass


t("bad", lambda: Bad(m2, "p").valid)


class Bad2(Rule):
    valid = False


t("add", m2.add_update_rule, Bad2(m2, "q"))
for k in (
    "int32",
    "string",
    "time",
    "duration",
    "float64",
    "bool",
    "geometry_msgs/Point",
    "Header",
    "uint8[]",
    "uint8[3]",
    "string[2]",
    "geometry_msgs/Point[2]",
    "nope/Nope",
    "float32[]",
    "char",
    "byte",
    "std_msgs/Header",
    "char[2]",
    "bool[2]",
    "byte[]",
    "int8[2]",
    "string[]",
    "time[2]",
    "float64[1]",
):
    t("default " + k, lambda: repr(migration.migration_default_value(k)))
for top, d in (
    ("a/B", "int32 X=5\nstring S=hello # not a comment\nint32 y\n"),
    ("a/B", ""),
    ("a/B", "bool T=1\nbyte b=3\n"),
):
    t("const", lambda: sorted(migration.constants_from_def(top, d)))

OLDP = "int32 number\nInner inner\nInner[] many\n\n================================================================================\nMSG: std_msgs/Inner\nint32 a\n"


class Nested(MessageUpdateRule):
    old_type = "std_msgs/String"
    old_full_text = OLDP
    new_type = "std_msgs/String"
    new_full_text = "string data\n"
    order = 0
    migrated_types = [("Inner", "Inner")]
    valid = True

    def update(self, o, n):
        n.data = "rule %d" % o.number


m = MessageMigrator([], plugins=False)
r = Nested(m, "place")
for n in ("Inner", "nope", "std_msgs/String", "String", "int32"):
    t("old %s" % n, lambda: (lambda c: (c._type, c._md5sum))(r.get_old_class(n)))
    t("new %s" % n, lambda: (lambda c: (c._type, c._md5sum))(r.get_new_class(n)))
o = r.old_class(number=4)


class Bad(Nested):
    valid = False


t("bad", lambda: Bad(m, "p").apply(o))


class Empty(MessageUpdateRule):
    pass


e = Empty(m, "q")
t("empty", lambda: e.valid)
t("empty", lambda: e.apply(1))
