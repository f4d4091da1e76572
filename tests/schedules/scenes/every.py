"""All scenes, and how large a part of many schedules each gets: those that take little time get more."""

from __future__ import annotations

from ..stage import Scenario
from . import datagrams, journal, lanes, nodes, publishing, sharing, subscribing, threads

SHARES: dict[type[Scenario], int] = {
    lanes.Lanes: 200,
    lanes.RaisingLanes: 400,
    threads.Working: 150,
    threads.Calling: 100,
    threads.Writing: 60,
    threads.Watching: 20,
    threads.Serving: 30,
    publishing.Publishing: 30,
    publishing.Dropping: 30,
    publishing.Waiting: 30,
    publishing.Latching: 30,
    publishing.Numbered: 20,
    publishing.Joining: 150,
    publishing.Ending: 200,
    publishing.Closing: 40,
    subscribing.Subscribing: 30,
    subscribing.Overloaded: 30,
    subscribing.Spinning: 30,
    subscribing.SpinningOverloaded: 30,
    subscribing.Within: 30,
    subscribing.WithinPublisher: 30,
    subscribing.WithinSpinning: 30,
    subscribing.WithinPublisherSpinning: 30,
    subscribing.WithinDropping: 30,
    subscribing.WithinWaiting: 30,
    datagrams.Datagrams: 20,
    datagrams.LeavingDatagrams: 20,
    datagrams.EndingDatagrams: 20,
    sharing.Sharing: 6,
    sharing.SharingDropping: 6,
    sharing.SharingWaiting: 3,
    journal.Journalling: 10,
    journal.JournallingFull: 10,
    nodes.Meeting: 3,
    nodes.MeetingOverTcp: 3,
    nodes.Changing: 3,
    nodes.Succeeding: 2,
    nodes.Restarting: 3,
}
