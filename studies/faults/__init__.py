"""Test the reader on damaged files: ``python -m studies.faults``."""
