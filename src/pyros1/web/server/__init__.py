"""The server: access control, files, sockets, the page's protocol, and threads for slow work."""
