"""A life of a drive: changes since new, limits and decisions.

Needs the records of all operations, and shipped networks. Makes the tables of decisions, limits
and changes, the figures of the life, and the first page of the report.
"""


rule life:
    """Estimate the trend of a drive, its changes, and the prediction for every limit."""
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
        limits=config["limits"],
        speeds=SPEEDS,
        trend=config["trend"],
        endurance={key: config["endurance"][key] for key in ("events", "misfit_p_value")},
        networks=shipped_networks,
    script:
        "../scripts/life.py"


rule decide:
    """Judge limits and decide on services after every operation; write the first page's text."""
    input:
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
        planning=config["planning"],
        advice=advice_of(),
    script:
        "../scripts/decide.py"


rule figures_life:
    """Draw the picture of the first page, and the figures of the life."""
    input:
        words="results/verdict.json",
        life="results/life.zarr",
        standing="results/standing.zarr",
        truth=TRUTH,
        code=code("figures_life"),
    output:
        verdict=page("figures/verdict.png", "0 Verdict", "verdict", "verdict"),
        health=page("figures/health.png", "6 Decisions", "health", "health"),
        changepoint=page("figures/changepoint.png", "6 Decisions", "change points", "changepoint"),
        remaining_life=page(
            "figures/remaining_life.png", "6 Decisions", "remaining life", "remaining_life"
        ),
        changes=page("figures/changes.png", "6 Decisions", "changes", "changes"),
    log:
        "logs/figures/life.log",
    benchmark:
        "results/benchmarks/figures_life.tsv"
    conda:
        "../../envs/breaker.yaml"
    params:
        limits=config["limits"],
        motions=MOTIONS,
        speeds=SPEEDS,
    script:
        "../scripts/figures_life.py"


rule first_page:
    """Write the first page: sentences, the table of limits and the picture."""
    input:
        words="results/verdict.json",
        limits="results/limits.csv",
        figure="figures/verdict.png",
        code=code("first_page"),
    output:
        page("results/first_page.html", "0 Verdict", "first page", "verdict"),
    log:
        "logs/first_page.log",
    benchmark:
        "results/benchmarks/first_page.tsv"
    conda:
        "../../envs/breaker.yaml"
    script:
        "../scripts/first_page.py"
