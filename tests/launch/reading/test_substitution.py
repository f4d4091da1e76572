"""launch.reading.substitution: values in texts (X70-X73); whole launch files are tested in test_loader."""

from __future__ import annotations

import pytest

from pyros1.ground.errors import LaunchError
from pyros1.launch.reading.substitution import MAX_GROWTH, substitute


class Values:
    """Stands for a launch file."""

    def __init__(self, **args: str) -> None:
        self.given = args

    def env(self, name: str) -> str:
        return f"<env {name}>"

    def optional_env(self, name: str, default: str) -> str:
        return f"<optenv {name}: {default}>"

    def find(self, package: str, path: str) -> str:
        return f"<{package}{path}>"

    def anon(self, identifier: str) -> str:
        return f"<anon {identifier}>"

    def arg(self, name: str) -> str:
        return self.given[name]

    def dirname(self) -> str:
        return "<dirname>"

    def args(self) -> dict[str, str]:
        return self.given


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("plain $ text) $x", "plain $ text) $x"),
        ("$(arg a)", "1"),
        ("x$(arg a)y$(arg b)z", "x1ytwoz"),
        ("$(env HOME) $(optenv A) $(optenv A b c)", "<env HOME> <optenv A: > <optenv A: b c>"),
        ("$(anon n)-$(dirname)", "<anon n>-<dirname>"),
        ("$(find p)/a b $(find q)", "<p/a> b <q>"),
        ("$(find p)/$(arg a).yaml c", "<p/1.yaml> c"),
        ("$() $(arg", "$() $(arg"),
        ("$(eval a + 1)", "2"),
        ("$(eval b + arg('b') + env('X') + optenv('Y', 'z') + dirname())", "twotwo<env X><optenv Y: z><dirname>"),
    ],
)
def test_values(text: str, expected: str) -> None:
    assert substitute(text, Values(a="1", b="two")) == expected


@pytest.mark.parametrize(
    ("text", "reason"),
    [
        ("a $(arg $(arg a)) b", r"Dollar signs '\$' cannot be inside of substitution args \[\$\(arg \$\(arg a\)\]"),
        ("$(arg (a)", r"Invalid left parenthesis '\(' in substitution args"),
        ("$(args a)", r"Unknown substitution command \[args a\].*did you mean 'arg'"),
        ("$( )", "Unknown substitution command"),
        ("x$(eval a)", r"\$\(eval \.\.\.\) must be the whole value"),
        ("$(arg)", r"\$\(arg name\) takes one argument \[arg\]"),
        ("$(env A B)", r"\$\(env name\) takes one argument \[env A B\]"),
        ("$(find a b)", r"\$\(find name\) takes one argument \[find a b\]"),
        ("$(optenv)", "must specify an environment variable"),
    ],
)
def test_what_is_wrong_is_named(text: str, reason: str) -> None:
    with pytest.raises(LaunchError, match=reason):
        substitute(text, Values(a="1"))


@pytest.mark.parametrize("text", ["$(arg a)", "x$(arg a)y", "$(arg b)$(arg a)"])
def test_a_text_may_grow_up_to_a_limit(text: str) -> None:
    room = MAX_GROWTH + len(text)
    assert len(substitute(text, Values(a="a" * room, b=""))) >= room
    with pytest.raises(LaunchError, match=f"add more than {MAX_GROWTH} characters"):
        substitute(text, Values(a="a" * (room + 1), b=""))
