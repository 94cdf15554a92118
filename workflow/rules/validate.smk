"""Validation of each posterior on records that were not used in its training.

Needs the model file. Makes the draws of simulated records as Zarr, a table of the quality, and
the figures of the paper's Secs. 5 and 6.
"""

POSTERIOR = config["validation"]["posterior"]
# Files take most of the time, and errors in reading them would be large: with 500 curves, the test
# detects (90 %) a posterior that is shifted by a quarter of its sd or narrower by a fifth.
READER_CURVES = config["validation"]["curves"] // 2


rule figure_prior_predictive:
    """Fig. 3: curves of the prior with curves of the endurance test."""
    input:
        prior="results/prior_predictive/{motion}.zarr",
        curves=every_chunk("results/endurance/{motion}/curves_{chunk}.zarr") if MEASURED else [],
        code=code("figure_prior_predictive"),
    output:
        page(
            "figures/prior_predictive_{motion}.png",
            "1 Simulation",
            "prior predictive",
            "prior_predictive",
        ),
    log:
        "logs/figures/prior_predictive_{motion}.log",
    benchmark:
        "results/benchmarks/figures_prior_predictive_{motion}.tsv"
    conda:
        "../../envs/breaker.yaml"
    script:
        "../scripts/figure_prior_predictive.py"


rule figure_loss:
    """Draw the loss over the training, and the convergence of the solver."""
    input:
        history="results/training/{motion}_history.zarr",
        solver="results/training/{motion}_solver.zarr",
        code=code("figure_loss"),
    output:
        page("figures/loss_{motion}.png", "2 Training", "loss", "loss"),
    log:
        "logs/figures/loss_{motion}.log",
    benchmark:
        "results/benchmarks/figures_loss_{motion}.tsv"
    conda:
        "../../envs/breaker.yaml"
    params:  # for the caption
        network=network_of_motion,
        training=training_of_motion,
    script:
        "../scripts/figure_loss.py"


rule validate:
    """Draw from the posterior of simulated records whose truth is known."""
    input:
        model="results/models/{motion}.safetensors",
        code=code("validate"),
    output:
        directory("results/validation/{motion}_seed{seed}.zarr"),
    log:
        "logs/validate/{motion}_seed{seed}.log",
    benchmark:
        "results/benchmarks/validate_{motion}_seed{seed}.tsv"
    conda:
        "../../envs/breaker.yaml"
    params:
        curves=config["validation"]["curves"],
        draws=config["validation"]["draws"],
    script:
        "../scripts/validate.py"


rule validate_reader:
    """Validate through files: write records in two layouts, read them and infer."""
    input:
        model="results/models/{motion}.safetensors",
        code=code("validate_reader"),
    output:
        directory("results/validation/{motion}_reader_seed{seed}.zarr"),
    log:
        "logs/validate_reader/{motion}_seed{seed}.log",
    benchmark:
        "results/benchmarks/validate_reader_{motion}_seed{seed}.tsv"
    conda:
        "../../envs/breaker.yaml"
    params:
        curves=READER_CURVES,
        draws=config["validation"]["draws"],
    script:
        "../scripts/validate_reader.py"


rule identifiability:
    """Compute the mean contraction of an exact posterior over the prior."""
    input:
        code=code("identifiability"),
    output:
        directory("results/identifiability/{motion}.zarr"),
    log:
        "logs/identifiability/{motion}.log",
    benchmark:
        "results/benchmarks/identifiability_{motion}.tsv"
    conda:
        "../../envs/breaker.yaml"
    params:
        seed=config["seed"],
        curves=config["validation"]["limit_curves"],
        model=MODEL,
        prior=config["prior"],
        sensor=config["sensor"],
    script:
        "../scripts/identifiability.py"


