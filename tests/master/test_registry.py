"""master.registry: who is registered, and who must be told (M14-M23, M32-M40)."""

from __future__ import annotations

from pyros1.master.registry import Notice, Registry

A, B, C = "http://a:1/", "http://b:2/", "http://c:3/"


def test_m14_m15_each_side_learns_the_other() -> None:
    registry = Registry()
    assert all(notice.is_repeat for notice in registry.register_subscriber("/s", "/t", "*", B))
    assert registry.subscriber_apis("/t") == [B]
    assert registry.register_publisher("/p", "/t", "a/b", A) == [Notice(B, "/s", "publisherUpdate", "/t", ([A],))]
    assert registry.publisher_apis("/t") == [A]


def test_m38_o04_every_change_sends_the_whole_list_even_if_empty() -> None:
    registry = Registry()
    registry.register_subscriber("/s1", "/t", "*", B)
    registry.register_subscriber("/s2", "/t", "*", C)
    registry.register_publisher("/p1", "/t", "a/b", A)
    is_repeat = registry.register_publisher("/p1", "/t", "a/b", A)
    assert [(notice.api, notice.value) for notice in is_repeat] == [(B, ([A],)), (C, ([A],))]
    both = registry.register_publisher("/p2", "/t", "a/b", B)
    assert both[0].value == ([A, B],)
    last = registry.unregister_publisher("/p1", "/t", A)
    assert last is not None
    assert last[0].value == ([B],)
    empty = registry.unregister_publisher("/p2", "/t", B)
    assert empty is not None
    assert empty[0].value == ([],)


def test_m40_a_new_subscriber_is_no_news_for_publishers() -> None:
    registry = Registry()
    registry.register_publisher("/p", "/t", "a/b", A)
    is_repeat = Notice(B, "/s", "publisherUpdate", "/t", ([A],), is_repeat=True)  # what its answer says
    assert registry.register_subscriber("/s", "/t", "a/b", B) == [is_repeat]


def test_m16_o02_unregistering_needs_the_registered_api() -> None:
    registry = Registry()
    registry.register_publisher("/p", "/t", "a/b", A)
    registry.register_subscriber("/s", "/t", "a/b", A)
    assert registry.unregister_publisher("/p", "/t", B) is None
    assert registry.unregister_publisher("/p", "/other", A) is None
    assert registry.unregister_publisher("/x", "/t", A) is None
    assert not registry.unregister_subscriber("/s", "/t", B)
    assert registry.unregister_subscriber("/s", "/t", A)
    assert not registry.unregister_subscriber("/s", "/t", A)
    assert registry.publisher_apis("/t") == [A]


def test_m17_m18_o03_the_last_provider_wins_and_the_first_cannot_remove_it() -> None:
    registry = Registry()
    registry.register_service("/s1", "/add", "rosrpc://h:1", A)
    registry.register_service("/s2", "/add", "rosrpc://h:2", B)
    assert registry.service_uri("/add") == "rosrpc://h:2"
    assert registry.system_state()[2] == [["/add", ["/s2"]]]
    assert not registry.unregister_service("/s1", "/add", "rosrpc://h:1")
    assert not registry.unregister_service("/s2", "/add", "rosrpc://h:1")
    assert registry.service_uri("/add") == "rosrpc://h:2"
    assert registry.unregister_service("/s2", "/add", "rosrpc://h:2")
    assert registry.service_uri("/add") is None
    assert registry.node_api("/s1") is None


def test_m21_m22_o10_topics_and_types() -> None:
    registry = Registry()
    for topic in ("/chat", "/ch/a", "/ch/b"):
        registry.register_publisher("/p", topic, "a/b", A)
    registry.register_subscriber("/s", "/heard", "a/c", B)
    assert registry.published_topics("") == [["/chat", "a/b"], ["/ch/a", "a/b"], ["/ch/b", "a/b"]]
    assert registry.published_topics("/ch") == registry.published_topics("/ch/") == [["/ch/a", "a/b"], ["/ch/b", "a/b"]]
    registry.unregister_publisher("/p", "/chat", A)
    assert ["/chat", "a/b"] not in registry.published_topics("")
    assert registry.topic_types() == [["/chat", "a/b"], ["/ch/a", "a/b"], ["/ch/b", "a/b"], ["/heard", "a/c"]]


def test_m32_m33_types() -> None:
    registry = Registry()

    def known() -> dict[str, str]:
        return {item[0]: item[1] for item in registry.topic_types()}

    registry.register_subscriber("/s", "/t", "*", A)
    assert known() == {}
    registry.register_publisher("/p", "/t", "*", A)
    assert known() == {"/t": "*"}
    registry.register_subscriber("/s", "/t", "a/b", A)
    assert known() == {"/t": "*"}
    registry.register_publisher("/p", "/t", "a/c", A)
    registry.register_publisher("/p", "/t", "*", A)
    assert known() == {"/t": "a/c"}
    registry.register_publisher("/q", "/t", "a/d", B)
    assert known() == {"/t": "a/d"}
    assert registry.publisher_apis("/t") == [A, B]


