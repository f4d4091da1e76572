"""Statistics of topics, which pyros1 does not publish."""

from pyros1.drop_in.missing import names as _names

_own = "it does not publish /statistics; see pyros1 topic hz, bw and delay"
__getattr__, __dir__ = _names(
    __name__, why=dict.fromkeys(("ConnectionStatisticsLogger", "SubscriberStatisticsLogger"), _own)
)
