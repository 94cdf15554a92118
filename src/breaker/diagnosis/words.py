"""The sentences of a diagnosis: ``say(code, **values)``, from the templates in ``words.yaml``."""

from pathlib import Path

from breaker.common.wording import Wording

say = Wording(Path(__file__).with_name("words.yaml")).say
