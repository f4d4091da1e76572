"""The web server: access control, files, connections, the page's protocol, and threads for slow work."""
