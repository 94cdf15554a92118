"""Functions for rules and scripts: start of a job, chunks, and modules that a script depends on.

Snakemake imports this package before every job, so it imports torch and numba only when needed.
"""
