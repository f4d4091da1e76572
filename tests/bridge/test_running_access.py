"""Three sites with keys that run: what one of them may serve and call is limited where it connects."""

from __future__ import annotations

import json
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from pyros1.bridge.parameters import (
    PARAMETER_SERVICE,
    ParameterRequest,
    decode_parameter_response,
    encode_parameter_request,
)
from pyros1.bridge.rules.parsing import parse_config
from pyros1.bridge.service_ends import PARAMETERS_CLASS
from pyros1.ground.errors import ServiceError
from pyros1.msgs import AnyMsg
from pyros1.msgs.std_srvs.srv import Trigger

from .conftest import RunningSite, wait_until
from .test_running_services import has_service

pytest.importorskip("zenoh")
pytest.importorskip("cryptography")
EVERYTHING = """
serve: [/add, /other]
params: [/shared]
call: [{service: '*:/other', timeout: 1}, '*:**']
"""
LIMITS = """
sites:
  red: {serve: [/add], call: ['base:/add', 'base:/pyros1_bridge/parameters']}
  green: {deny_call: ['base:/other']}
"""
MakeSite = Callable[..., RunningSite]


@pytest.fixture
def make_site_with_keys(tmp_path: Path, endpoint: str) -> Iterator[MakeSite]:
    """Return a function that starts a site by its name, and what its file says. The base listens."""
    from pyros1.bridge.transport.access_control import security_settings
    from pyros1.bridge.transport.certificates import load_keys, make_keys
    from pyros1.bridge.transport.zenoh_link import ZenohLink

    make_keys(tmp_path / "keys", {"red": [], "green": [], "base": ["127.0.0.1"]})
    endpoints = (endpoint.replace("tcp/", "tls/"),)
    sites: list[RunningSite] = []

    def make(name: str, rules: str) -> RunningSite:
        access = parse_config(rules, "rules.yaml", name).rules.access
        settings = security_settings(load_keys(tmp_path / "keys" / name), access, name)
        connect, listen = ((), endpoints) if name == "base" else (endpoints, ())
        sites.append(
            RunningSite(name, rules, tmp_path, lambda receive: ZenohLink(name, receive, connect, listen, settings))
        )
        return sites[-1]

    yield make
    for site in reversed(sites):
        site.close()


def ask(site: RunningSite, other: str) -> object:
    """Return a parameter of another site, or the error."""
    client = site.node.service(f"/bridge_{site.name}/{PARAMETER_SERVICE}", PARAMETERS_CLASS)
    try:
        return decode_parameter_response(
            client(AnyMsg(encode_parameter_request(ParameterRequest(other, "/shared"))))._buff
        )
    except ServiceError as error:
        return str(error)


def services_of(site: RunningSite, other: str) -> dict[str, str]:
    """Return the services of another site that a site knows of, each with the reason why it is not provided here."""
    called = json.loads(site.bridge.status())["called"]
    return {each["service"]: each["state"] for each in called if each["service"].startswith(f"{other}:")}


@pytest.mark.slow
def test_a_site_that_is_limited_serves_and_calls_what_it_may(make_site_with_keys: MakeSite) -> None:
    """Everything else is refused where a rule says so, and gets no answer through that site."""
    base = make_site_with_keys("base", EVERYTHING + LIMITS)
    red, green = (make_site_with_keys(name, EVERYTHING) for name in ("red", "green"))
    for site in (base, red, green):
        site.node.master.set_param("/shared", site.name)
        for name in ("/add", "/other"):
            site.node.advertise_service(name, Trigger, lambda _, name=site.name: (True, name))
    for site, other in ((base, red), (red, base), (green, red), (base, green), (green, base)):
        has_service(site, f"/{other.name}/add")
        assert site.node.service(f"/{other.name}/add", Trigger)().message == other.name

    wait_until(lambda: "red:/other" in services_of(base, "red"), "base knows of red's services")
    assert services_of(base, "red") == {"red:/add": "", "red:/other": "red may not serve it"}
    assert services_of(red, "base") == services_of(green, "base") == {"base:/add": ""}, "no others are offered"
    assert services_of(base, "green") == {"green:/add": "", "green:/other": ""}
    for site, other in ((green, red), (red, green)):  # they do not know what the base lets through
        has_service(site, f"/{other.name}/other")
        with pytest.raises(ServiceError, match=f"{other.name}:/other has not answered in time"):
            site.node.service(f"/{other.name}/other", Trigger)()

    wait_until(lambda: ask(red, "base") == "base", "red reads a parameter of the base")
    wait_until(lambda: ask(green, "base") == "base", "green reads a parameter of the base")
    assert "`sites` here does not allow red:/pyros1_bridge/parameters" in str(ask(base, "red"))
