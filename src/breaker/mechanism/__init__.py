"""The model of a drive: exact travel curves of two masses and two springs, prior and sensor.

Curves come from the matrix exponential, without a step error; touch time, speeds and wipe are
computed from them, and limits judged. Families of drives and the paper's posteriors share it.
"""
