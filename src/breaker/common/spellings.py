"""Names of types and bays, which are spelt in several ways."""

import re
from collections import Counter
from collections.abc import Iterable


def bare(name: str) -> str:
    """Return what all spellings of a name have in common: letters and digits alone, in one case.

    >>> {bare(name) for name in ("GL314", "GL 314", "gl-314")}
    {'gl314'}
    """
    return re.sub(r"[\W_]+", "", name).casefold()


def usual_spelling(names: Iterable[str]) -> dict[str, str]:
    """Return the most frequent spelling of each name, by its bare name; the first of equals.

    >>> usual_spelling(["GL 314", "GL314", "gl-314", "GL314"])
    {'gl314': 'GL314'}
    """
    spelt: dict[str, Counter] = {}
    for name in names:
        spelt.setdefault(bare(name), Counter())[name] += 1
    return {key: counts.most_common(1)[0][0] for key, counts in spelt.items()}
