"""What the columns of the tables of a fleet are."""

FLEET = {
    "breaker": "name of the breaker",
    "phase": "name of the phase",
    "type": "of the breaker: column type of the table, or the nameplate of its last file",
    "state": "unknown, healthy, plan (a service) or now, as of a single drive; not judged, where "
    "no limit tells; measured differently, where visits were, or a stroke has changed",
    "odd": "parameters in which it is unlike its type; empty without any",
    "evidence": "of the most odd one, nats",
    "due": "limit that is due, or the next one",
    "due_date": "date by which to service, or on which the limit is reached",
    "due_operation": "operation by which to service",
    "operations_left": "operations left, median",
    "failed": "limits that are exceeded",
    "last": "date of the last visit",
    "operation": "number of the last operation",
    "records": "records in the table",
    "visits": "visits, from one to the next at least 30 days",
    "change": "largest measured change since the first visit, percent",
    "change_of": "of which quantity",
    "off_type": "how far it is measured off the median of its type, percent",
    "off_type_of": "in which quantity: that which is farthest off beside the spread of the type",
    "how": "life: followed; visits: first and last compared; visit: judged alone; none: not at all",
    "pole_spread": "largest less least time over the phases of the breaker, ms",
    "pole_spread_of": "closing_time or opening_time, from the trigger; travel_time without these",
    "reason": "why it is where it is, what is measured first",
}
"""First columns of ``fleet.csv``, one row for each phase of a breaker; behind them, of each
parameter, the median and 90 % interval under the prior of the type."""
