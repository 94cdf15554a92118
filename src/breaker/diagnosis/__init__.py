"""Diagnosis of records of a drive, changes between two inspections, and the prior of a type.

Networks of a family of drives infer the parameters of each operation; other quantities are
measured. Limits are judged by both; words, tables and JSON render the result. The prior of a type
comes from records of some of its breakers, each inferred separately.
"""
