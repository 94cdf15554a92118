"""Nothing in the package needs Linux."""

import ast
import os
from pathlib import Path

import pytest

from breaker.common.atomic_writes import whole

ROOT = Path(__file__).parents[1]
PACKAGE = ROOT / "src" / "breaker"

MODULES = {"crypt", "fcntl", "grp", "posix", "pty", "pwd", "resource", "syslog", "termios", "tty"}
OF_OS = {
    *("fork", "forkpty", "getuid", "geteuid", "getgid", "getpgid", "killpg", "setsid", "mkfifo"),
    *("nice", "uname", "statvfs", "sched_getaffinity", "sched_setaffinity", "wait", "chown"),
    *("O_DIRECTORY", "O_NOFOLLOW", "O_NONBLOCK", "O_CLOEXEC", "getloadavg", "sendfile"),
}
SIGNALS = {"SIGINT", "SIGTERM", "SIG_DFL", "SIG_IGN"}  # that Windows has, too
FOLDERS = ("/dev/", "/proc/", "/tmp", "/etc/", "/usr/", "/var/")


def of_linux(file: str, text: str) -> list[str]:
    """What a file asks for that Windows or macOS lack. ``getattr`` and ``hasattr`` ask first."""
    found = []
    for node in ast.walk(ast.parse(text)):
        match node:
            case ast.Import(names=names):
                found += [f"import {n.name}" for n in names if n.name.split(".")[0] in MODULES]
            case ast.ImportFrom(module=str(module), names=names):
                if module.split(".")[0] in MODULES:
                    found.append(f"import {module}")
                if module in ("os", "signal"):
                    found.append(f"names of {module}, which this test would not see in use")
            case ast.Attribute(value=ast.Name(id="os"), attr=name) if name in OF_OS:
                found.append(f"os.{name}")
            case ast.Attribute(value=ast.Name(id="signal"), attr=name):
                if name.startswith("SIG") and name not in SIGNALS:
                    found.append(f"signal.{name}")
            case ast.Constant(value=str(value)) if value.startswith(FOLDERS):
                found.append(value)
            case ast.Call(func=ast.Attribute(attr="get_context"), args=[ast.Constant("fork")]):
                found.append("processes by fork")
    return [f"{file}: {what}" for what in found]


def test_nothing_in_the_package_needs_linux():
    found = [
        line
        for file in sorted(PACKAGE.rglob("*.py"))
        for line in of_linux(file.relative_to(PACKAGE).as_posix(), file.read_text(encoding="utf-8"))
    ]
    assert found == []


@pytest.mark.parametrize(
    "code",
    [
        "import fcntl",
        "from resource import setrlimit",
        "import os\nos.fork()",
        "import os\nos.open('a', os.O_DIRECTORY)",
        "import signal\nsignal.signal(signal.SIGHUP, print)",
        "open('/dev/null')",
        "from os import fork",
        "import multiprocessing\nmultiprocessing.get_context('fork')",
    ],
)
def test_what_needs_linux_is_found(code):
    assert len(of_linux("a.py", code)) == 1


def test_a_signal_that_is_asked_for_is_no_fault():
    assert of_linux("a.py", "import signal\ngetattr(signal, 'SIGHUP', None)\nsignal.SIGTERM") == []


def test_a_file_is_written_whole_where_only_open_files_for_writing_can_be_synchronised(
    tmp_path, monkeypatch
):
    """As on Windows; and what was there stays read-only where it was."""
    fcntl = pytest.importorskip("fcntl")
    synchronised = []

    def fsync(number):
        assert fcntl.fcntl(number, fcntl.F_GETFL) & os.O_ACCMODE != os.O_RDONLY
        synchronised.append(number)

    monkeypatch.setattr(os, "fsync", fsync)
    file = tmp_path / "a.txt"
    file.write_text("old", encoding="utf-8")
    file.chmod(0o444)
    with whole(file) as part:
        part.write_text("new", encoding="utf-8")
    assert file.read_text(encoding="utf-8") == "new"
    assert file.stat().st_mode & 0o777 == 0o444
    assert len(synchronised) == 1
