"""Packages, metapackages and their manifests: rospkg."""

import os
import tempfile
import warnings

warnings.simplefilter("ignore")
import rospkg
import rospkg.common
import rospkg.environment as env
import rospkg.manifest

HOME = os.path.realpath(tempfile.mkdtemp())
ROOT = os.path.join(HOME, "src")


def clean(value):
    return str(value).replace(HOME, "HOME")


def t(title, call):
    try:
        value = call()
        print(title, type(value).__name__, clean(repr(value)))
    except Exception as error:
        text = clean(error) if isinstance(error.args[0], str) else error.args
        print(title, "raised", [each.__name__ for each in type(error).__mro__[:2]], text)


def put(path, text):
    path = os.path.join(ROOT, path)
    os.makedirs(os.path.dirname(path), exist_ok=True)
    with open(path, "w") as file:
        file.write(text)


NEW = """<?xml version="1.0"?><package format="2"><name>{name}</name><version>1.2.3</version>
<description>Does <b>this</b>
 and that</description><maintainer email="a@b.com">An Na</maintainer><maintainer email="d@e.org">Da Do</maintainer>
<license>BSD</license><license>MIT</license><author email="g@h.net">Gu</author><author>Ha Hu</author>
<url type="bugtracker">http://bugs</url><url>http://home</url><url type="repository">http://repo</url>
{depends}<export>{export}</export></package>"""
OLD = """<package><description brief="Brief">Long <i>text</i></description><author>A, B</author>
<license url="http://l">BSD</license><review status="doc reviewed" notes="some"/><url>http://u</url>
<logo>http://logo</logo><version>0.1</version><versioncontrol type="svn" url="http://svn"/>
<depend package="other_old"/><rosdep name="boost"/><rosdep name="eigen"/>
<platform os="ubuntu" version="9.04" notes="n"/><platform os="mac" version="1"/>
<export><cpp cflags="-I${{prefix}}/include" lflags="-L${{prefix}}"/><roslint/>{export}</export><odd a="1">x</odd></package>"""
put(
    "newer/package.xml",
    NEW.format(
        name="newer",
        depends="<depend>leaf</depend><build_depend>boost</build_depend>",
        export='<rqt plugin="${prefix}/p.xml"/>',
    ),
)
put("leaf/package.xml", NEW.format(name="leaf", depends="", export=""))
put("leaf/src/deep/notes.txt", "")
put("folder/package.xml", NEW.format(name="named_otherwise", depends="<exec_depend>newer</exec_depend>", export=""))
put("meta/package.xml", NEW.format(name="meta", depends="<exec_depend>newer</exec_depend>", export="<metapackage/>"))
put(
    "lost/package.xml",
    NEW.format(name="lost", depends="<depend>lost2</depend><exec_depend>leaf</exec_depend>", export=""),
)
put(
    "old_stack/stack.xml",
    """<stack><description brief="S">Stack</description><author>A</author><license>BSD</license>
<review status="unreviewed" notes=""/><url>http://s</url><version>1.9</version><depend stack="second_stack"/></stack>""",
)
put("second_stack/stack.xml", "<stack><description>b</description><author>A</author><license>B</license></stack>")
put("old_stack/older/manifest.xml", OLD.format(export='<rosdoc config="r.yaml"/>'))
put("old_stack/other_old/manifest.xml", "<package><license>B</license><author>x</author><description/></package>")
put("old_stack/other_old/nodes/run.py", "#!/usr/bin/env python3\n")
put("old_stack/other_old/data/run.py", "no program\n")
put("second_stack/broken/manifest.xml", "<package><license>B")
put(
    "second_stack/needy/manifest.xml",
    """<package><license>B</license><author>x</author><description/>
<depend package="nobody"/></package>""",
)
put("second_stack/CMakeLists.txt", "rosbuild_make_distribution(2.3.4)")
os.chmod(os.path.join(ROOT, "old_stack/other_old/nodes/run.py"), 0o755)
FIELDS = "description brief author license licenses license_url url version status notes is_catkin filename type"


def show(title, read):
    try:
        manifest = read()
    except Exception as error:
        print(title, "raised", type(error).__name__, clean(error))
        return
    print(title, clean([getattr(manifest, field) for field in FIELDS.split()]))
    if not manifest.is_catkin:
        print(title, manifest.depends, [(each.name, each.type) for each in manifest.depends])
        print(title, [each.name for each in manifest.rosdeps])
    print(title, [(str(each), each.os, each.version, each.notes) for each in manifest.platforms])
    print(title, [(each.tag, each.attrs, each.str, each.get("cflags")) for each in manifest.exports])
    print(title, [getattr(each, "tag", getattr(each, "tagName", each)) for each in manifest.unknown_tags])
    for tag, attr in (("cpp", "cflags"), ("rqt", "plugin"), ("cpp", "no")):
        t(title, lambda: manifest.get_export(tag, attr))
        t(title, lambda: manifest.get_export(tag, attr, convert=False))


rospack = rospkg.RosPack([ROOT])  # what packages of catkin need is left out: stock asks rosdep's files for that
for name in ("newer", "leaf", "broken", "nothing"):
    show(name, lambda: rospack.get_manifest(name))
for name in ("older", "other_old"):
    t("rosbuild", lambda: [rospack.get_manifest(name).description, rospack.get_manifest(name).depends])
    t("export", lambda: rospack.get_manifest(name).get_export("cpp", "cflags"))
