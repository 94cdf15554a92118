"""A life in the drive's own curves, followed to decisions.

Records become coordinates in units of the drive's own scatter, which one tracker follows. Tables
hold a record per limit and operation and when to service; words are rendered from the tables.
"""
