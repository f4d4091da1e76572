"""Files that describe distributions of rosbuild's times."""

import os
import tempfile

from rospkg import ResourceNotFound
from rospkg import distro as d

FOLDER = tempfile.mkdtemp()
GOOD = """
release: mydistro
version: "$Revision: 42 $"
_rules:
  hgs: {hg: {uri: "https://a/$STACK_NAME", anon-uri: "http://b/$STACK_NAME", dev-branch: default,
       distro-tag: $RELEASE_NAME, release-tag: $STACK_NAME-$STACK_VERSION}, repo: mine}
stacks:
  _rules:
    svn: {dev: "https://s/$STACK_NAME/trunk", distro-tag: "https://s/$STACK_NAME/$RELEASE_NAME",
          release-tag: "https://s/$STACK_NAME-$STACK_VERSION", anon-dev: "http://s/d", anon-distro-tag: "http://s/t",
          anon-release-tag: "http://s/r"}
  one: {version: 1.0.0}
  two: {version: 2.1.0, _rules: hgs}
  three: {_rules: {git: {uri: u, dev-branch: m, distro-tag: t, release-tag: "$STACK_VERSION"}}}
  four: {version: 4.0.0, _rules: {bzr: {uri: u, dev-branch: m, distro-tag: t, release-tag: r}}}
  five: {version: 5.0.0, _rules: {cvs: {uri: u}}}
  six: {version: 1.2.3, _rules: {svn: {dev: a, distro-tag: b, release-tag: c}}}
variants:
  - base: {stacks: [one]}
  - more: {extends: base, stacks: [two]}
  - all: {extends: [more, base], stacks: [three, four]}
"""
BAD = [
    "[]",
    "a: [",
    "{}",
    "release: x",
    "{release: x, stacks: null}",
    "{release: x, stacks: {a: {}}}",
    "{release: x, stacks: {a: {_rules: no}}}",
    "{release: x, stacks: {a: {_rules: 3}}}",
    "{release: x, version: a_b, stacks: null}",
    "{release: x, version: $Revision$, stacks: null}",
    "{release: x, stacks: {a: {_rules: {git: {uri: u}}}}}",
    "{release: x, stacks: {a: {_rules: {svn: {dev: u}}}}}",
    "{release: x, stacks: null, variants: [a]}",
    "{release: x, stacks: null, variants: [{a: {extends: b}}]}",
]


def t(title, call):
    try:
        print(title, call())
    except Exception as error:
        print(title, type(error).__name__, str(error).replace(FOLDER, "HOME"))


def load(text):
    path = os.path.join(FOLDER, "x.rosdistro")
    with open(path, "w") as file:
        file.write(text)
    return d.load_distro(path)


for stacks, variants in (({}, {}), ({"a": 1}, {})):
    made = d.Distro(stacks, variants, "rel", "ver", {"raw": 1})
    print(made.release_name, made.version, made.raw_data, made.variants)
    t("stacks", lambda: (made.stacks, made.get_stacks(), made.get_stacks(released=True)))
for extends, own, inherited in (([], ["s"], []), (["e"], ["s"], ["i"]), ("e", None, None)):
    variant = d.Variant("n", extends, own, inherited)
    print(variant.name, variant.extends)
    t("stacks", lambda: (variant.stack_names, variant.get_stack_names(True), variant.get_stack_names(implicit=False)))
GIT = {"git": {"uri": "u/$STACK_NAME", "dev-branch": "d", "distro-tag": "t", "release-tag": "$STACK_VERSION"}}
for arguments in (
    ("n", "1.0", "rel", GIT),
    ("n", None, "rel", GIT),
    ("n", "1.0", "rel", {}),
    ("n", "1", "rel", {"x": 1}),
    ("n",),
):
    t("stack", lambda: d.DistroStack(*arguments).name)
    t("stack", lambda: d.DistroStack(*arguments).vcs_config.to_rosinstall("here", "release", True))
distro = load(GOOD)
print(distro.release_name, distro.version, sorted(distro.stacks), sorted(distro.released_stacks))
print(sorted(distro.get_stacks(True)), distro.raw_data["release"])
for name, stack in sorted(distro.stacks.items()):
    config = stack.vcs_config
    print(name, stack.name, stack.version, stack.release_name, stack.repo, type(config).__name__)
    if config is None:
        continue
    print(config.type, config.tarball_url, config.tarball_version)
    for branch in ("devel", "distro", "release", "release-tar", "no"):
        for anonymous in (True, False):
            t(branch, lambda: config.get_branch(branch, anonymous))
            t(branch, lambda: config.to_rosinstall("local", branch, anonymous))
    print(config == load(GOOD).stacks[name].vcs_config, stack == load(GOOD).stacks[name], stack == 3)
    print(config == distro.stacks["one"].vcs_config, config == distro.stacks["four"].vcs_config)
for name, variant in sorted(distro.variants.items()):
    print(name, variant.name, variant.extends, variant.stack_names, variant.get_stack_names(implicit=False))
for variant in (None, "base", "more", "all"):
    for branch in ("devel", "release", "release-tar"):
        entries = (
            str(each)
            for each in d.distro_to_rosinstall(
                load(
                    GOOD.replace("cvs", "git").replace(
                        "uri: u}}", "uri: u, dev-branch: m, distro-tag: t, release-tag: r}}"
                    )
                ),
                branch,
                variant,
                released_only=variant != "all",
            )
        )
        print(variant, branch, sorted(entries))
t(
    "no variant",
    lambda: len(d.distro_to_rosinstall(distro, "devel", variant_name="base", implicit=False, anonymous=False)),
)
for text in BAD:
    t(text, lambda: load(text).version)
try:
    d.load_distro(os.path.join(FOLDER, "none"))
except ResourceNotFound:
    print("not found")
print(issubclass(d.InvalidDistro, Exception), d.distro_uri("x"), d.TARBALL_URI_EVAL, d.TARBALL_VERSION_EVAL)
print(
    d.expand_rule("$STACK_NAME $STACK_VERSION $RELEASE_NAME", "a", None, "c"),
    d.expand_rule("$STACK_VERSION", "a", "1", "c"),
)
print(sorted((name, cls.__name__) for name, cls in d.get_vcs_configs().items()))
config = d.load_vcs_config({"git": {"uri": "u$", "dev-branch": "d", "distro-tag": "t", "release-tag": "r"}}, str.upper)
print(vars(config) == {**vars(config)}, config.repo_uri, config.anon_repo_uri, config.dev_branch, config.distro_tag)
print(d.load_vcs_config({}, str), [cls().type for cls in (d.GitConfig, d.HgConfig, d.BzrConfig, d.SvnConfig)])
for cls in (d.GitConfig, d.SvnConfig):
    t("empty", lambda: cls().get_branch("devel", True))
for config in (d.VcsConfig("x"), d.DvcsConfig("y")):
    t("base", lambda: config.get_branch("release-tar", True))
    t("base", lambda: config.get_branch("devel", True))
for env in ({"ROS_DISTRO": "a"}, {"ROS_ETC_DIR": FOLDER}):
    with open(os.path.join(FOLDER, "distro"), "w") as file:
        file.write(" mine\n")
    print(d.current_distro_codename(env))
