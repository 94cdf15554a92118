"""What rules and scripts of the workflow share: the start of a job, chunks, and dependencies.

Also which modules a script depends on, so that a change runs the right steps again. Snakemake
imports this room before every job, so it imports torch and numba only when they are used.
"""
