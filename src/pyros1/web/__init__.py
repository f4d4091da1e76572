"""The running robot in a browser: a server for the page and its views."""
