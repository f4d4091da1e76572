"""Rules about services and parameters from command lines and files, their errors, and what --check says of them."""

from __future__ import annotations

import pytest

from pyros1.bridge.names import SiteNameError
from pyros1.bridge.rules.explanation import explain
from pyros1.bridge.rules.parsing import SiteConfig, parse_config
from pyros1.bridge.rules.rules import Rules
from pyros1.bridge.rules.service_parsing import add_service_words
from pyros1.ground.errors import Error

FILE = """
site: red
prefix: {blue: /far}
serve: [/add, {service: /plan/**, here: /planner/**, sites: [base], timeout: 5}]
deny_serve: /plan/secret
call:
- base:/map
- {service: blue:/spawn, timeout: 0.5}
- {service: '*:/x', here: /y, sites: [base]}
deny_call: ['*:/noise']
params: [/robot_description, '/camera/**']
deny_params: [/camera/password]
"""


def test_a_file_and_the_command_line() -> None:
    rules = add_service_words(
        parse_config(FILE, "f").rules, ["/first", "!/never"], ["blue:**", "!*:/bad"], ["/x", "!/y"]
    )
    services = rules.services
    assert [rule.pattern.text for rule in services.serve] == ["/first", "/add", "/plan/**"]
    assert (services.serve[2].here, services.serve[2].sites, services.serve[2].timeout) == (
        "/planner/**",
        ("base",),
        5.0,
    )
    assert [rule.pattern.text for rule in services.call] == ["blue:**", "base:/map", "blue:/spawn", "*:/x"]
    denied = (services.deny_serve, services.deny_call, services.deny_params)
    assert [[each.text for each in patterns] for patterns in denied] == [
        ["/never", "/plan/secret"],
        ["*:/bad", "*:/noise"],
        ["/y", "/camera/password"],
    ]
    assert [each.text for each in services.params] == ["/x", "/robot_description", "/camera/**"]


@pytest.mark.parametrize(
    ("text", "complaint"),
    [
        ("serve:\n- red:/a", "f.yaml:3: 'red:/a' is another site's, but only services of this site can be named here"),
        ("serve:\n- a", "f.yaml:3: 'a' is not a pattern of services: write /set_map"),
        ("serve:\n- '!/a'", "f.yaml:3: write what is not allowed under deny_serve"),
        ("serve:\n- topic: /a", "f.yaml:3: there is no setting 'topic'; use service, here, sites, timeout"),
        ("serve:\n- here: /a", "f.yaml:3: a rule needs a service"),
        ("serve:\n- service: /a\n  timeout: 0", "f.yaml:4: timeout must be a number above 0"),
        ("serve:\n- service: /a\n  timeout: 86401", "f.yaml:4: timeout must be a number above 0, at most 86400"),
        ("serve:\n- service: /a/**\n  here: /b", "f.yaml:4: `here` must end in /** if the pattern does"),
        ("call:\n- /a", "f.yaml:3: '/a' does not say whose service it is: write red:/name"),
        ("deny_call: [/a]", "f.yaml:2: '/a' does not say whose service it is"),
        ("params:\n- red:/a", "f.yaml:3: 'red:/a' is not a pattern of parameters: write /robot_description"),
        ("params:\n- 5", "f.yaml:3: expected a string"),
    ],
)
def test_errors_say_where(text: str, complaint: str) -> None:
    with pytest.raises(Error) as caught:
        parse_config(f"site: red\n{text}", "f.yaml")
    assert str(caught.value).startswith(complaint)


@pytest.mark.parametrize(
    ("serve", "call", "params"), [("a", "red:/a", "/a"), ("/a", "/a", "/a"), ("/a", "red:/a", "b:/a")]
)
def test_words_that_are_wrong(serve: str, call: str, params: str) -> None:
    with pytest.raises(SiteNameError):
        add_service_words(Rules("red"), [serve], [call], [params])


def test_check_explains() -> None:
    assert [*explain(parse_config(FILE, "f"))][3:] == [
        "lets others call:",
        "  /add, by every site that calls it",
        "  /planner/** as red:/plan/**, by base, at most 5 s for a call",
        "  never /plan/secret",
        "provides services of others:",
        "  /map of base, as /base/map here",
        "  /spawn of blue, as /far/spawn here, at most 0.5 s for a call",
        "  /x of base, as /y here",
        "  never *:/noise",
        "lets others read the parameters:",
        "  /robot_description and all below it",
        "  /camera/**",
        "  never /camera/password",
    ]
    assert len([*explain(SiteConfig(Rules("red")))]) == 3
