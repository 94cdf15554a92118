"""Records as instruments write them: ten dialects, and the files that hold them.

What the package reads, it can write, so that all readers are tried on curves whose truth is known.
"""
