"""Words of makers for all that stands in an export, by meaning: those of ``lexicon.yaml``."""

from pathlib import Path
from typing import Any

import yaml


def _joined(value: Any) -> Any:
    """Join the lines of long expressions."""
    if isinstance(value, dict):
        joined = {k: "|".join(v) if isinstance(v, list) else v for k, v in value.items()}
        return {key: _joined(each) for key, each in joined.items()}
    return value


_LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)  # a tenth of the time
_TEXT = Path(__file__).with_suffix(".yaml").read_text(encoding="utf-8")

WORDS: dict[str, Any] = {k: _joined(v) for k, v in yaml.load(_TEXT, Loader=_LOADER).items()}
"""Words by the keys of the file."""
