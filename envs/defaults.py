"""Write the defaults that ship with the package from the two files in which they are stated.

Called by ``make defaults``, from the project's folder, after a change of ``config/config.yaml`` or
``config/advanced.yaml``. The package has a file of its own, as a user edits those of the project:
what is compared with the defaults, such as a prior or the example of limits, must not follow.
"""

from functools import reduce
from pathlib import Path

import yaml

from breaker.configuration.loading import merge, read
from breaker.shipped import DEFAULTS

__all__ = ["CONFIG", "written"]

CONFIG = (Path("config/advanced.yaml"), Path("config/config.yaml"))
"""Where the defaults are stated, from the project's folder; the second over the first."""

HEAD = "# Made by `make defaults` from config.yaml and advanced.yaml in config/.\n"


class _Whole(yaml.SafeDumper):
    """Writes out what stands in several places, without aliases."""

    def ignore_aliases(self, data: object) -> bool:
        return True


def written() -> str:
    """Return the content of the file that ships."""
    settings = reduce(merge, map(read, CONFIG), {})
    flow = {"default_flow_style": None, "width": 100}
    return HEAD + yaml.dump(settings, Dumper=_Whole, sort_keys=False, **flow)


if __name__ == "__main__":
    DEFAULTS.write_text(written(), encoding="utf-8")
    print(f"written to {DEFAULTS}")
