"""A life in the drive's own curves, followed to decisions.

Records become coordinates in units of the drive's own scatter; one tracker follows these and
whatever is measured; networks of a family read off what has changed since new. From the followed
life come one record per limit and operation and, by when to service, a decision; tables hold these,
and words are rendered from the tables.
"""
