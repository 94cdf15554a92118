"""Words of makers for all that stands in an export, by meaning: those of ``lexicon.yaml``.

``word_meanings`` looks them up, and no other module has any.
"""

from pathlib import Path

import yaml


def _words(value: object) -> object:
    """Join the lines of long expressions."""
    if isinstance(value, dict):
        return {key: _words(each) for key, each in value.items()}
    return "|".join(value) if isinstance(value, list) else value


_DATA = yaml.load(
    Path(__file__).with_suffix(".yaml").read_text(encoding="utf-8"),
    Loader=getattr(yaml, "CSafeLoader", yaml.SafeLoader),  # a tenth of the time
)

COLUMNS = _words(_DATA["columns"])
TELLING = _words(_DATA["telling"])
MOTION_WORDS = _words(_DATA["motion_words"])
LETTERS = _words(_DATA["letters"])
FOREIGN_LETTERS = _words(_DATA["foreign_letters"])
SYSTEMS = tuple(_DATA["systems"])
NUMBERED_PHASES = _DATA["numbered_phases"]
COLOURS = tuple(_DATA["colours"])
LABELS = _words(_DATA["labels"])
STATED = _words(_DATA["stated"])
RATE_WORDS = _words(_DATA["rate_words"])
RESULTS = _words(_DATA["results"])
RESULT_HEADS = _words(_DATA["result_heads"])
UNITS = _words(_DATA["units"])
OTHER_UNITS = _DATA["other_units"]
AMPERES = _DATA["amperes"]
NO_UNITS = frozenset(_DATA["no_units"])
RATE_PREFIXES = _DATA["rate_prefixes"]
HERTZ = _DATA["hertz"]
KILOCYCLES = _DATA["kilocycles"]
PER_MS = _DATA["per_ms"]
BEFORE_COLON = _DATA["before_colon"]
BEHIND_NUMBER = _DATA["behind_number"]
SHARE_OF_STROKE = frozenset(_DATA["share_of_stroke"])
MONTHS = _words(_DATA["months"])
MONTH_ENDS = _DATA["month_ends"]