rule quality:
    """Tabulate calibration, z-score, contraction and its limit, one row an output."""
    input:
        validation="results/validation/{motion}_seed{seed}.zarr",
        corrected="results/validation/{motion}_corrected_seed{seed}.zarr",
        reader="results/validation/{motion}_reader_seed{seed}.zarr",
        limit="results/identifiability/{motion}.zarr",
        code=code("quality"),
    output:
        page(
            "results/quality/{motion}_seed{seed}.csv",
            "3 Validation",
            "table of the quality",
            "quality",
        ),
    log:
        "logs/quality/{motion}_seed{seed}.log",
    benchmark:
        "results/benchmarks/quality_{motion}_seed{seed}.tsv"
    conda:
        "../../envs/breaker.yaml"
    script:
        "../scripts/quality.py"


rule figure_validation:
    """Figs. 4 to 7: calibration, z-score against contraction, recovery, and pairs."""
    input:
        validation=validated,
        prior="results/prior_predictive/{motion}.zarr",
        limit="results/identifiability/{motion}.zarr" if EXACT else [],
        code=code("figure_validation"),
    output:
        sbc=page("figures/sbc_{motion}.png", "3 Validation", "calibration", "sbc"),
        contraction=page(
            "figures/contraction_{motion}.png", "3 Validation", "contraction", "contraction"
        ),
        recovery=page("figures/recovery_{motion}.png", "3 Validation", "recovery", "recovery"),
        pairs=page("figures/pairs_{motion}.png", "3 Validation", "pairs", "pairs"),
    log:
        "logs/figures/validation_{motion}.log",
    benchmark:
        "results/benchmarks/figures_validation_{motion}.tsv"
    conda:
        "../../envs/breaker.yaml"
    params:
        subject=f"{POSTERIOR} posterior of simulated records",
    script:
        "../scripts/figure_validation.py"


rule figure_validation_reader:
    """Fig. 4 through curve files: simulation-based calibration."""
    input:
        validation=f"results/validation/{{motion}}_reader_seed{SEED}.zarr",
        code=code("figure_validation"),
    output:
        sbc=page(
            "figures/sbc_reader_{motion}.png",
            "3 Validation",
            "calibration through files",
            "sbc_reader",
        ),
    log:
        "logs/figures/validation_reader_{motion}.log",
    benchmark:
        "results/benchmarks/figures_validation_reader_{motion}.tsv"
    conda:
        "../../envs/breaker.yaml"
    params:
        subject="posterior of simulated records through curve files",
    script:
        "../scripts/figure_validation.py"


rule posterior_predictive:
    """Predict four simulated records from their posteriors."""
    input:
        validation=validated,
        code=code("posterior_predictive"),
    output:
        directory("results/validation/{motion}_predictive.zarr"),
    log:
        "logs/posterior_predictive/{motion}.log",
    benchmark:
        "results/benchmarks/posterior_predictive_{motion}.tsv"
    conda:
        "../../envs/breaker.yaml"
    params:
        seed=config["seed"],
        model=MODEL,
        prior=config["prior"],
        sensor=config["sensor"],
        curves=4,
    script:
        "../scripts/posterior_predictive.py"


rule figure_posterior_predictive:
    """Fig. 8: posterior predictive check on simulated records."""
    input:
        predictive="results/validation/{motion}_predictive.zarr",
        code=code("figure_posterior_predictive"),
    output:
        page(
            "figures/posterior_predictive_{motion}.png",
            "3 Validation",
            "posterior predictive",
            "posterior_predictive",
        ),
    log:
        "logs/figures/posterior_predictive_{motion}.log",
    benchmark:
        "results/benchmarks/figures_posterior_predictive_{motion}.tsv"
    conda:
        "../../envs/breaker.yaml"
    script:
        "../scripts/figure_posterior_predictive.py"


rule second_seed:
    """Judge both motions on a second validation seed, not a part of `all`."""
    input:
        expand(
            "results/quality/{motion}_seed{seed}.csv",
            motion=MOTIONS,
            seed=SEED + 1,
        ),
