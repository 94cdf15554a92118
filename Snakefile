"""The workflow for a command in the project's folder, with the profile beside this file."""


include: "workflow/Snakefile"


rule everything:
    """What `all` makes, for a command without a target: a file that is included has no default."""
    default_target: True
    input:
        rules.all.input,
