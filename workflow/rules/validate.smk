"""Validation of each posterior on records that its training never saw.

Needs the model file. Makes the draws of simulated records as Zarr, a table of the quality, and
the figures of the paper's Secs. 5 and 6.
"""


rule figure_prior_predictive:
    """Fig. 3: what the prior holds possible, beside the endurance test."""
    input:
        prior="results/prior_predictive/{motion}.zarr",
        curves=curve_chunks,
        code=sources("figure_prior_predictive.py"),
    output:
        report(
            "figures/prior_predictive_{motion}.png",
            caption="../report/prior_predictive.rst",
            category="1 Simulation",
            labels={"figure": "prior predictive", "motion": "{motion}"},
        ),
    log:
        "logs/figures/prior_predictive_{motion}.log",
    conda:
        ENVIRONMENT
    script:
        "../scripts/figure_prior_predictive.py"


rule figure_loss:
    """Loss over the training, and the convergence of the solver."""
    input:
        history="results/training/{motion}_history.zarr",
        solver="results/training/{motion}_solver.zarr",
        code=sources("figure_loss.py"),
    output:
        report(
            "figures/loss_{motion}.png",
            caption="../report/loss.rst",
            category="2 Training",
            labels={"figure": "loss", "motion": "{motion}"},
        ),
    log:
        "logs/figures/loss_{motion}.log",
    conda:
        ENVIRONMENT
    script:
        "../scripts/figure_loss.py"


rule validate:
    """Draw from the posterior of simulated records whose truth is known."""
    input:
        model="results/models/{motion}.safetensors",
        code=sources("validate.py"),
    output:
        directory("results/validation/{motion}_seed{seed}.zarr"),
    log:
        "logs/validate/{motion}_seed{seed}.log",
    benchmark:
        "results/benchmarks/validate_{motion}_seed{seed}.tsv"
    conda:
        ENVIRONMENT
    params:
        curves=config["validation"]["curves"],
        draws=config["validation"]["draws"],
    script:
        "../scripts/validate.py"


rule validate_reader:
    """The same through files: records written as CSV, read back, inferred."""
    input:
        model="results/models/{motion}.safetensors",
        code=sources("validate_reader.py"),
    output:
        directory("results/validation/{motion}_reader_seed{seed}.zarr"),
    log:
        "logs/validate_reader/{motion}_seed{seed}.log",
    benchmark:
        "results/benchmarks/validate_reader_{motion}_seed{seed}.tsv"
    conda:
        ENVIRONMENT
    params:
        curves=config["validation"]["curves"],
        draws=config["validation"]["draws"],
    script:
        "../scripts/validate_reader.py"


rule identifiability:
    """The contraction that an exact posterior reaches on average over the prior."""
    input:
        code=sources("identifiability.py"),
    output:
        directory("results/identifiability/{motion}.zarr"),
    log:
        "logs/identifiability/{motion}.log",
    conda:
        ENVIRONMENT
    params:
        seed=config["seed"],
        curves=config["identifiability"]["curves"],
        prior=config["prior"],
        sensor=config["sensor"],
    script:
        "../scripts/identifiability.py"


rule quality:
    """One row an output: calibration, z-score, contraction beside its exact limit."""
    input:
        validation="results/validation/{motion}_seed{seed}.zarr",
        corrected="results/validation/{motion}_corrected_seed{seed}.zarr",
        reader="results/validation/{motion}_reader_seed{seed}.zarr",
        limit="results/identifiability/{motion}.zarr",
        code=sources("quality.py"),
    output:
        report(
            "results/quality/{motion}_seed{seed}.csv",
            caption="../report/quality.rst",
            category="3 Validation",
            labels={"figure": "table of the quality", "motion": "{motion}"},
        ),
    log:
        "logs/quality/{motion}_seed{seed}.log",
    conda:
        ENVIRONMENT
    params:
        prior=config["prior"],
        onset_sd=config["sensor"]["onset_sd"],
    script:
        "../scripts/quality.py"


