"""What one call answers: of the records of a drive, of two inspections, and of a type of breaker.

Networks of a family of drives infer the parameters of each operation; all else is measured. Where
limits are given, they are judged by both; words, tables and JSON render the answer. The
prior of a type comes from records of some of its breakers, each fitted by itself.
"""
