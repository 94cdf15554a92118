"""The configuration: classes with all defaults, merged with the user's files, and checked.

All commands and jobs of the workflow import this package, so it imports no slow package.
"""
