"""Draw the picture of the page in the README, from the page itself in Chromium.

    python docs/page.py      # needs Debian's chromium and chromium-driver

It is what `breaker view --example` shows of the newest inspection over the earlier one, once a
limit on its speed has been set, which it fails.
"""

import re
import subprocess
import sys
from io import BytesIO
from pathlib import Path
from tempfile import TemporaryDirectory

from PIL import Image

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

from tests.browser.chromium import TAB, Browser  # noqa: E402

PICTURE = ROOT / "docs" / "page.png"
_SIZE, _COLOURS = (1440, 900), 128
_SPEED = 1.3  # m/s: the worn drive has 1.2


def main() -> int:
    """Open the page, click, and take the picture."""
    command = [sys.executable, "-m", "breaker", "view", "--example", "--no-browser"]
    with (
        TemporaryDirectory() as name,
        subprocess.Popen(command, stdout=subprocess.PIPE, text=True, cwd=name) as process,
    ):
        browser = Browser(Path(name), _SIZE)
        try:
            browser.open(re.search(r"http://\S+", process.stdout.readline())[0])
            browser.find("#list:not(:has([data-unseen]))")
            browser.click('a[href^="/inspection?file=visit_2026-03-02.csv"]')
            browser.type('input[aria-label="least closing speed"]', f"{_SPEED}{TAB}")
            browser.find(".banner.fail")
            browser.find("body[data-complete]")
            browser.picture(Path(name, "page.png"))
            content = Path(name, "page.png").read_bytes()
        finally:
            browser.end()
            process.terminate()
    with Image.open(BytesIO(content)) as page:
        page.convert("RGB").quantize(_COLOURS).save(PICTURE, optimize=True)
    print(f"{PICTURE.name}: {PICTURE.stat().st_size / 1000:.0f} kB")
    return 0


if __name__ == "__main__":
    sys.exit(main())
