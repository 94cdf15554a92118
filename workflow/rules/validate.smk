"""Validation of each posterior on records that its training never saw.

Needs the model file. Makes the draws of simulated records as Zarr, a table of the quality, and
the figures of the paper's Secs. 5 and 6.
"""

# Fig. 3: what the prior holds possible, beside the endurance test.
figure(
    "prior_predictive",
    "1 Simulation",
    prior="results/prior_predictive/{motion}.zarr",
    curves=every_chunk("results/endurance/{motion}/curves_{chunk}.zarr"),
)

# Loss over the training, and the convergence of the solver.
figure(
    "loss",
    "2 Training",
    within="loss",
    history="results/training/{motion}_history.zarr",
    solver="results/training/{motion}_solver.zarr",
)


rule validate:
    """Draw from the posterior of simulated records whose truth is known."""
    input:
        model="results/models/{motion}.safetensors",
    output:
        directory("results/validation/{motion}_seed{seed}.zarr"),
    log:
        "logs/validate/{motion}_seed{seed}.log",
    conda:
        "../../envs/breaker.yaml"
    params:
        curves=config["validation"]["curves"],
        draws=config["validation"]["draws"],
    script:
        "../scripts/validate.py"


rule validate_reader:
    """The same through files: records written in ten layouts, read back, inferred."""
    input:
        model="results/models/{motion}.safetensors",
    output:
        directory("results/validation/{motion}_reader_seed{seed}.zarr"),
    log:
        "logs/validate_reader/{motion}_seed{seed}.log",
    conda:
        "../../envs/breaker.yaml"
    params:
        curves=config["validation"]["curves"],
        draws=config["validation"]["draws"],
    script:
        "../scripts/validate_reader.py"


rule identifiability:
    """The contraction that an exact posterior reaches on average over the prior."""
    output:
        directory("results/identifiability/{motion}.zarr"),
    log:
        "logs/identifiability/{motion}.log",
    conda:
        "../../envs/breaker.yaml"
    params:
        seed=config["seed"],
        curves=config["identifiability"]["curves"],
        prior=config["prior"],
        sensor=config["sensor"],
    script:
        "../scripts/identifiability.py"


rule quality:
    """One row an output: calibration, z-score, contraction beside its limit."""
    input:
        validation="results/validation/{motion}_seed{seed}.zarr",
        corrected="results/validation/{motion}_corrected_seed{seed}.zarr",
        reader="results/validation/{motion}_reader_seed{seed}.zarr",
        limit="results/identifiability/{motion}.zarr",
    output:
        page(
            "results/quality/{motion}_seed{seed}.csv",
            "3 Validation",
            "table of the quality",
            "quality",
        ),
    log:
        "logs/quality/{motion}_seed{seed}.log",
    conda:
        "../../envs/breaker.yaml"
    params:
        prior=config["prior"],
        onset_sd=config["sensor"]["onset_sd"],
    script:
        "../scripts/quality.py"


SUBJECT = f"simulation-based calibration, {config['validation']['posterior']} posterior"

# Fig. 4: simulation-based calibration.
figure(
    "sbc",
    "3 Validation",
    label="calibration",
    by="validation",
    validation=validated,
    params={"shows": "ranks", "words": {"subject": SUBJECT}},
)

# Fig. 4 through curve files: simulation-based calibration.
figure(
    "sbc_reader",
    "3 Validation",
    label="calibration through files",
    by="validation",
    validation=f"results/validation/{{motion}}_reader_seed{SEED}.zarr",
    params={"shows": "ranks", "words": {"subject": "calibration through curve files"}},
)

# Fig. 5: z-score against contraction, with its limit.
figure(
    "contraction",
    "3 Validation",
    by="validation",
    validation=validated,
    limit="results/identifiability/{motion}.zarr",
    params={"shows": "scores", "prior": config["prior"], "onset_sd": config["sensor"]["onset_sd"]},
)

# Fig. 6: what was inferred against the truth.
figure(
    "recovery", "3 Validation", by="validation", validation=validated, params={"shows": "recovery"}
)

# Fig. 7: prior, posterior and truth of one simulated curve, pair by pair.
figure(
    "pairs", "3 Validation", validation=validated, prior="results/prior_predictive/{motion}.zarr"
)


rule posterior_predictive:
    """What the posteriors of four simulated records predict for them."""
    input:
        validation=validated,
    output:
        directory("results/validation/{motion}_predictive.zarr"),
    log:
        "logs/posterior_predictive/{motion}.log",
    conda:
        "../../envs/breaker.yaml"
    params:
        seed=config["seed"],
        prior=config["prior"],
        sensor=config["sensor"],
        curves=4,
    script:
        "../scripts/posterior_predictive.py"


# Fig. 8: posterior predictive check on simulated records.
figure(
    "posterior_predictive",
    "3 Validation",
    within="predictive",
    predictive="results/validation/{motion}_predictive.zarr",
)
