"""Write the defaults that ship, and a schema, from the two files in which defaults are stated.

Called by ``make defaults``, from the project's folder, after a change of ``config/config.yaml`` or
``config/advanced.yaml``. The package has a file of its own, as a user edits those of the project:
what is compared with the defaults, such as a prior or the example of limits, must not follow.

The schema is for others: editors, and the catalogue of workflows, which shows it as a table.
"""

from functools import reduce
from pathlib import Path
from typing import Any

import yaml

from breaker.configuration.loading import merge, read
from breaker.configuration.schema import derived
from breaker.shipped import DEFAULTS, SCHEMA

__all__ = ["CONFIG", "FOR_OTHERS", "schema", "written"]

CONFIG = (Path("config/advanced.yaml"), Path("config/config.yaml"))
"""Where the defaults are stated, from the project's folder; the second over the first."""

FOR_OTHERS = Path("workflow/schemas/config.schema.yaml")
"""Where the catalogue of workflows looks for a schema, from the project's folder."""

HEAD = "# Made by `make defaults` from config.yaml and advanced.yaml in config/.\n"


class _Whole(yaml.SafeDumper):
    """Writes out what stands in several places, without aliases."""

    def ignore_aliases(self, data: object) -> bool:
        return True


def written() -> str:
    """Return the content of the file that ships."""
    return _dumped(reduce(merge, map(read, CONFIG), {}))


def schema() -> str:
    """Return the content of the schema: that of the package's checks, with every default."""
    settings = reduce(merge, map(read, CONFIG), {})
    head = {"$schema": "https://json-schema.org/draft/2020-12/schema", "title": "breaker"}
    return _dumped(head | _with_defaults(derived(read(SCHEMA), settings), settings))


def _with_defaults(stated: dict[str, Any], default: Any) -> dict[str, Any]:
    """The schema of a setting, or of a section and all that is in it, with defaults."""
    if "properties" not in stated:
        return stated | {"default": default}
    parts = stated["properties"].items()
    return stated | {"properties": {key: _with_defaults(p, default[key]) for key, p in parts}}


def _dumped(content: dict[str, Any]) -> str:
    flow = {"default_flow_style": None, "width": 100}
    return HEAD + yaml.dump(content, Dumper=_Whole, sort_keys=False, **flow)


if __name__ == "__main__":
    for file, text in ((DEFAULTS, written()), (FOR_OTHERS, schema())):
        file.parent.mkdir(exist_ok=True)
        file.write_text(text, encoding="utf-8")
        print(f"written to {file}")
