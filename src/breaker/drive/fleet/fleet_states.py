"""States of a drive of a fleet: those of one that is followed, and where no limit is told.

A drive is *measured differently* where its visits are, or where its stroke has changed: stops of a
drive hold that to far less, so its transducer was mounted elsewhere, or a ratio changed. Of such a
drive no trend is told. It is *not judged* where nothing says how it stands to any limit, but its
records can be used; without any of these it is *unknown*.
"""

from breaker.drive.life.limit_states import STATES

DIFFERENT = "measured differently"
UNJUDGED = "not judged"
FLEET_STATES = (STATES[0], STATES[1], UNJUDGED, DIFFERENT, *STATES[2:])
"""States of a drive of a fleet, the most urgent last."""
