"""Figures: functions from prepared data to a matplotlib figure, in modules by step of the paper.

A function computes no statistics, opens no file, and leaves matplotlib's settings unchanged.
``style.save(figure, path)`` writes its result.
"""