show("package file", lambda: rospkg.parse_manifest_file(ROOT + "/newer", rospkg.MANIFEST_FILE))
show("with rospack", lambda: rospkg.parse_manifest_file(ROOT + "/newer", rospkg.MANIFEST_FILE, rospack))
show("no file", lambda: rospkg.parse_manifest_file(ROOT + "/no", rospkg.MANIFEST_FILE))
show("wrong file", lambda: rospkg.parse_manifest_file(ROOT + "/old_stack", rospkg.MANIFEST_FILE))
show("empty", lambda: rospkg.Manifest())
show("empty stack", lambda: rospkg.Manifest("stack", "/f", True))
# Packages
print(sorted(rospack.list()), clean(rospack.ros_paths), clean(rospack.get_ros_paths()))
for name in (
    "newer",
    "older",
    "other_old",
    "leaf",
    "named_otherwise",
    "folder",
    "meta",
    "broken",
    "needy",
    "no",
    "lost",
):
    rospack = rospkg.RosPack([ROOT])  # of stock's, one that has met a broken package finds less
    t("path", lambda: rospack.get_path(name))
    for implicit in (True, False) if name in ("older", "other_old", "no", "broken") else ():
        t("depends", lambda: sorted(rospack.get_depends(name, implicit)))
        t("depends_on", lambda: sorted(rospack.get_depends_on(name, implicit)))
        t("rosdeps", lambda: sorted(rospack.get_rosdeps(name, implicit)))
rosstack = rospkg.RosStack([ROOT + "/meta"])
t("path", lambda: rosstack.get_path("meta"))
t("packages_of", lambda: list(rosstack.packages_of("meta")))
t("packages_of", lambda: list(rosstack.packages_of("no")))
t("stack_of", lambda: rospack.stack_of("leaf"))
t("stack_of", lambda: rospack.stack_of("no"))
print(list(rosstack.list()), clean(rosstack.get_ros_paths()))
for manager in (rospack, rosstack):
    t("cache", lambda: manager.get_custom_cache("k"))
    t("cache", lambda: manager.get_custom_cache("k", 3))
    t("set", lambda: manager.set_custom_cache("k", [1]))
    t("cache", lambda: manager.get_custom_cache("k", 3))
    t("None", lambda: manager.get_path(None))
    t("number", lambda: manager.get_path(3))
for kind in (rospkg.RosPack, rospkg.RosStack):
    one = kind.get_instance([ROOT])
    print(one is kind.get_instance([ROOT]), one is kind.get_instance(), one is kind([ROOT]), type(one).__name__)
    print(kind.get_instance() is kind.get_instance(), clean(one.get_ros_paths()), one is kind.get_instance((ROOT,)))
for manifest in (rospkg.MANIFEST_FILE, rospkg.STACK_FILE, rospkg.common.PACKAGE_FILE, "no"):
    for path in (ROOT, ROOT + "/leaf", ROOT + "/old_stack", "/nonexistent"):
        cache = {}
        t("list_by_path", lambda: sorted(rospkg.list_by_path(manifest, path, cache)))
        print(clean(sorted(cache.items())))
cache = {"newer": "/elsewhere"}
print(sorted(rospkg.list_by_path(rospkg.common.PACKAGE_FILE, ROOT, cache)), clean(sorted(cache.items())))
for path in (
    "leaf/src/deep",
    "old_stack/older",
    "old_stack",
    "folder/package.xml",
    "folder",
    "",
    "no/such",
    "leaf/src/deep/notes.txt",
):
    t("package name", lambda: rospkg.get_package_name(os.path.join(ROOT, path)))
t("not found", lambda: str(rospkg.ResourceNotFound("a", ["b", "c"])))
t("not found", lambda: (rospkg.ResourceNotFound("a").ros_paths, rospkg.ResourceNotFound("a").args))
print(rospkg.common.ROS_STACK, rospkg.common.STACK_FILE, rospkg.common.MANIFEST_FILE, rospkg.InvalidManifest.__mro__[1])

# The environment
print(env.ROS_ROOT, env.ROS_LOG_DIR, env.ROS_TEST_RESULTS_DIR, env.ROS_HOME, env.ROS_ETC_DIR, env.ROS_PACKAGE_PATH)
NAMED = dict(
    ROS_ROOT="/r",
    ROS_PACKAGE_PATH="/a:/b",
    ROS_LOG_DIR="/l",
    ROS_TEST_RESULTS_DIR="/t",
    ROS_HOME="/h",
    ROS_ETC_DIR="/e",
)
SPARSE = dict(ROS_HOME="/h")
ODD = dict(
    ROS_ROOT="", ROS_PACKAGE_PATH=":/a::/b/:/a:", ROS_LOG_DIR="", ROS_TEST_RESULTS_DIR="", ROS_HOME="", ROS_ETC_DIR=""
)
for environ in (NAMED, SPARSE, {}):
    for function in (
        env.get_ros_root,
        env.get_log_dir,
        env.get_ros_home,
        env.get_test_results_dir,
        env.get_etc_ros_dir,
    ):
        t(function.__name__, lambda: function(environ))
    t("on_ros_path", lambda: env.on_ros_path("/a/b", environ))
    t("get_ros_package_path", lambda: (env.get_ros_package_path(environ) or "").partition("/usr/share")[0].strip(":"))
for environ in (NAMED, ODD):
    t("get_ros_paths", lambda: [each for each in env.get_ros_paths(environ) if len(each) < 4])
