"""Decisions: limits and alarms, change points, remaining life.

Needs the exact posteriors of all operations. Goes through them in chunks: single operations are
judged by themselves, trends go on from the stored state of the chunk before, so that appended
operations run their own chunk and no other. Makes the table of decisions, the figures of health,
change points and remaining life, and the first page of the report.
"""


rule condition:
    """How probably each limit is exceeded at some operations, each by its own posterior."""
    input:
        **{motion: corrected_of(motion) for motion in MOTIONS},
        code=sources("condition.py"),
    output:
        directory("results/condition/chunk_{chunk}.zarr"),
    log:
        "logs/condition/chunk_{chunk}.log",
    benchmark:
        "results/benchmarks/condition_{chunk}.tsv"
    conda:
        ENVIRONMENT
    params:
        motions=MOTIONS,
        operations=paired_numbers,
        limits=config["limits"],
    script:
        "../scripts/condition.py"


rule trend:
    """The trend of a source through some operations, from the state after those before."""
    input:
        unpack(corrected_of_source),
        state=state_before,
        code=sources("trend.py"),
    output:
        trend=directory("results/trend/{source}/chunk_{chunk}.zarr"),
        state=directory("results/trend/{source}/state_{chunk}.zarr"),
    log:
        "logs/trend/{source}_{chunk}.log",
    benchmark:
        "results/benchmarks/trend_{source}_{chunk}.tsv"
    conda:
        ENVIRONMENT
    params:
        seed=config["seed"],
        motions=MOTIONS,
        operations=paired_numbers,
        limits=config["limits"],
        prior=config["prior"],
        sensor=config["sensor"],
        wear_model=config["wear_model"],
    script:
        "../scripts/trend.py"


rule whole_trend:
    """The trend of a source through all operations, with its changes."""
    input:
        trends=all_chunks("results/trend/{source}/chunk_{chunk}.zarr"),
        medians=medians_of_source,
        code=sources("whole_trend.py"),
    output:
        directory("results/trend/{source}.zarr"),
    log:
        "logs/whole_trend/{source}.log",
    conda:
        ENVIRONMENT
    params:
        wear_model=config["wear_model"],
    script:
        "../scripts/whole_trend.py"


rule decide:
    """What is known, what changed, what to do when: every operation, and the first page."""
    input:
        conditions=all_chunks("results/condition/chunk_{chunk}.zarr"),
        trends=expand("results/trend/{source}.zarr", source=SOURCES),
        curves=expand("results/endurance/{motion}.zarr", motion=MOTIONS),
        effective=effective_of_all,
        code=sources("decide.py"),
    output:
        health=directory("results/health.zarr"),
        remaining=directory("results/remaining.zarr"),
        verdict=directory("results/verdict.zarr"),
        decisions=report(
            "results/decisions.csv",
            caption="../report/decisions_table.rst",
            category="0 Verdict",
            labels={"figure": "table of decisions", "motion": "both"},
        ),
        alarms=report(
            "results/alarms.csv",
            caption="../report/alarms_table.rst",
            category="0 Verdict",
            labels={"figure": "table of alarms", "motion": "both"},
        ),
    log:
        "logs/decide.log",
    conda:
        ENVIRONMENT
    params:
        motions=MOTIONS,
        limits=config["limits"],
        alarm=config["alarm"],
        wear_model=config["wear_model"],
    script:
        "../scripts/decide.py"


rule figure_verdict:
    """The first page: is it healthy, what is wearing, how long has it left."""
    input:
        verdict="results/verdict.zarr",
        code=sources("figure_verdict.py"),
    output:
        report(
            "figures/verdict.png",
            caption="../report/verdict.rst",
            category="0 Verdict",
            labels={"figure": "verdict", "motion": "both"},
        ),
    log:
        "logs/figures/verdict.log",
    conda:
        ENVIRONMENT
    script:
        "../scripts/figure_verdict.py"


rule figure_health:
    """Probability of each limit and its alarms, over the operations."""
    input:
        health="results/health.zarr",
        code=sources("figure_health.py"),
    output:
        report(
            "figures/health.png",
            caption="../report/health.rst",
            category="6 Decisions",
            labels={"figure": "health", "motion": "both"},
        ),
    log:
        "logs/figures/health.log",
    conda:
        ENVIRONMENT
    script:
        "../scripts/figure_health.py"


rule figure_changepoint:
    """The trend of a source and its changes."""
    input:
        unpack(effective_values),
        trend="results/trend/{source}.zarr",
        code=sources("figure_changepoint.py"),
    output:
        report(
            "figures/changepoint_{source}.png",
            caption="../report/changepoint.rst",
            category="6 Decisions",
            labels={"figure": "change points", "motion": "{source}"},
        ),
    log:
        "logs/figures/changepoint_{source}.log",
    conda:
        ENVIRONMENT
    script:
        "../scripts/figure_changepoint.py"


rule figure_remaining_life:
    """The remaining life of each limit, over the operations."""
    input:
        remaining="results/remaining.zarr",
        code=sources("figure_remaining_life.py"),
    output:
        report(
            "figures/remaining_life.png",
            caption="../report/remaining_life.rst",
            category="6 Decisions",
            labels={"figure": "remaining life", "motion": "both"},
        ),
    log:
        "logs/figures/remaining_life.log",
    conda:
        ENVIRONMENT
    script:
        "../scripts/figure_remaining_life.py"
