"""A fleet: many breakers of a few types, each answered alone, then compared with its type and
ranked.
"""
