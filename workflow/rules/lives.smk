"""Change points and remaining life judged on simulated lives, outside of `all`.

Needs the model files of both motions. Goes through the lives in jobs of a few, each life with
generators of its own; an interrupted evaluation goes on with the jobs that are missing.
"""


rule follow_lives:
    """Simulate some lives, infer their records and follow them."""
    input:
        models=expand("results/models/{motion}.safetensors", motion=["closing", "opening"]),
        code=sources("follow_lives.py"),
    output:
        directory("results/lives/seed{seed}/lives_{chunk}.zarr"),
    log:
        "logs/follow_lives/seed{seed}_{chunk}.log",
    benchmark:
        "results/benchmarks/follow_lives_seed{seed}_{chunk}.tsv"
    conda:
        ENVIRONMENT
    params:
        lives={key: config["lives"][key] for key in config["lives"] if key != "seed"},
        wear_model={
            key: config["wear_model"][key]
            for key in config["wear_model"]
            if key not in ("agreement_p_value", "notice", "toward")
        },
    script:
        "../scripts/follow_lives.py"


rule score_lives:
    """Delays, false alarms, coverage and accuracy over all lives, beside raw times."""
    input:
        lives=life_jobs,
        code=sources("score_lives.py"),
    output:
        scores=directory("results/lives/scores_seed{seed}.zarr"),
        table=report(
            "results/lives/scores_seed{seed}.csv",
            caption="../report/prognostics_table.rst",
            category="7 Simulated lives",
            labels={"figure": "table of scores", "motion": "both"},
        ),
    log:
        "logs/score_lives/seed{seed}.log",
    conda:
        ENVIRONMENT
    params:
        toward=config["wear_model"]["toward"],
        settle=config["wear_model"]["settle"],
    script:
        "../scripts/score_lives.py"


rule figure_prognostics:
    """How early changes are found, and how good the remaining life is."""
    input:
        scores=f"results/lives/scores_seed{config['lives']['seed']}.zarr",
        code=sources("figure_prognostics.py"),
    output:
        report(
            "figures/prognostics.png",
            caption="../report/prognostics.rst",
            category="7 Simulated lives",
            labels={"figure": "prognostics", "motion": "both"},
        ),
    log:
        "logs/figures/prognostics.log",
    conda:
        ENVIRONMENT
    script:
        "../scripts/figure_prognostics.py"
