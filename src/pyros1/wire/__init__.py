"""Bytes to values and back: connection headers, framing, out-queues, handshake rules, HTTP and XML-RPC.

Nothing here reads a socket, a clock or the environment: bytes go in, values and bytes come out.
"""
