"""The third wing: the paper's workflow, its posteriors judged exactly on simulated curves.

A joint model of a drive and its record, networks trained on banks of it, and their checks.
"""
