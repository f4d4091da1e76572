"""All fuzzers by name."""

from __future__ import annotations

from . import files, scene, sharing, texts, web, wire

FUZZERS = {**wire.FUZZERS, **sharing.FUZZERS, **texts.FUZZERS, **files.FUZZERS, **web.FUZZERS, **scene.FUZZERS}
