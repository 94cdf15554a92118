"""Write a file or a folder so that it appears whole or not at all."""

import os
import secrets
import shutil
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path


@contextmanager
def whole(path: str | Path) -> Iterator[Path]:
    """Yield a hidden name beside a path; what is written there takes its place at the end.

    What a link leads to is replaced. A file keeps its permissions. After any error, such as an
    OSError where it cannot be replaced, what was there stays.
    """
    target = Path(os.path.realpath(path))
    # A name of its own, as that of the target may have the greatest length.
    part, old = (target.with_name(f".{secrets.token_hex(4)}{target.suffix[:10]}") for _ in "12")
    try:
        yield part
        if not part.is_dir():
            with open(part, "r+b") as stream:  # Windows synchronises no file that is only read
                os.fsync(stream.fileno())  # some file systems find out now that they are full
            if target.exists():
                shutil.copymode(target, part)
        elif target.exists():  # a folder takes the place of none but an empty one
            os.rename(target, old)
        os.replace(part, target)
    except BaseException:
        if old.exists():
            os.rename(old, target)
        raise
    finally:
        for each in (part, old):
            if each.is_dir():
                shutil.rmtree(each, ignore_errors=True)
            else:
                each.unlink(missing_ok=True)
