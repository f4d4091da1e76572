"""A topic with threads that publish, and links that come, go and break meanwhile.

All links see one order; whoever has the greeting gets all that follows; no frame is torn; what is dropped is counted.
"""

from __future__ import annotations

from typing import Any

from pyros1.msgs.geometry_msgs.msg import PointStamped
from pyros1.msgs.std_msgs.msg import UInt64

from ..stage import Scenario, Stage
from .parts import PUBLISHING, THREAD, Reader, check_orders, end_context, make_context, make_publication

THREADS, MESSAGES = 2, 4
LIMITS = (
    ("pyros1.node.strand", "MAX_JOBS_PER_TURN", 2),
    ("pyros1.node.strand", "JOBS_BEFORE_DELAY", 2),
    ("pyros1.node.publishing.tcp_link", "MIN_STREAK", 1),
    ("pyros1.node.publishing.tcp_link", "MAX_BATCH", 3),
    ("pyros1.node.publishing.tcp_link", "MAX_STREAK_GAP", 1e-3),
    ("pyros1.node.publishing.tcp_link", "BATCH_TIME", 100e-6),
    ("pyros1.node.publishing.tcp_link", "MAX_BYTES_PER_TURN", 64),
)


class Publishing(Scenario):
    """One link from the beginning, a slow one that comes later, one that breaks."""

    modules = PUBLISHING
    limits = LIMITS
    room = 40
    queue_size: int | None = 0
    latch = False
    message_class: Any = UInt64
    pause = 0.002

    def message(self, thread: int, number: int) -> Any:
        """Return a message."""
        return UInt64(THREAD * thread + number)

    def play(self, stage: Stage) -> None:
        """Play it."""
        context = make_context(stage, "/talker")
        publication = make_publication(context, self.queue_size, self.latch, self.message_class)
        first, late, broken = (
            Reader(stage),
            Reader(stage, pause=self.pause, size=self.room // 2),
            Reader(stage, most=300),
        )
        readers = stage.spawn(first.read, late.read, broken.read)
        first.link(publication)
        stage.until(lambda: publication.links)
        counted = list(publication.links)

        def publisher(thread: int) -> Any:
            def publish() -> None:
                for number in range(MESSAGES):
                    publication.publish(self.message(thread, number))

            return publish

        def join() -> None:
            broken.link(publication)
            late.link(publication)
            stage.until(lambda: len({id(link) for link in (*publication.links, *counted)}) > 1 or late.data)

        stage.together(join, *(publisher(thread) for thread in range(THREADS)))
        stage.until(lambda: late.data)
        links = publication.links
        publication.close(stage.time.monotonic() + 500.0)
        stage.until(lambda: not publication.links)
        for reader in readers:
            reader.join()
        self.check(first, late, broken, {link: link for link in (*counted, *links)})
        stage.until(lambda: publication.strand.free == [True] and not publication.strand.jobs)
        end_context(context)

    def check(self, first: Reader, late: Reader, broken: Reader, links: dict[Any, Any]) -> None:
        """Check what the readers got."""
        gaps = bool(self.queue_size)
        begin = 0 if self.message_class is UInt64 else 4
        everything = first.numbers(begin)
        others = late.numbers(begin)
        check_orders(everything, MESSAGES, gaps, tail=not gaps)
        check_orders(others, MESSAGES, gaps, tail=not gaps)
        check_orders(broken.numbers(begin, whole=False), gaps=gaps)
        dropped = next(iter(links)).dropped
        assert len(everything) + dropped == THREADS * MESSAGES, f"{everything}, {dropped} dropped"
        assert not others or everything[-1] == others[-1], "the last message is never dropped"
        if not gaps:
            assert everything[len(everything) - len(others) :] == others, f"two orders: {everything}, {others}"
            assert not dropped


class Dropping(Publishing):
    """The same with short queues."""

    queue_size = 2


class Waiting(Publishing):
    """The same with publishers that wait."""

    queue_size = None


class Latching(Publishing):
    """The same with a message for those who come late."""

    latch = True

    def check(self, first: Reader, late: Reader, broken: Reader, links: dict[Any, Any]) -> None:
        """Check that the late one got the last message, at least."""
        super().check(first, late, broken, links)
        assert late.numbers()[-1] == first.numbers()[-1], "a latched topic whose last message differs"


class Numbered(Publishing):
    """The same with headers, which get numbers."""

    message_class = PointStamped
    room = 200

    def message(self, thread: int, number: int) -> Any:
        """Return a message whose number is in its stamp."""
        message = PointStamped()
        message.header.stamp.secs = THREAD * thread + number
        return message

    def check(self, first: Reader, late: Reader, broken: Reader, links: dict[Any, Any]) -> None:
        """Check the numbers, too."""
        mask = (1 << 32) - 1
        first_seqs = [number & mask for number in first.numbers(0)]
        assert first_seqs == list(range(1, THREADS * MESSAGES + 1)), f"numbers {first_seqs}"
        stamps = [number & mask for number in first.numbers(4)]
        check_orders(stamps, MESSAGES)
        late_stamps = [number & mask for number in late.numbers(4)]
        assert stamps[len(stamps) - len(late_stamps) :] == late_stamps, f"two orders: {stamps}, {late_stamps}"


class Joining(Scenario):
    """A subscriber comes while the publisher ends: its link ends, too."""

    modules = ("pyros1.node.publishing.publication", "pyros1.node.publishing.publisher_links")

    def play(self, stage: Stage) -> None:
        """Play it."""
        context = make_context(stage, "/talker")
        publication = make_publication(context, 0)
        reader = Reader(stage)
        reading = stage.spawn(reader.read)
        reader.link(publication)
        publication.close()
        reading[0].join()
        stage.until(lambda: not publication.links)
        end_context(context)


class Ending(Scenario):
    """A publisher ends while another thread works in its strand: its messages arrive, and no frame is torn."""

    modules = (
        "pyros1.node.strand",
        "pyros1.node.publishing.publication",
        "pyros1.node.publishing.publisher_links",
        "pyros1.node.publishing.tcp_link",
    )
    room = 200

    def play(self, stage: Stage) -> None:
        """Play it."""
        context = make_context(stage, "/talker")
        publication = make_publication(context, 0)
        reader = Reader(stage, size=8)
        reading = stage.spawn(reader.read)
        reader.link(publication)
        stage.until(lambda: reader.data and not publication.links[0].waiting)
        stage.network.room = 8

        def publish_and_end() -> None:
            publication.publish(UInt64(0))
            publication.close(stage.time.monotonic() + 500.0)

        stage.together(lambda: publication.publish(UInt64(THREAD)), publish_and_end)
        reading[0].join()
        stage.until(lambda: not publication.links)
        end_context(context)
        assert 0 in reader.numbers(), "lost"


class Closing(Scenario):
    """A publisher ends while subscribers come, and another thread publishes: what it has published arrives."""

    modules = PUBLISHING
    room = 40

    def play(self, stage: Stage) -> None:
        """Play it."""
        context = make_context(stage, "/talker")
        publication = make_publication(context, 0, latch=True)
        first, late = Reader(stage), Reader(stage, size=20)
        readers = stage.spawn(first.read, late.read)
        first.link(publication)
        stage.until(lambda: publication.links)

        def publish_and_end() -> None:
            for number in range(2):
                publication.publish(UInt64(number))
            publication.close(stage.time.monotonic() + 500.0)

        def publish() -> None:
            publication.publish(UInt64(THREAD))

        def join() -> None:
            late.link(publication)
            context.loop.run(lambda: None)

        stage.together(publish_and_end, publish, join)
        stage.until(lambda: not publication.links)
        for reader in readers:
            reader.join()
        end_context(context)
        # The other thread publishes while the publisher ends: its message may come to one of them, both, or none.
        assert [number for number in first.numbers() if number < THREAD] == [0, 1], f"lost: {first.numbers()}"
        assert [number for number in late.numbers() if number < THREAD] in ([], [1], [0, 1]), f"{late.numbers()}"
