"""Definitions: genmsg on all messages of Debian's packages."""

import genmsg, os, tempfile, glob
from genmsg import *
from genmsg.msgs import *
from genmsg import msg_loader, gentools, command_line, names


def show(f):
    try:
        r = f()
        return (type(r).__name__, str(r))
    except Exception as e:
        return ("!", type(e).__name__)


share = "/usr/share"
search = {
    p: [os.path.join(share, p, "msg")]
    for p in (
        "std_msgs",
        "geometry_msgs",
        "sensor_msgs",
        "nav_msgs",
        "diagnostic_msgs",
        "actionlib_msgs",
        "trajectory_msgs",
        "visualization_msgs",
        "stereo_msgs",
        "shape_msgs",
        "tf2_msgs",
    )
}
for p in sorted(search):
    for f in sorted(glob.glob(search[p][0] + "/*.msg")):
        n = p + "/" + os.path.basename(f)[:-4]
        c = MsgContext.create_default()
        s = load_msg_by_type(c, n, search)
        d = load_depends(c, s, search)
        print(
            n,
            d,
            c.get_all_depends(n),
            compute_md5(c, s),
            compute_md5_text(c, s),
            len(compute_full_text(c, s)),
            s.fields(),
            s.constants,
            s.has_header(),
            s.full_name,
            s.short_name,
            s.package,
            s.parsed_fields(),
            repr(s),
            [
                (x.name, x.type, x.base_type, x.is_array, x.array_len, x.is_header, x.is_builtin)
                for x in s.parsed_fields()
            ],
            c.get_file(n),
            s == s,
            s != s,
        )
for f in sorted(glob.glob("/usr/share/nav_msgs/srv/*.srv") + glob.glob("/usr/share/sensor_msgs/srv/*.srv")):
    p = f.split("/")[3]
    n = p + "/" + os.path.basename(f)[:-4]
    c = MsgContext.create_default()
    search[p] = ["/usr/share/%s/msg" % p, "/usr/share/%s/srv" % p]
    sp = search
    sp = {p: ["/usr/share/%s/srv" % p]}
    s = load_srv_by_type(c, n, sp)
    d = load_depends(c, s, search)
    print(
        n,
        d,
        compute_md5(c, s),
        repr(s),
        s.full_name,
        s.package,
        s.short_name,
        c.is_registered(n + "Request"),
    )
for t in [
    "int8",
    "int8[]",
    "int8[3]",
    "Header",
    "a/B",
    "a/B[]",
    "a/B[3]",
    "",
    "[",
    "int8[",
    "int8]",
    "int8[x]",
    "a//B",
    "a/B/C",
    " int8",
    "1a",
    "A-b",
    "roslib/Header",
]:
    print(
        repr(t),
        show(lambda: parse_type(t)),
        show(lambda: is_valid_msg_type(t)),
        show(lambda: bare_msg_type(t)),
        show(lambda: resolve_type(t, "p")),
        show(lambda: is_header_type(t)),
        show(lambda: is_builtin(t)),
        show(lambda: is_valid_constant_type(t)),
        show(lambda: is_valid_msg_field_name(t)),
        show(lambda: package_resource_name(t)),
        show(lambda: resource_name_base(t)),
        show(lambda: resource_name_package(t)),
        show(lambda: is_legal_resource_name(t)),
        show(lambda: is_legal_resource_base_name(t)),
        show(lambda: resource_name("q", t)),
        show(lambda: resource_name("q", t, my_pkg="q")),
        show(lambda: names.normalize_package_context(t)),
    )
for x in [
    "int32 x",
    "int32 x\nint32 x",
    "int32",
    "int32 X=3",
    "int32 X = 3 # c",
    "string S=a # b",
    "string S = 'q' ",
    "bool B=True",
    "bool B=1",
    "float32 F=1.5",
    "int8 X=300",
    "uint8 X=-1",
    "a-b x",
    "int32 1x",
    "Header header",
    "Header h",
    "foo/Bar[] b",
    "# only",
    "",
    "int32 x int32 y",
    "time T=3",
    "int32 X=a",
    "float64 F=nan",
]:
    c = MsgContext.create_default()
    print(
        repr(x),
        show(lambda: load_depends(c, msg_loader.load_msg_from_string(c, x, "p/T"), {}) and 0) if "/" not in x else "",
    )
    r = show(lambda: repr(msg_loader.load_msg_from_string(c, x, "p/T")))
    print(r)
    if r[0] != "!":
        s = c.get_registered("p/T")
        print(
            s.constants,
            [(k.type, k.name, k.val, k.val_text, str(k)) for k in s.constants],
            s.text,
            str(s),
            s.has_header(),
        )
for x in ["int32 a\n---\nint32 b", "---", "a\n---", "---\nfoo/Bar x"]:
    c = MsgContext.create_default()
    print(repr(x), show(lambda: repr(msg_loader.load_srv_from_string(c, x, "p/T"))))
c = MsgContext.create_default()
print(
    c.is_registered("time"),
    c.get_registered("time"),
    c.is_registered("x"),
    show(lambda: c.get_registered("x")),
    show(lambda: c.get_depends("x")),
    show(lambda: c.get_all_depends("x")),
    show(lambda: c.get_file("x")),
)
print(
    show(lambda: load_msg_by_type(c, "std_msgs/Nope", search)),
    show(lambda: load_msg_by_type(c, "nope/Nope", search)),
    show(lambda: load_msg_by_type(c, "std_msgs/String", [])),
    show(lambda: load_msg_by_type(c, "Header", search)),
    show(lambda: load_depends(c, 3, search)),
)
print(
    command_line.includepath_to_dict(["a:b", "a:c", "d:e"]),
    show(lambda: gentools.compute_full_type_name("a", "b.msg")),
    show(lambda: gentools.compute_full_type_name("a", "b.srv")),
    show(lambda: gentools.compute_full_type_name("a", "b.txt")),
)
print(
    Constant("int8", "a", 1, "1"),
    repr(Constant("int8", "a", 1, "1")),
    Constant("int8", "a", 1, "1") == Constant("int8", "a", 1, "01"),
    Field("a", "int8[]"),
    show(lambda: MsgSpec(["int8", "int8"], ["a", "a"], [], "t", "p/T")),
    BUILTIN_TYPES,
    PRIMITIVE_TYPES,
    show(lambda: msg_loader.convert_constant_value("int8", "5")),
    show(lambda: msg_loader.convert_constant_value("int8", "500")),
    show(lambda: msg_loader.convert_constant_value("bool", "0")),
    show(lambda: msg_loader.convert_constant_value("float32", "1.5")),
)
