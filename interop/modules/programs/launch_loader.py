"""What XmlLoader has for tags: attributes, conditions, parameters, environments."""

import os
import re
import sys
import tempfile
from xml.dom.minidom import parseString
import roslaunch, roslaunch.xmlloader as xmlloader, roslaunch.loader as loader
from roslaunch.config import ROSLaunchConfig
from roslaunch.xmlloader import XmlLoader, ifunless, ifunless_test


def t(title, call, *arguments, **named):
    try:
        found = repr(call(*arguments, **named))
    except Exception as error:
        text = str(error)
        for begin in ("while parsing", "<yaml>", "nope\n", "package [nope]"):  # the rest is in other words
            text = text.partition(begin)[0]
        found = f"{type(error).__name__}: {text}"
    print(title, re.sub(r" at 0x[0-9a-f]+", "", found))
    sys.stdout.flush()


for name in (
    "ARG_ATTRS",
    "ENV_ATTRS",
    "GROUP_ATTRS",
    "INCLUDE_ATTRS",
    "MACHINE_ATTRS",
    "NODE_ATTRS",
    "PARAM_ATTRS",
    "REMAP_ATTRS",
    "ROSPARAM_OPT_ATTRS",
    "TEST_ATTRS",
):
    print(name, getattr(XmlLoader, name))
print(xmlloader.NS, xmlloader.CLEAR_PARAMS, xmlloader.XmlParseException.__mro__)
L = XmlLoader()
C = loader.LoaderContext if hasattr(loader, "LoaderContext") else None


class Context:
    def __init__(self, args=None, filename="/tmp/x.launch"):
        self.resolve_dict = {"arg": args or {}}
        self.filename = filename
        self.ns = "/"
        self.env_args = []


c = Context({"x": "5", "t": "true"})
for text in (
    "plain",
    "$(arg x)",
    "$(arg nope)",
    "$(env HOME_NOPE)",
    "$(dirname)",
    "",
    None,
    "$(eval x)",
    "$(find nope)",
):
    t("resolve %r" % text, L.resolve_args, text, c)
tag = parseString("<a b='1' c='$(arg x)' d='' e='$(arg nope)'/>").documentElement
for names in (("b", "c"), ("b", "d"), ("zz",), (), ("b", "zz", "c"), ("e",), "bc", ["c"]):
    t("opt %s" % (names,), lambda: list(L.opt_attrs(tag, c, names)))
    t("reqd %s" % (names,), lambda: list(L.reqd_attrs(tag, c, names)))
t("opt t", lambda: type(L.opt_attrs(tag, c, ("b",))))
t("req t", lambda: type(L.reqd_attrs(tag, c, ("b",))))
for attributes in (
    "",
    "if='1'",
    "if='0'",
    "if='true'",
    "if='FALSE'",
    "if='$(arg t)'",
    "unless='$(arg t)'",
    "unless='0'",
    "if='2'",
    "if=''",
    "unless=''",
    "if='1' unless='1'",
    "if='$(arg nope)'",
    "if='maybe'",
    "unless='x'",
    "if='$(eval 1 == 2)'",
):
    each = parseString(f"<node {attributes}/>").documentElement
    t("test " + attributes, ifunless_test, L, each, c)

    class Mine:
        resolve_args = L.resolve_args
        opt_attrs = L.opt_attrs

        @ifunless
        def handle(self, tag, context, *rest, **named):
            return "handled", rest, named

    t("decorated", Mine().handle, each, c, 1)
    t("decorated kw", lambda: Mine().handle(each, c, 1, more=2))
t("name", lambda: Mine.handle.__name__)
# load_env
config = ROSLaunchConfig()
ctx = Context()
for n, v in (("A", "b"), ("A", "c"), ("", "b"), (None, "x"), ("x", None), ("y", "")):
    t("env", L.load_env, ctx, config, n, v)
    print(ctx.env_args)
# add_param
for n, v in (
    ("/a", 1),
    ("/a", 2),
    ("/b/c", "x"),
    ("/b", 3),
    ("/a/b", 4),
    ("rel", 5),
    ("~priv", 1),
    ("/d", {"x": 1, "y": {"z": [1]}}),
    ("/", {"e": 1}),
    ("/e e", 1),
    ("", 1),
    ("/f/", None),
    ("/g", {}),
    ("/d", {"w": 2}),
    ("/$(x)", 1),
    ("/h", {"a b": 1}),
    ("/j", [{"a": 1}]),
):
    for verbose in (True, False):
        t("param %r %r" % (n, v), L.add_param, config, n, v, verbose=verbose)
