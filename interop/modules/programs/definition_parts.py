"""What genmsg and roslib.msgs, roslib.srvs say of definitions, for right and wrong ones; from texts and files."""

import os
import sys
import tempfile
import warnings

warnings.simplefilter("ignore")
import genmsg
import genmsg.base as base
import genmsg.gentools as gentools
import genmsg.msg_loader as loader
import genmsg.msgs
import genmsg.names
import genmsg.srvs
import roslib.msgs as msgs
import roslib.srvs as srvs


HOME = os.path.realpath(tempfile.mkdtemp())
PATHS = {}


def clean(value):
    return str(value).replace(HOME, "HOME")


def t(title, call):
    try:
        value = call()
        print(title, type(value).__name__, clean(repr(value)) if " at 0x" not in repr(value) else "")
        return value
    except Exception as error:
        text = "" if isinstance(error, (genmsg.InvalidMsgSpec, msgs.MsgSpecException, KeyError)) else clean(error)
        print(title, "raised", type(error).__name__.replace("InvalidMsgSpec", "MsgSpecException"), text)


def put(package, kind, name, text):
    folder = os.path.join(HOME, package, kind)
    os.makedirs(folder, exist_ok=True)
    PATHS.setdefault(package, [os.path.join(HOME, package, "msg")])
    with open(os.path.join(folder, f"{name}.{kind}"), "w") as file:
        file.write(text)


put("std_msgs", "msg", "Header", "uint32 seq\ntime stamp\nstring frame_id\n")
put("a", "msg", "One", "Header header\nint32 x=3 # three\nTwo[] twos\nb/Three three\nstring S = a # b\n")
put("a", "msg", "Two", "duration d\nint8[4] fixed\nuint8[] data\nbyte b\nchar c\n")
put("b", "msg", "Three", "# nothing\n")
put("b", "msg", "Bad", "no_such t\n")
put("b", "msg", "Lost", "a/Nothing t\n")
put("b", "msg", "Wrong", "int32 1x\n")
put("b", "srv", "Do", "a/One one\n---\nThree three\nint32 X=1\n")


def show(title, spec, text=True):
    if spec is None:
        return
    print(
        title, spec.full_name, spec.short_name, spec.package, spec.has_header(), spec == spec, spec == 3, spec != spec
    )
    print(title, spec.types, spec.names, [(c.type, c.name, c.val, c.val_text) for c in spec.constants])
    print(
        title,
        [
            (f.type, f.name, f.base_type, f.is_array, f.array_len, f.is_header, f.is_builtin)
            for f in spec.parsed_fields()
        ],
        list(spec.fields()),
    )
    print(title, str(spec) if text else "")


# Constants
for module in (base, loader, genmsg, genmsg.msgs):
    for name in (
        "COMMENTCHAR",
        "CONSTCHAR",
        "EXT_MSG",
        "EXT_SRV",
        "IODELIM",
        "MSG_DIR",
        "SEP",
        "SRV_DIR",
        "DURATION",
        "DURATION_MSG",
        "HEADER",
        "HEADER_FULL_NAME",
        "TIME",
        "TIME_MSG",
    ):
        print(module.__name__, name, getattr(module, name, None))
print(genmsg.names.PRN_SEPARATOR, msgs.BUILTIN_TYPES, msgs.PRIMITIVE_TYPES)
for name in ("COMMENTCHAR", "CONSTCHAR", "DURATION", "EXT", "HEADER", "SEP", "TIME"):
    print(name, getattr(msgs, name), [getattr(srvs, each, None) for each in (name, "IODELIM")])
print(base.verbose)

# What is said on the way
base.log("quiet")
base.log_verbose(True)
base.log("one", 2, "three")
genmsg.log_verbose(False)
base.log("quiet again")
base.plog("a", "quiet, too")  # otherwise stock's cannot
sys.stdout.flush()

# Files
for package, name in (("a", "One"), ("b", "One"), ("c", "One"), ("b", "Bad"), ("", "x"), ("a", "")):
    t("msg file", lambda: loader.get_msg_file(package, name, PATHS))
    t("srv file", lambda: loader.get_srv_file(package, name, PATHS))
t("srv file", lambda: loader.get_srv_file("b", "Do", {"b": [os.path.join(HOME, "b", "srv")]}))
t("several", lambda: loader.get_msg_file("a", "Two", {"a": ["/no", PATHS["a"][0]]}))
t("no list", lambda: loader.get_msg_file("a", "Two", {"a": PATHS["a"][0]}))
context = genmsg.MsgContext.create_default()
for package, name in (("a", "One"), ("a", "Two"), ("b", "Bad"), ("b", "Lost"), ("b", "Wrong"), ("b", "No")):
    path = os.path.join(HOME, package, "msg", name + ".msg")
    spec = t(f"from file {name}", lambda: loader.load_msg_from_file(context, path, f"{package}/{name}"))
    show(name, spec)
    if spec is not None:
        t(f"depends {name}", lambda: loader.load_msg_depends(context, spec, PATHS))
        t(f"depends {name}", lambda: context.get_depends(f"{package}/{name}"))
        t(f"all {name}", lambda: sorted(set(context.get_all_depends(f"{package}/{name}"))))
        t(f"md5 {name}", lambda: gentools.compute_md5(context, spec))
        t(f"md5 text {name}", lambda: gentools.compute_md5_text(context, spec))
        t(f"md5 2 {name}", lambda: gentools.compute_md5_v2(context, spec))
        t(f"full {name}", lambda: gentools.compute_full_text(context, spec))
