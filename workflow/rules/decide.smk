"""A life in the drive's own curves: what has changed since new, limits, decisions.

Needs the records of all operations, and networks that ship. Makes the tables of decisions, limits
and changes, the figures of the life, and the first page of the report.
"""


rule life:
    """The path of a drive in its own curves, its changes, and what is known of every limit."""
    input:
        **{motion: curves_of(motion) for motion in MOTIONS},
        code=code("life"),
    output:
        directory("results/life.zarr"),
    log:
        "logs/life.log",
    benchmark:
        "results/benchmarks/life.tsv"
    conda:
        "../../envs/breaker.yaml"
    params:
        seed=config["seed"],
        motions=MOTIONS,
        events=lambda wildcards: known()[0],
        conditions=lambda wildcards: known()[1],
        more_events=config["endurance"]["events"],
        limits=config["limits"],
        speeds=SPEEDS,
        wear_model=config["wear_model"],
        misfit_p_value=config["endurance"]["misfit_p_value"],
        networks=shipped_networks,
    script:
        "../scripts/life.py"


rule decide:
    """How the drive stands to its limits, and what to do: every operation, and the first page."""
    input:
        **{motion: curves_of(motion) for motion in MOTIONS},
        life="results/life.zarr",
        code=code("decide"),
    output:
        standing=directory("results/standing.zarr"),
        decisions=page(
            "results/decisions.csv", "0 Verdict", "table of decisions", "decisions_table"
        ),
        limits=page("results/limits.csv", "0 Verdict", "table of limits", "limits_table"),
        changes=page("results/changes.csv", "0 Verdict", "table of changes", "changes_table"),
        words="results/verdict.json",
    log:
        "logs/decide.log",
    benchmark:
        "results/benchmarks/decide.tsv"
    conda:
        "../../envs/breaker.yaml"
    params:
        motions=MOTIONS,
        planning=config["planning"],
        advice=config["advice"],
    script:
        "../scripts/decide.py"


rule figure_verdict:
    """The picture of the first page: how each limit stands."""
    input:
        words="results/verdict.json",
        life="results/life.zarr",
        standing="results/standing.zarr",
        code=code("figure_verdict"),
    output:
        page("figures/verdict.png", "0 Verdict", "verdict", "verdict"),
    log:
        "logs/figures/verdict.log",
    benchmark:
        "results/benchmarks/figures_verdict.tsv"
    conda:
        "../../envs/breaker.yaml"
    script:
        "../scripts/figure_verdict.py"


rule first_page:
    """What the report opens on: sentences, the table of limits and the picture."""
    input:
        words="results/verdict.json",
        figure="figures/verdict.png",
        code=code("first_page"),
    output:
        "results/first_page.html",
    log:
        "logs/first_page.log",
    benchmark:
        "results/benchmarks/first_page.tsv"
    conda:
        "../../envs/breaker.yaml"
    script:
        "../scripts/first_page.py"


rule figure_health:
    """Probability of each limit and its state, over the operations."""
    input:
        life="results/life.zarr",
        standing="results/standing.zarr",
        code=code("figure_health"),
    output:
        page("figures/health.png", "6 Decisions", "health", "health"),
    log:
        "logs/figures/health.log",
    benchmark:
        "results/benchmarks/figures_health.tsv"
    conda:
        "../../envs/breaker.yaml"
    script:
        "../scripts/figure_health.py"


rule figure_service_cost:
    """What a service costs by its operation."""
    input:
        standing="results/standing.zarr",
        code=code("figure_service_cost"),
    output:
        page("figures/service_cost.png", "6 Decisions", "service cost", "service_cost"),
    log:
        "logs/figures/service_cost.log",
    benchmark:
        "results/benchmarks/figures_service_cost.tsv"
    conda:
        "../../envs/breaker.yaml"
    script:
        "../scripts/figure_service_cost.py"


rule figure_changepoint:
    """The path of the wear and its changes."""
    input:
        life="results/life.zarr",
        code=code("figure_changepoint"),
    output:
        page("figures/changepoint.png", "6 Decisions", "change points", "changepoint"),
    log:
        "logs/figures/changepoint.log",
    benchmark:
        "results/benchmarks/figures_changepoint.tsv"
    conda:
        "../../envs/breaker.yaml"
    script:
        "../scripts/figure_changepoint.py"


rule figure_remaining_life:
    """The remaining life of each limit, over the operations."""
    input:
        life="results/life.zarr",
        standing="results/standing.zarr",
        truth=TRUTH,
        code=code("figure_remaining_life"),
    output:
        page("figures/remaining_life.png", "6 Decisions", "remaining life", "remaining_life"),
    log:
        "logs/figures/remaining_life.log",
    benchmark:
        "results/benchmarks/figures_remaining_life.tsv"
    conda:
        "../../envs/breaker.yaml"
    params:
        limits=config["limits"],
        motions=MOTIONS,
        speeds=SPEEDS,
    script:
        "../scripts/figure_remaining_life.py"


rule figure_changes:
    """The changes of the parameters since new."""
    input:
        life="results/life.zarr",
        truth=TRUTH,
        code=code("figure_changes"),
    output:
        page("figures/changes.png", "6 Decisions", "changes", "changes"),
    log:
        "logs/figures/changes.log",
    benchmark:
        "results/benchmarks/figures_changes.tsv"
    conda:
        "../../envs/breaker.yaml"
    script:
        "../scripts/figure_changes.py"
