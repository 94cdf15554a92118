"""Damaged files before the reader: ``python -m studies.faults``."""
