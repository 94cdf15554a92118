"""Neural networks: summary networks and conditional densities. They know nothing of breakers.

A summary network maps records ``(n, t)`` to features ``(n, s)``. It has ``freeze``, and
``missing``, the largest share of samples that may be NaN, in training and after. An inference
network has ``loss``, ``sample`` and ``log_prob`` with the shapes of ``FlowMatching``, and
``solves``: whether it takes solver steps. A new kind is one entry
in a table of ``build``.
"""