for name in ("Do", "No"):
    path = os.path.join(HOME, "b", "srv", name + ".srv")
    spec = t(f"service {name}", lambda: loader.load_srv_from_file(context, path, f"b/{name}"))
    if spec is not None:
        show("request", spec.request)
        show("response", spec.response)
        print(
            str(spec), spec.full_name, spec.short_name, spec.package, spec.text, spec == spec, spec == 1, spec != spec
        )
        t("depends", lambda: loader.load_depends(context, spec, PATHS))
        t("md5", lambda: gentools.compute_md5(context, spec))
        t("md5 2", lambda: gentools.compute_md5_v2(context, spec))
t("type", lambda: loader.load_msg_by_type(context, "a/One", PATHS))
t("service", lambda: loader.load_srv_by_type(context, "b/Do", {"b": [os.path.join(HOME, "b", "srv")]}))
t("wrong", lambda: loader.load_msg_by_type(context, "One", PATHS))
request = genmsg.MsgSpec(["int32"], ["a"], [], "int32 a", "c/XRequest")
response = genmsg.MsgSpec([], [], [], "", "c/XResponse")
show("service", genmsg.SrvSpec(request, response, "text", "c/X").request)
made = genmsg.SrvSpec(request, response, "text", "c/X")
print(
    made.full_name,
    made.package,
    made.short_name,
    made.text,
    made == genmsg.SrvSpec(request, response, "text", "c/X"),
    made == genmsg.SrvSpec(request, request, "text", "c/X"),
    made != 3,
)
for arguments in (
    ([], [], [], "", "X"),
    ([], [], [], "", ""),
    ([], [], [], None, "c/X"),
    (["int32"], ["a"], [], "", "c/X", "p"),
):
    t("spec", lambda: genmsg.MsgSpec(*arguments).full_name)

# Contexts
context = genmsg.MsgContext()
t("register", lambda: context.register("c/X", request))
print(context.is_registered("c/X"), context.get_registered("c/X") is request, sorted(context.__dict__) != [])
t("again", lambda: context.register("c/X", response))
print(context.get_registered("c/X") is response)
for name in ("X", "c/Y", ""):
    t("registered", lambda: context.is_registered(name))
    t("get", lambda: context.get_registered(name))
    t("register", lambda: context.register(name, request))
    t("file", lambda: context.get_file(name))
    t("depends", lambda: context.get_depends(name))
    t("set", lambda: context.set_file(name, "/f"))
    t("file", lambda: context.get_file(name))
    t("set", lambda: context.set_depends(name, ["std_msgs/Header"]))
    t("depends", lambda: context.get_depends(name))
print(
    genmsg.MsgContext.create_default().is_registered("time"),
    genmsg.MsgContext().is_registered("time"),
    str(context) != "",
)

# roslib.msgs
for name in ("a", "1a", "a_b", "a__b", "_a", "A", "a-b", "", "time", "int32", "a/b", None):
    t(f"field name {name}", lambda: msgs.is_valid_msg_field_name(name))
    t(f"type {name}", lambda: msgs.is_valid_msg_type(name))
    t(f"builtin {name}", lambda: msgs.is_builtin(name))
    t(f"header {name}", lambda: msgs.is_header_type(name))
for name in (
    "a/b[]",
    "a[3]",
    "a[x]",
    "a[",
    "a]",
    "a/b/c",
    "/a",
    "a/",
    "Header",
    "std_msgs/Header",
    "roslib/Header",
    "Header[]",
):
    t(f"type {name}", lambda: msgs.is_valid_msg_type(name))
    t(f"header {name}", lambda: msgs.is_header_type(name))
    t(f"parsed {name}", lambda: msgs.parse_type(name))
    t(f"bare {name}", lambda: msgs.base_msg_type(name))
for package, name in (("a", "One"), ("b", "Three"), ("std_msgs", "Header"), ("b", "Wrong"), ("b", "Bad"), ("b", "No")):
    path = os.path.join(HOME, package, "msg", name + ".msg")
    for context in ("", package):
        found = t(f"load {name}", lambda: msgs.load_from_file(path, context))
        if found:
            show(name, found[1], text=name == "Header")
for name in ("Do", "No"):
    path = os.path.join(HOME, "b", "srv", name + ".srv")
    for context in ("", "b"):
        found = t(f"load {name}", lambda: srvs.load_from_file(path, context))
        if found:
            print(found[0], found[1].request.names, found[1].response.types, found[1].text, str(found[1]))
            print(found[1].full_name, found[1].short_name, found[1].package, found[1] == found[1])
one = msgs.load_from_string("int8 C=3\nint32 a\nHeader header")
print(one.has_header(), one.types, one.names, one.text, one == one, one == 3, list(one.fields()))
print([(c.type, c.name, c.val, c.val_text, c == c, c == 3, str(c)) for c in one.constants])
field = msgs.Field("a", "int8[3]")
print(
    field.name, field.type, field.base_type, field.is_array, field.array_len, field.is_header, field.is_builtin, field
)
t("wrong", lambda: srvs.SrvSpec(None, None, ""))
print(issubclass(srvs.SrvSpecException, Exception), issubclass(msgs.MsgSpecException, Exception))
for package, name in (("std_msgs", "String"), ("std_msgs", "No"), ("nobody", "No")):
    t("msg_file", lambda: msgs.msg_file(package, name))
    t("srv_file", lambda: srvs.srv_file(package, name))
for package in ("std_srvs", "std_msgs", "nav_msgs"):
    t("messages", lambda: sorted(msgs.list_msg_types(package, False)))
    t("services", lambda: sorted(srvs.list_srv_types(package, False)))
