"""The curve files of a folder and their operation numbers. Light to import."""

import re
from pathlib import Path

from breaker.records.manifest import Operation

__all__ = ["csv_files", "list_curves", "operation_number"]


def csv_files(folder: str | Path) -> list[Path]:
    """List the CSV files of a folder by name, ending in any case, without hidden files.

    The list is empty if there is no such folder.
    """
    if not Path(folder).is_dir():
        return []
    return sorted(
        file
        for file in Path(folder).iterdir()
        if file.suffix.lower() == ".csv" and not file.name.startswith(".")
    )


def operation_number(file: str | Path) -> int:
    """Return the number of the operation in a file, the last whole number in the file's name.

    Raises:
        ValueError: If the name has no number.
    """
    numbers = re.findall(r"\d+", Path(file).stem)
    if not numbers:
        raise ValueError(
            f"{file}: the name has no number, so it does not say which operation it is; rename it, "
            "to operation_0001.csv for example"
        )
    return int(numbers[-1])


def list_curves(folder: str | Path) -> list[Operation]:
    """List the curve files of one motion, ``folder/*.csv``, in the order of their operations.

    Raises:
        FileNotFoundError: If there is no such folder or no CSV file in it.
        ValueError: If a name has no number, or two files have the same one.
    """
    files = csv_files(folder)
    if not files:
        raise FileNotFoundError(
            f"{folder} has no CSV file: endurance.curves must name a folder with a subfolder of "
            "curve files for each motion"
        )
    listed: dict[int, Path] = {}
    for file in files:
        number = operation_number(file)
        if number in listed:
            raise ValueError(
                f"{file} and {listed[number]} are both operation {number}; rename one of them"
            )
        listed[number] = file
    return [Operation(number, listed[number]) for number in sorted(listed)]
