"""Figures: prepared data in, a matplotlib figure out; one module per figure or family of figures.

A function computes no statistics, opens no file, and leaves matplotlib's settings unchanged. Write
the result with ``style.save(figure, path)``. Import a function from its module, as in ``from
breaker.figures.pairs import pairs``, so that a change of one figure concerns no other.
"""
