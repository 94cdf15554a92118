"""The second wing: from measured records to the state of a drive, its life and its fleet.

Networks of families of drives answer, read without torch; only their training needs it.
"""
