"""Checks of posteriors on simulated records whose truth is known.

Ranks of the truth with simultaneous bands, z-scores, contraction and recovery. Arrays go in, arrays
and tables come out; also the table of the numbers that the texts of the project state.
"""
