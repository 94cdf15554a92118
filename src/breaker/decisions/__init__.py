"""From posteriors and trends to what to do: alarms, decisions, and the first page.

How probably each limit is exceeded at single operations, whether both motions agree, one row of
decisions an operation, and the three sentences that a maintenance engineer reads first.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach(
    __name__,
    submod_attrs={
        "alarms": ["alarm_table", "first", "raised"],
        "conditions": ["agreement", "align", "condition", "usable"],
        "summary": ["verdict"],
        "table": ["complete", "health", "join", "remaining"],
    },
)
