"""Decisions: alarms on limits, the table of what to do, and the summary on the first page.

Combines the posteriors of single operations with the trends of the drive: one row per operation,
and four sentences on the first page: whether it is healthy, what is wearing, how long it has left,
and how far the model can be trusted.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach(
    __name__,
    submod_attrs={
        "actions": ["ACTIONS"],
        "alarms": ["alarm_table", "first"],
        "changes": ["step_table"],
        "columns": ["ALARMS", "DECISIONS", "read_table"],
        "conditions": ["align", "condition", "usable"],
        "page": ["opening"],
        "series": ["complete", "join", "remaining"],
        "states": ["MAY_BE", "STATES", "health", "judge"],
        "summary": ["verdict"],
        "table": ["dated", "decide"],
        "trust": ["trust_table"],
        "wearing": ["with_measured"],
        "wording": ["about", "in_percent", "span"],
    },
)
