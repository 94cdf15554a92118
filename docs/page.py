"""Draw the picture of the page in the README, from the page itself in Chromium.

    python docs/page.py      # needs Debian's chromium and chromium-driver

It is what `breaker view --example` shows, once the newest visit has been clicked.
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

from tests.browser.chromium import Browser  # noqa: E402

PICTURE = ROOT / "docs" / "page.png"
_SIZE, _COLOURS = (1180, 1060), 64


def main() -> int:
    """Open the page, click, and take the picture."""
    command = [sys.executable, "-m", "breaker", "view", "--example", "--no-browser"]
    with (
        TemporaryDirectory() as name,
        subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as process,
    ):
        browser = Browser(Path(name), _SIZE[0])
        try:
            browser.open(re.search(r"http://\S+", process.stdout.readline())[0])
            for each in ("file", "before"):
                date = {"file": "2026-03-02", "before": "2014-05-12"}[each]
                browser.click(f'input[name="{each}"][value="visit_{date}.csv"]')
            browser.click("#list button")
            browser.find("#html")
            browser.picture(Path(name, "page.png"), _SIZE[1] + 140)
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
