"""Serves Foxglove, Lichtblick and other viewers on the page's port, using the Foxglove WebSocket protocol, version 1.

The protocol is described in https://github.com/foxglove/ws-protocol/blob/main/docs/spec.md. `requests` parses frames
from viewers, `frames` creates frames for them, and `state_machine` keeps one viewer's state (all pure). `catalogue`
keeps the channels and services offered to all viewers, and `connection` drives a state machine over a WebSocket.
"""

PROTOCOLS = ("foxglove.websocket.v1", "foxglove.sdk.v1")
"""The supported WebSocket subprotocols, the preferred one first. Foxglove's SDK uses the second name for the same
frames, and some viewers support only that name."""
