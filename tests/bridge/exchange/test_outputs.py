"""What a bridge publishes on its own master."""

from __future__ import annotations

from pyros1.bridge.exchange.actions import Advertise, Forget, SetOrigins, Source, Withdraw
from pyros1.bridge.exchange.outputs import Candidate, Output, Outputs, choose
from pyros1.bridge.names import SharedName

STRING = Output("std_msgs/String", "1" * 32, "string data", False)
INT = Output("std_msgs/Int64", "2" * 32, "int64 data", False)
LATCHED = STRING._replace(latched=True)
RED, BLUE = ("red", SharedName("red", "/t")), ("blue", SharedName("blue", "/t"))


def test_the_first_decides_about_the_type() -> None:
    outputs, refused = choose([Candidate("/t", RED, STRING), Candidate("/t", BLUE, INT), Candidate("/u", BLUE, INT)])
    assert outputs == {"/t": STRING, "/u": INT}
    assert refused == {BLUE: "/t is already a std_msgs/String, not a std_msgs/Int64"}
    assert choose([Candidate("/t", RED, None), Candidate("/t", BLUE, INT)]) == ({"/t": INT}, {})
    assert choose([Candidate("/t", RED, STRING), Candidate("/t", BLUE, LATCHED)]) == ({"/t": LATCHED}, {})


def test_changes() -> None:
    outputs = Outputs()
    assert outputs.update({"/t": STRING, "/u": INT}, {}) == [Advertise("/t", *STRING), Advertise("/u", *INT)]
    assert "/t" in outputs and not outputs.is_latched("/t") and not outputs.is_latched("/x")
    assert outputs.changed({"/t": INT}) == {"/t", "/u"}
    assert outputs.update({"/t": INT}, {}) == [Withdraw("/t"), Withdraw("/u"), Advertise("/t", *INT)]


def test_a_topic_that_becomes_latched_is_not_withdrawn() -> None:
    outputs = Outputs()
    outputs.update({"/t": STRING}, {})
    assert outputs.changed({"/t": LATCHED}) == set()
    assert outputs.update({"/t": LATCHED}, {}) == [Advertise("/t", *LATCHED)]
    assert outputs.update({"/t": LATCHED}, {}) == [] and outputs.is_latched("/t")
    assert outputs.update({"/t": STRING}, {}) == [Advertise("/t", *STRING)] and not outputs.is_latched("/t")


def test_latched_messages() -> None:
    outputs = Outputs()
    outputs.update({"/t": LATCHED}, {})
    for source in (Source(*RED, 1), Source(*RED, 2), Source(*BLUE, 1)):
        outputs.hold("/t", source)
    assert outputs.forget("/t", Source(*RED, 1)) == [Forget("/t", Source(*RED, 1))]
    assert outputs.forget("/t", Source(*RED, 1)) == [] and outputs.forget("/x", Source(*RED, 1)) == []
    assert outputs.forget_feed("/t", RED) == [Forget("/t", Source(*RED, 2))]
    outputs.update({}, {})
    assert outputs.forget_feed("/t", BLUE) == []


def test_original_publishers() -> None:
    outputs = Outputs()
    assert outputs.update({"/t": STRING}, {"/t": ("red:/a",)}) == [Advertise("/t", *STRING, ("red:/a",))]
    assert outputs.update({"/t": STRING}, {"/t": ("red:/a",)}) == []
    assert outputs.update({"/t": STRING}, {"/t": ("red:/b",)}) == [SetOrigins("/t", ("red:/b",))]
    assert outputs.update({"/t": STRING}, {}) == [SetOrigins("/t", ())]
    assert outputs.update({"/t": LATCHED}, {"/t": ("red:/c",)}) == [Advertise("/t", *LATCHED, ("red:/c",))]
