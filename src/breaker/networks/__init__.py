"""Neural networks: summary networks and conditional densities. They know nothing of breakers.

``build`` makes them, and says what each kind has.
"""
