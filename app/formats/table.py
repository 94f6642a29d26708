"""Tables of numbers as text, a row of the map a line: CSV and the like."""

import io

import numpy as np
import pandas

from app.errors import DamagedFileError
from app.height_map import HeightMap, check_size

SEPARATORS = ("\t", ";", ",", None)
"""Tried in this order; the last is any white space. Where it is not a comma, a comma is a decimal point."""


def looks_like_a_table(data: bytes) -> bool:
    """Whether a file begins with a line of two or more numbers."""
    first = data[:10_000].decode("utf-8", errors="replace").lstrip("\ufeff\r\n ").partition("\n")[0]
    cells = first.replace(",", ".").split() if _separator(first) is None else first.split(_separator(first))
    return len(cells) > 1 and all(_is_number(cell.replace(",", ".")) for cell in cells if cell.strip())


def read_table(data: bytes) -> HeightMap:
    """Read a table without header, separated by tabs, semicolons, commas or blanks; empty cells and nan are missing.

    Raises:
        UploadError: one of its subclasses; the message says what to change.
    """
    try:
        text = data.decode("utf-8-sig").strip("\r\n")
        separator = _separator(text.partition("\n")[0])
        if separator != ",":
            text = text.replace(",", ".")
        lines = text.splitlines()
        check_size((len(lines), len(lines[0].split(separator))))
        table = pandas.read_csv(io.StringIO(text), sep=separator or r"\s+", header=None, dtype=np.float64)
    except (ValueError, UnicodeDecodeError) as error:
        raise DamagedFileError(f"The table of heights cannot be read ({error}). Give every line as many numbers.") from error
    values = table.to_numpy()
    return HeightMap(np.where(np.isfinite(values), values, np.nan), "table")


def _separator(line: str) -> str | None:
    return next((separator for separator in SEPARATORS if separator and separator in line), None)


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True