print({k: p.value for k, p in sorted(config.params.items())}, config.config_errors)
# param_value
os.chdir(tempfile.mkdtemp(dir=os.environ["HOME"]))
open("text", "w").write("hello\nworld")
open("bin", "wb").write(b"\0\1\2")
for args in (
    (True, "n", "str", "5", None, None, None),
    (False, "n", "int", "5", None, None, None),
    (False, "n", "int", "x", None, None, None),
    (False, "n", "auto", "5.5", None, None, None),
    (False, "n", "double", "1", None, None, None),
    (False, "n", "bool", "TRUE", None, None, None),
    (False, "n", "bool", "yes", None, None, None),
    (False, "n", "yaml", "[1, {a: 2}]", None, None, None),
    (False, "n", "yaml", "[1", None, None, None),
    (False, "n", "auto", None, "text", None, None),
    (False, "n", "str", None, None, "bin", None),
    (False, "n", "auto", None, "nope", None, None),
    (False, "n", "auto", None, None, "nope", None),
    (True, "n", "auto", None, None, None, "echo 5"),
    (False, "n", "str", None, None, None, "echo 5; exit 3"),
    (False, "n", "str", None, None, None, "sh -c 'echo 5; exit 3'"),
    (False, "n", "yaml", None, None, None, "echo [1]"),
    (False, "n", "auto", None, None, None, "nosuchprogram_x a"),
    (False, "n", "auto", None, None, None, None),
    (False, "n", "what", "5", None, None, None),
    (False, "n", "auto", "", None, None, None),
    (False, "n", "int", "5", "text", None, None),
    (False, "n", None, "5", None, None, None),
    (False, "n", "yaml", None, "text", None, None),
    (False, "n", "int", None, "text", None, None),
    (False, "n", "auto", None, None, None, "echo 'x y' \"z\""),
):
    t("value %s" % (args,), L.param_value, *args)
# load_rosparam
open("p.yaml", "w").write("a: 1\nb: {c: $(arg x)}\n")
open("bad.yaml", "w").write("a: [1\n")
open("list.yaml", "w").write("[1, 2]")
open("empty.yaml", "w").write("")


def rp(*a, **k):
    config = ROSLaunchConfig()
    ctx = Context()
    ctx.ns = "/n/"
    try:
        r = L.load_rosparam(ctx, config, *a, **k)
        print("ok", r, {k: p.value for k, p in sorted(config.params.items())}, config.config_errors)
    except Exception as e:
        print(a, k, type(e).__name__, str(e).split("\n")[0])


for a in (
    ("load", "q", "p.yaml", ""),
    ("load", None, "p.yaml", None),
    ("load", "", "p.yaml", ""),
    ("load", "~q", "p.yaml", None),
    ("load", "~", "p.yaml", None),
    ("load", "/abs", "p.yaml", None),
    ("load", None, None, "a: 1"),
    ("load", "x", None, "5"),
    ("load", None, None, "5"),
    ("load", None, None, ""),
    ("load", "x", None, ""),
    ("load", None, "nope.yaml", None),
    ("load", None, "bad.yaml", None),
    ("load", "x", "list.yaml", None),
    ("load", None, "list.yaml", None),
    ("load", "x", "empty.yaml", None),
    ("load", None, None, "a: [1"),
    ("dump", "q", "out.yaml", None),
    ("dump", None, "out.yaml", None),
    ("dump", None, None, None),
    ("delete", "q", None, None),
    ("delete", None, None, None),
    ("delete", "q", "f", None),
    ("what", "q", None, None),
    (None, "q", "p.yaml", None),
    ("load", "q", "p.yaml", "a: 2"),
    ("load", "x", None, "a: rad(pi)"),
    ("load", "x", None, "a: 1\n---\nb: 2"),
):
    rp(*a, verbose=False)
rp("load", "q", "p.yaml", "", verbose=True)
rp("load", "q", "p.yaml", "", verbose=False, subst_function=lambda s: s.replace("$(arg x)", "7"))
rp("load", "q", None, "b: $(arg x)", verbose=False, subst_function=lambda s: s.replace("$(arg x)", "7"))
