"""The Foxglove WebSocket protocol, version 1, on the port of the page: for Foxglove, Lichtblick and other viewers.

https://github.com/foxglove/ws-protocol/blob/main/docs/spec.md. `requests` and `frames` define the protocol, `machine`
keeps one viewer's state (all pure), `catalogue` has the channels and services for all viewers,
`connection` runs a machine.
"""

PROTOCOLS = ("foxglove.websocket.v1", "foxglove.sdk.v1")
"""The supported WebSocket subprotocols, the preferred one first: servers of Foxglove's SDK use the second name for
the same frames, and their clients may offer no other."""
