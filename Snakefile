"""The workflow in the project's folder, with its settings; profiles/default has its options."""


configfile: "config/advanced.yaml"
configfile: "config/config.yaml"


include: "workflow/Snakefile"


rule everything:
    """What `all` makes, for a command without a target: a file that is included has no default."""
    default_target: True
    input:
        rules.all.input,
