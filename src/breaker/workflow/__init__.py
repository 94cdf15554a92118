"""What rules and scripts share: the start of a job, chunks, and the modules a script depends on.

Snakemake imports this before every job, so it imports torch and numba only when they are used.
"""
