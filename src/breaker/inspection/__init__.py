"""A look before anything is inferred: settings for an unknown record, and what a folder holds.

Here, and only here, it is guessed: what an unknown file looks like becomes a proposal, confirmed by
reading. A folder is read as it would be later, and sorted into what is accepted and what is not.
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach(
    __name__,
    submod_attrs={
        "acceptance": ["check_folder", "checked_text"],
        "bends": ["seen_touch", "speed_along"],
        "channels": ["InspectionError"],
        "contents": ["stated_in"],
        "describing": ["describe_file", "travel_channels"],
        "printed_results": ["differs", "meant_motions", "measured_name", "stated_speeds"],
        "proposals": ["InspectedMotion", "Proposal", "inspect_file"],
        "wording": ["alike", "overlay_of", "report_of"],
    },
)
