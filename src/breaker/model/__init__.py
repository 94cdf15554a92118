"""The model of the paper (Secs. 3 and 5): a drive of two masses and two springs, and its sensor.

In reading order: ``parameters`` (names, and the paper's symbols), ``equations`` (what is solved),
``curves`` (exact travel curves and their derivatives) by ``kernels`` (compiled code), ``prior``,
``sensor`` (noise, onset, zero), ``quantities`` (names, units and definitions of quantities of a
curve or record), ``evaluation`` (quantities of exact curves) and ``limits`` (bounds on quantities).
"""
