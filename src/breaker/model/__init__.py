"""The model of the drive: parameters, equations, exact curves, prior, sensor and limits.

Everything else computes with it, and it imports nothing of what does.
"""
