"""The joint probability model of a drive and its record, from the mechanism's prior and sensor.

``Model`` evaluates the exact joint density. Banks of simulated curves, the Fisher information of
a record, and the plausibility of a record beside a bank follow from it.
"""
