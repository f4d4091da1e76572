"""The Foxglove WebSocket protocol, version 1, on the port of the page: for Foxglove, Lichtblick and other viewers.

https://github.com/foxglove/ws-protocol/blob/main/docs/spec.md. `requests` and `frames` are what travels, `machine` is
one viewer's state (all pure), `catalogue` has the channels and services of all viewers, `connection` drives a machine.
"""

PROTOCOLS = ("foxglove.websocket.v1", "foxglove.sdk.v1")
"""The WebSocket subprotocols that are served, the better one first: servers of Foxglove's SDK use the second name for
the same frames, and clients for them may offer no other."""
