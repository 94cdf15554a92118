"""A family of simulated drives, and its state and change networks, which need no torch to infer.

``open_network`` reads a network; ``NormalisedRecords`` are records for the networks.
"""
