"""Tables of heights as people and programs write them."""

import numpy as np
import pytest

from app.errors import DamagedFileError, ImageTooLargeError
from app.formats.table import looks_like_a_table, read_table

VALUES = np.array([[1.5, -2.0, 3e-9], [4.0, np.nan, 6.25]])


@pytest.mark.parametrize(
    "text",
    [
        "1.5,-2,3e-9\n4,nan,6.25\n",
        "1.5,-2,3e-9\r\n4,,6.25\r\n",
        "1,5;-2,0;3e-9\n4;;6,25",
        "1.5\t-2\t3E-9\n4\tnan\t6.25\n\n",
        "1.5 -2  3e-9\n4   nan 6.25\n",
        "\ufeff1.5,-2,3e-9\n4,NaN,6.25\n",
    ],
)
def test_separators_and_decimal_points(text: str) -> None:
    assert looks_like_a_table(text.encode())
    np.testing.assert_array_equal(read_table(text.encode()).values, VALUES)


@pytest.mark.parametrize("text", ["x,y,z\n1,2,3\n", "# heights\n1 2\n", "7\n", "", "GIF89a", "{1: 2}"])
def test_what_is_no_table(text: str) -> None:
    assert not looks_like_a_table(text.encode())


@pytest.mark.parametrize("data", [b"1,2\n3,4,5\n", b"1,2\n3,four\n", b"1,2\n\xff\xfe,3\n"])
def test_damage(data: bytes) -> None:
    with pytest.raises(DamagedFileError, match="as many numbers"):
        read_table(data)


def test_too_many_lines_are_refused_unread() -> None:
    with pytest.raises(ImageTooLargeError, match="5000 x 2"):
        read_table(b"1,2\n" * 5000)
