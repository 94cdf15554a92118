"""Figures of the paper and of the training: prepared data in, matplotlib figure out.

Every function draws one motion, computes no statistic, knows no file and leaves matplotlib's
settings as they were. Saving is ``figure.savefig(path)``: size and resolution are the figure's.

    predictive    prior_predictive, posterior_predictive, endurance_predictive
    loss          loss
    validation    sbc, contraction, recovery
    pairs         pairs
    evolution     evolution
    exactness     exactness
    identifiability  identifiability
    networks      networks, missing
    style         what they share

Import from the module, ``from breaker.figures.pairs import pairs``, so that a change of one
figure concerns only those who draw it.
"""
