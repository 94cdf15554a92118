"""The model of a drive: exact travel curves of two masses and two springs, prior, sensor and
limits.
"""
