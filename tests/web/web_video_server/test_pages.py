from __future__ import annotations

from html.parser import HTMLParser

import pytest

from pyros1.web.web_video_server.pages import list_page, viewer_page


class Page(HTMLParser):
    """The links, images and words of a page."""

    def __init__(self, html: str) -> None:
        super().__init__()
        self.links: list[str] = []
        self.images: list[str] = []
        self.videos: list[dict[str, str | None]] = []
        self.tags: set[str] = set()
        self.words: list[str] = []
        self.feed(html)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.add(tag)
        self.links += [value or "" for name, value in attrs if (tag, name) == ("a", "href")]
        self.images += [value or "" for name, value in attrs if (tag, name) == ("img", "src")]
        self.videos += [dict(attrs)] if tag == "video" else []

    def handle_data(self, data: str) -> None:
        self.words += [data.strip()] if data.strip() else []


def test_the_list_groups_topics_by_camera() -> None:
    page = Page(list_page(["/left/image_raw", "/map", "/left/image_rect"], ["/left/camera_info", "/right/camera_info"]))
    assert page.links[:3] == [
        "/stream_viewer?topic=/left/image_raw",
        "/stream?topic=/left/image_raw",
        "/snapshot?topic=/left/image_raw",
    ]
    assert len(page.links) == 9
    shown = [word for word in page.words if "/" in word or "image" in word]
    assert shown == ["/left/", "image_raw", "image_rect", "/map"]
    assert "none" in Page(list_page([], [])).words


def test_names_are_never_markup() -> None:
    wicked = "/<script>alert(1)</script>\"'&"
    for html in (list_page([wicked], []), viewer_page(wicked, f"topic={wicked}"), list_page([wicked], [wicked])):
        assert "script" not in Page(html).tags
    assert Page(viewer_page("/a", f"topic={wicked}")).images == [f"/stream?topic={wicked}"]


@pytest.mark.parametrize("stream_type", ["h264", "vp8", "vp9"])
def test_videos_play_by_themselves(stream_type: str) -> None:
    page = Page(viewer_page("/a", f"topic=/a&type={stream_type}", stream_type))
    (video,) = page.videos
    assert video["src"] == f"/stream?topic=/a&type={stream_type}" and {"autoplay", "muted"} <= set(video)
    assert not page.images and not Page(viewer_page("/a", "topic=/a&type=png", "png")).videos
