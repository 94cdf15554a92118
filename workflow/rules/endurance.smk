"""The endurance test: curves from files, inferred operation by operation.

Needs the model file, and curve files: those of the stand-in, which is simulated here, or a folder
of one's own (`endurance.curves`). Makes draws, intervals and flags of all operations as one Zarr
store and one tidy CSV a motion, and the figures of the paper's Sec. 7.
"""


rule rig:
    """The stand-in's curve files of one motion: a richer mechanism than the model, wearing out."""
    input:
        code=sources("rig.py"),
    output:
        directory("results/rig/curves/{motion}"),
    log:
        "logs/rig/{motion}.log",
    benchmark:
        "results/benchmarks/rig_{motion}.tsv"
    conda:
        ENVIRONMENT
    params:
        seed=config["seed"],
        rig=config["rig"],
    script:
        "../scripts/rig.py"


rule rig_effective:
    """The values of the model's parameters that fit the stand-in's noise-free curves best."""
    input:
        code=sources("rig_effective.py"),
    output:
        directory("results/rig/{motion}_effective.zarr"),
    log:
        "logs/rig_effective/{motion}.log",
    conda:
        ENVIRONMENT
    params:
        seed=config["seed"],
        rig=config["rig"],
        sensor=config["sensor"],
        prior=config["prior"],
    script:
        "../scripts/rig_effective.py"


rule read_curves:
    """Read and check the files of some operations."""
    input:
        unpack(curve_files),
        code=sources("read_curves.py"),
    output:
        directory("results/endurance/{motion}/curves_{chunk}.zarr"),
    log:
        "logs/read_curves/{motion}_{chunk}.log",
    conda:
        ENVIRONMENT
    params:
        folder=curve_folder,
        format=config["endurance"]["format"],
        operations_per_job=config["endurance"]["operations_per_job"],
        grid=time_grid(),
    script:
        "../scripts/read_curves.py"


rule infer:
    """Infer some operations."""
    input:
        model="results/models/{motion}.safetensors",
        curves="results/endurance/{motion}/curves_{chunk}.zarr",
        code=sources("infer.py"),
    output:
        directory("results/endurance/{motion}/inferred_{chunk}.zarr"),
    log:
        "logs/infer/{motion}_{chunk}.log",
    benchmark:
        "results/benchmarks/infer_{motion}_{chunk}.tsv"
    conda:
        ENVIRONMENT
    params:
        seed=config["seed"],
        draws=config["endurance"]["draws"],
        misfit_p_value=config["endurance"]["misfit_p_value"],
    script:
        "../scripts/infer.py"


rule gather:
    """All operations of one motion, as one store and one table."""
    input:
        inferred=inferred_chunks,
        corrected=corrected_chunks,
        code=sources("gather.py"),
    output:
        store=directory("results/endurance/{motion}.zarr"),
        table=report(
            "results/endurance/{motion}.csv",
            caption="../report/endurance_table.rst",
            category="5 Endurance test",
            labels={"figure": "table of all operations", "motion": "{motion}"},
        ),
    log:
        "logs/gather/{motion}.log",
    conda:
        ENVIRONMENT
    script:
        "../scripts/gather.py"


rule endurance_predictive:
    """What the posteriors at a few stages of the life predict for their own records."""
    input:
        inferred="results/endurance/{motion}.zarr",
        code=sources("endurance_predictive.py"),
    output:
        directory("results/endurance/{motion}_predictive.zarr"),
    log:
        "logs/endurance_predictive/{motion}.log",
    conda:
        ENVIRONMENT
    params:
        seed=config["seed"],
        prior=config["prior"],
        sensor=config["sensor"],
        stages=config["endurance"]["stages"],
        posterior=config["endurance"]["posterior"],
    script:
        "../scripts/endurance_predictive.py"


rule figure_endurance_predictive:
    """Fig. 9: posterior predictive check at stages of the life."""
    input:
        predictive="results/endurance/{motion}_predictive.zarr",
        code=sources("figure_endurance_predictive.py"),
    output:
        report(
            "figures/endurance_predictive_{motion}.png",
            caption="../report/endurance_predictive.rst",
            category="5 Endurance test",
            labels={"figure": "posterior predictive", "motion": "{motion}"},
        ),
    log:
        "logs/figures/endurance_predictive_{motion}.log",
    conda:
        ENVIRONMENT
    script:
        "../scripts/figure_endurance_predictive.py"


rule figure_evolution:
    """Fig. 10: the parameters over all operations."""
    input:
        unpack(effective_values),
        inferred="results/endurance/{motion}.zarr",
        code=sources("figure_evolution.py"),
    output:
        report(
            "figures/evolution_{motion}.png",
            caption="../report/evolution.rst",
            category="5 Endurance test",
            labels={"figure": "evolution", "motion": "{motion}"},
        ),
    log:
        "logs/figures/evolution_{motion}.log",
    conda:
        ENVIRONMENT
    params:
        posterior=config["endurance"]["posterior"],
    script:
        "../scripts/figure_evolution.py"
