"""Decisions: alarms on limits, the table of what to do, and the summary on the first page.

Combines the posteriors of single operations with the trends of the drive: one row per operation,
and three sentences that say whether it is healthy, what is wearing and how long it has left.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach(
    __name__,
    submod_attrs={
        "alarms": ["alarm_table", "first", "raised"],
        "conditions": ["align", "condition", "usable"],
        "scales": ["over_scales", "spread"],
        "series": ["complete", "health", "join", "remaining"],
        "summary": ["verdict"],
        "table": ["STATES", "decide"],
    },
)
