"""All fuzzers by name."""

from __future__ import annotations

from . import files, texts, web, wire

FUZZERS = {**wire.FUZZERS, **texts.FUZZERS, **files.FUZZERS, **web.FUZZERS}
