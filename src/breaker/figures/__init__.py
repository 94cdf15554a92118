"""Figures: prepared data in, a matplotlib figure out; modules by step, in the order of the paper.

A function computes no statistics, opens no file, and leaves matplotlib's settings unchanged. Write
the result with ``style.save(figure, path)``.
"""