rule figure_sbc:
    """Fig. 4: simulation-based calibration."""
    input:
        validation=validated,
        code=sources("figure_sbc.py"),
    output:
        report(
            "figures/sbc_{motion}.png",
            caption="../report/sbc.rst",
            category="3 Validation",
            labels={"figure": "calibration", "motion": "{motion}"},
        ),
    log:
        "logs/figures/sbc_{motion}.log",
    conda:
        ENVIRONMENT
    params:
        subject=f"simulation-based calibration, {config['validation']['posterior']} posterior",
    script:
        "../scripts/figure_sbc.py"


use rule figure_sbc as figure_sbc_reader with:
    input:
        validation=f"results/validation/{{motion}}_reader_seed{SEED}.zarr",
        code=sources("figure_sbc.py"),
    output:
        report(
            "figures/sbc_reader_{motion}.png",
            caption="../report/sbc_reader.rst",
            category="3 Validation",
            labels={"figure": "calibration through files", "motion": "{motion}"},
        ),
    log:
        "logs/figures/sbc_reader_{motion}.log",
    params:
        subject="calibration through curve files",


rule figure_contraction:
    """Fig. 5: z-score against contraction, with the exact limit."""
    input:
        validation=validated,
        limit="results/identifiability/{motion}.zarr",
        code=sources("figure_contraction.py"),
    output:
        report(
            "figures/contraction_{motion}.png",
            caption="../report/contraction.rst",
            category="3 Validation",
            labels={"figure": "contraction", "motion": "{motion}"},
        ),
    log:
        "logs/figures/contraction_{motion}.log",
    conda:
        ENVIRONMENT
    params:
        prior=config["prior"],
        onset_sd=config["sensor"]["onset_sd"],
    script:
        "../scripts/figure_contraction.py"


rule figure_recovery:
    """Fig. 6: what was inferred against the truth."""
    input:
        validation=validated,
        code=sources("figure_recovery.py"),
    output:
        report(
            "figures/recovery_{motion}.png",
            caption="../report/recovery.rst",
            category="3 Validation",
            labels={"figure": "recovery", "motion": "{motion}"},
        ),
    log:
        "logs/figures/recovery_{motion}.log",
    conda:
        ENVIRONMENT
    script:
        "../scripts/figure_recovery.py"


rule figure_pairs:
    """Fig. 7: prior, posterior and truth of one simulated curve, pair by pair."""
    input:
        validation=validated,
        prior="results/prior_predictive/{motion}.zarr",
        code=sources("figure_pairs.py"),
    output:
        report(
            "figures/pairs_{motion}.png",
            caption="../report/pairs.rst",
            category="3 Validation",
            labels={"figure": "pairs", "motion": "{motion}"},
        ),
    log:
        "logs/figures/pairs_{motion}.log",
    conda:
        ENVIRONMENT
    script:
        "../scripts/figure_pairs.py"


rule posterior_predictive:
    """What the posteriors of four simulated records predict for them."""
    input:
        validation=validated,
        code=sources("posterior_predictive.py"),
    output:
        directory("results/validation/{motion}_predictive.zarr"),
    log:
        "logs/posterior_predictive/{motion}.log",
    conda:
        ENVIRONMENT
    params:
        seed=config["seed"],
        prior=config["prior"],
        sensor=config["sensor"],
        curves=4,
    script:
        "../scripts/posterior_predictive.py"


rule figure_posterior_predictive:
    """Fig. 8: posterior predictive check on simulated records."""
    input:
        predictive="results/validation/{motion}_predictive.zarr",
        code=sources("figure_posterior_predictive.py"),
    output:
        report(
            "figures/posterior_predictive_{motion}.png",
            caption="../report/posterior_predictive.rst",
            category="3 Validation",
            labels={"figure": "posterior predictive", "motion": "{motion}"},
        ),
    log:
        "logs/figures/posterior_predictive_{motion}.log",
    conda:
        ENVIRONMENT
    script:
        "../scripts/figure_posterior_predictive.py"