def test_m23_the_state_is_in_the_order_of_registration() -> None:
    registry = Registry()
    for node in ("/z", "/a", "/m"):
        registry.register_publisher(node, "/t2", "a/b", A)
    registry.register_publisher("/a", "/t1", "a/b", A)
    registry.register_subscriber("/z", "/t1", "a/b", A)
    registry.register_service("/z", "/s", "rosrpc://h:1", A)
    assert registry.system_state() == [
        [["/t2", ["/z", "/a", "/m"]], ["/t1", ["/a"]]],
        [["/t1", ["/z"]]],
        [["/s", ["/z"]]],
    ]


def test_m34_m35_o01_a_namesake_takes_over() -> None:
    registry = Registry()
    registry.register_publisher("/n", "/t", "a/b", A)
    registry.register_subscriber("/n", "/u", "a/b", A)
    registry.register_service("/n", "/s", "rosrpc://h:1", A)
    registry.subscribe_param("/n", "/p", A)
    registry.register_subscriber("/other", "/t", "a/b", C)
    notices = registry.register_subscriber("/n", "/v", "a/b", B)
    assert notices == [
        Notice(A, "/n", "shutdown", "[/n] Reason: new node registered with same name"),
        Notice(C, "/other", "publisherUpdate", "/t", ([],)),
        Notice(B, "/n", "publisherUpdate", "/v", ([],), is_repeat=True),
    ]
    assert registry.node_api("/n") == B
    assert registry.system_state() == [[], [["/t", ["/other"]], ["/v", ["/n"]]], []]
    assert registry.param_subscribers == {}


def test_a_dead_nodes_port_that_another_node_has_now_is_not_told_to_end() -> None:
    registry = Registry()
    registry.register_publisher("/dead", "/t", "a/b", A)
    registry.register_publisher("/guest", "/u", "a/b", A)
    registry.register_subscriber("/other", "/t", "a/b", C)
    notices = registry.register_publisher("/dead", "/t", "a/b", B)
    assert {notice.method for notice in notices} == {"publisherUpdate"}
    assert notices[-1] == Notice(C, "/other", "publisherUpdate", "/t", ([B],))
    assert registry.node_api("/guest") == A


def test_m34_every_kind_of_registration_takes_over() -> None:
    for register in (
        lambda registry, api: registry.register_publisher("/n", "/t", "a/b", api),
        lambda registry, api: registry.register_subscriber("/n", "/t", "a/b", api),
        lambda registry, api: registry.register_service("/n", "/s", "rosrpc://h:1", api),
        lambda registry, api: registry.subscribe_param("/n", "/p", api),
    ):
        registry = Registry()
        register(registry, A)
        assert [notice.method for notice in register(registry, B) if notice.method == "shutdown"] == ["shutdown"]
        assert registry.node_api("/n") == B


def test_a_replaced_node_that_reads_a_parameter_does_not_take_its_name_back() -> None:
    registry = Registry()
    registry.register_publisher("/n", "/t", "a/b", A)
    registry.register_publisher("/n", "/t", "a/b", B)
    assert registry.subscribe_param("/n", "/tcp_keepalive", A) == []
    assert registry.node_api("/n") == B and registry.param_subscribers == {}
    registry.unsubscribe_param("/n", "/tcp_keepalive", A)
    assert registry.subscribe_param("/n", "/tcp_keepalive", B) == []
    assert registry.param_subscribers == {"/tcp_keepalive": {"/n": B}}
    assert registry.register_publisher("/n", "/t", "a/b", A)[0].method == "shutdown", "a new one may have the old port"
    registry.unregister_publisher("/n", "/t", A)
    registry.subscribe_param("/n", "/p", B)
    assert registry.node_api("/n") == B


def test_a_takeover_leaves_a_service_that_another_node_has_taken() -> None:
    registry = Registry()
    registry.register_service("/n", "/s", "rosrpc://h:1", A)
    registry.register_service("/m", "/s", "rosrpc://h:2", B)
    registry.register_publisher("/n", "/t", "a/b", C)
    assert registry.service_uri("/s") == "rosrpc://h:2"


def test_m36_registering_again_changes_nothing() -> None:
    registry = Registry()
    for _ in range(2):
        registry.register_publisher("/n", "/t", "a/b", A)
        registry.register_service("/n", "/s", "rosrpc://h:1", A)
    assert registry.system_state() == [[["/t", ["/n"]]], [], [["/s", ["/n"]]]]


def test_m37_a_node_is_known_as_long_as_it_has_anything() -> None:
    registry = Registry()
    registry.register_publisher("/n", "/t", "a/b", A)
    registry.register_subscriber("/n", "/t", "a/b", A)
    registry.register_service("/n", "/s", "rosrpc://h:1", A)
    registry.subscribe_param("/n", "/p", A)
    registry.unregister_publisher("/n", "/t", A)
    registry.unregister_subscriber("/n", "/t", A)
    registry.unregister_service("/n", "/s", "rosrpc://h:1")
    registry.unsubscribe_param("/n", "/p", B)
    assert registry.node_api("/n") == A
    registry.unsubscribe_param("/n", "/p", A)
    assert registry.node_api("/n") is None
    registry.unsubscribe_param("/n", "/p", A)
