"""The configuration: merged from files, checked against schema and conditions, and explained.

Every command and every job of the workflow reads it, so nothing heavy is imported here.
"""
