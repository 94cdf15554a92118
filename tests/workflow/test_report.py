"""Every caption can be filled in from the configuration and is valid reStructuredText."""

from pathlib import Path
from types import SimpleNamespace

import jinja2
import pytest
from docutils.core import publish_doctree
from docutils.nodes import paragraph

from breaker.configuration.loading import defaults, of_motion
from breaker.model.parameters import MOTIONS

ROOT = Path(__file__).parents[2]
# Of the drive, from all its motions.
TOGETHER = {"verdict", "health", "remaining_life", "changepoint", "changes"}
TOGETHER |= {*(f"{n}_table" for n in ("decisions", "limits", "changes", "fleet"))}
PAGES = {
    path.stem: path
    for wing in ("workflow", "studies")
    for path in sorted((ROOT / wing / "report").glob("*.rst"))
}


def filled_in(page, motion, curves):
    """Fill in a page as the report does; a key that is missing raises."""
    config = defaults()
    config["endurance"]["curves"] = curves
    job = SimpleNamespace(config=config)
    if page != "workflow":  # the front page belongs to no job
        own = of_motion(config, motion if motion in MOTIONS else MOTIONS[0])
        job.params = SimpleNamespace(share=0.3, **own)
        job.wildcards = SimpleNamespace(
            motion=motion, source=motion, network="time_series-flow_matching"
        )
    text = PAGES[page].read_text()
    environment = jinja2.Environment(undefined=jinja2.StrictUndefined)
    return environment.from_string(text).render(snakemake=job, files=())


@pytest.mark.parametrize("page", PAGES)
@pytest.mark.parametrize("curves", [None, " my `curves`_*|<b>"])
def test_page_is_valid(page, curves):
    for motion in MOTIONS:
        text = filled_in(page, motion, curves)
        # Warnings raise (halt_level 2), and are told in the exception, not on the screen.
        settings = {"halt_level": 2, "report_level": 5, "_disable_config": True}
        tree = publish_doctree(text, settings_overrides=settings)
        assert len(list(tree.findall(paragraph))) >= 1
        assert page in TOGETHER or motion in text
        assert ("simulated drive" in text) <= (curves is None)
