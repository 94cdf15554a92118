"""The page of `breaker view`: a folder of exports in the browser of the same machine, offline.

It computes no number: records are read, inferred and judged by what the commands call, and what a
click sets is a line of configuration, so that the command line repeats it.
"""
