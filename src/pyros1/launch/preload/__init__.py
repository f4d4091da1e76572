"""Starts Python nodes by forking processes that have already imported pyros1."""
