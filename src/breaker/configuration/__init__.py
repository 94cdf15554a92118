"""The configuration: its classes with every default, merged with files of one's own, and checked.

Every command and every job of the workflow reads it, so nothing heavy is imported here.
"""
