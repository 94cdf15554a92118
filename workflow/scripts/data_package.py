"""Describe the tables of a run, file by file and column by column."""

import json
from pathlib import Path

from breaker.common.data_package import DescribedTable, data_package
from breaker.drive.fleet.fleet_columns import FLEET, TYPES, parameters_of_type
from breaker.drive.life.life_tables import CHANGES, DECISIONS, LIMITS, changes_of_parameters
from breaker.paper.posterior.posterior_tables import EXACTNESS, OPERATIONS
from breaker.paper.validation.quality_tables import QUALITY
from breaker.workflow.jobs import start

log = start(snakemake)
NUMBERS = {"name": "as the texts of the project cite it", "value": "in the unit of its table"}
DESCRIBED = {
    "decisions": ("state of the drive and due work, by operation", DECISIONS),
    "limits": ("state of each limit after the last operation", LIMITS),
    "changes": ("changes that were noticed", CHANGES | changes_of_parameters()),
    "numbers": ("numbers of the run that texts state", NUMBERS),
    "operations": ("posterior of each operation", OPERATIONS),
    "quality": ("calibration and sharpness of posteriors of simulated records", QUALITY),
    "exactness": ("distance of the network from the exact posterior", EXACTNESS),
    "fleet": ("drives of the fleet, the most urgent one first", FLEET | parameters_of_type()),
    "types": ("prior of each type of breaker", TYPES),
}

files, target = snakemake.input, Path(snakemake.output[0])
tables = []
for name in [each for each in DESCRIBED if each in files.keys()]:  # noqa: SIM118
    title, columns = DESCRIBED[name]
    found = files[name] if not isinstance(files[name], str) else [files[name]]
    tables += [DescribedTable(Path(file), title, columns) for file in found]
found = data_package(target.parent, "Tables of a run of breaker", tables)
log.info(
    "%d tables, %d columns",
    len(tables),
    sum(len(t["schema"]["fields"]) for t in found["resources"]),
)
target.write_text(json.dumps(found, indent=1, ensure_ascii=False) + "\n", encoding="utf-8")
