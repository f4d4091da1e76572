"""The pages of web_video_server (no I/O)."""

from __future__ import annotations

from collections.abc import Iterable
from html import escape
from urllib.parse import quote

from pyros1.web.web_video_server.video_options import VIDEO_TYPES

_CAMERA_INFO = "/camera_info"
_PAGE = """<!DOCTYPE html>
<html><head><meta charset='utf-8'><title>{title}</title><link rel='icon' href='data:,'></head><body>{body}</body></html>
"""


def list_page(image_topics: Iterable[str], camera_info_topics: Iterable[str]) -> str:
    """Return the page with links to all images.

    Args:
        image_topics: the topics with images.
        camera_info_topics: the CameraInfo topics, which determine the cameras by which the images are grouped.
    """
    remaining = sorted(image_topics)
    groups = ""
    for info_topic in sorted(camera_info_topics):
        camera = info_topic.removesuffix(_CAMERA_INFO) + "/"
        topics = [topic for topic in remaining if topic.startswith(camera)] if info_topic != camera[:-1] else []
        remaining = [topic for topic in remaining if topic not in topics]
        if topics:
            links = "".join(_links(topic, topic.removeprefix(camera)) for topic in topics)
            groups += f"<li>{escape(camera)}<ul>{links}</ul></li>"
    groups += "".join(_links(topic, topic) for topic in remaining)
    title = "Images of this robot"
    return _PAGE.format(title=title, body=f"<h1>{title}</h1><ul>{groups or '<li>none</li>'}</ul>")


def viewer_page(topic: str, query: str, stream_type: str = "mjpeg") -> str:
    """Return the page that shows a stream.

    Args:
        topic: the stream's topic.
        query: the query of the stream's URL.
        stream_type: the stream's type.
    """
    source = f'src="/stream?{escape(query)}"'
    # Browsers autoplay only muted videos.
    element = f"<video autoplay muted playsinline {source}></video>"
    body = element if stream_type in VIDEO_TYPES else f'<img alt="" {source}>'
    return _PAGE.format(title=escape(topic), body=f"<h1>{escape(topic)}</h1>{body}")


def _links(topic: str, shown: str) -> str:
    urls = ((f"/{path}?topic={quote(topic)}", text) for path, text in (("stream", "Stream"), ("snapshot", "Snapshot")))
    others = " ".join(f'(<a href="{url}">{text}</a>)' for url, text in urls)
    return f'<li><a href="/stream_viewer?topic={quote(topic)}">{escape(shown)}</a> {others}</li>'
