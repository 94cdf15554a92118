"""What is told of a drive, by name: parameters, sizes, speeds, and the quantities with limits.

Names, symbols, units and definitions, without a model of a drive: records are measured by them,
and the model evaluated.
"""
