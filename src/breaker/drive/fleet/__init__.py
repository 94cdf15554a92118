"""A fleet: many breakers of a few types, each answered as one alone is, and set side by side.

Each breaker's records are inferred and compared, or its life is followed. What breakers of a type
have in common is learned from all of them, so that an odd one stands out; and all are ranked by
what is due.
"""
