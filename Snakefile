"""The workflow for a command in the project's folder; also with the profile beside this file."""


include: "workflow/Snakefile"
