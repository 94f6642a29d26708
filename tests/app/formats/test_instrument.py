"""Files of instruments with their own units: one written here, and eight real ones where they are at hand."""

import io
import json
import zipfile
from pathlib import Path

import numpy as np
import pytest
from SurfaceTopography import Topography

from app.errors import UploadError
from app.formats.instrument import read_instrument
from app.uploads import decode
from tests.app.files import ascii_grid, surface_codes

MEASURED = Path(__file__).parents[4] / "shared/data/measured"
HEIGHTS = surface_codes()[:, :48] * 1e-9


def test_units_come_from_the_file() -> None:
    height_map = read_instrument(ascii_grid(HEIGHTS))
    np.testing.assert_allclose(height_map.values, HEIGHTS, rtol=1e-8)
    assert height_map.height_unit == 1
    assert height_map.pixel_size == pytest.approx((1e-6, 2e-6))


def test_a_map_written_by_another_program_comes_back(tmp_path: Path) -> None:
    file = tmp_path / "map.nc"
    Topography(HEIGHTS.T * 1e9, (96.0, 64.0), unit="nm").to_netcdf(file)
    height_map = decode(file.read_bytes())
    np.testing.assert_allclose(height_map.values * height_map.height_unit, HEIGHTS, rtol=1e-9)
    assert height_map.pixel_size == pytest.approx((1e-9, 2e-9))


def test_a_text_of_a_square_number_of_letter_pairs_is_no_map() -> None:
    """Readers of formats without a signature would take it."""
    with pytest.raises(UploadError, match="no format that is read"):
        read_instrument(b"Height maps! word" * 34)


def test_a_profile_is_no_map() -> None:
    lines = "\n".join(f"{x} {x % 7}" for x in np.arange(100.0))
    with pytest.raises(UploadError):
        read_instrument(lines.encode())


def test_damaged_archives_are_refused() -> None:
    file = io.BytesIO()
    with zipfile.ZipFile(file, "w") as archive:
        archive.writestr("main.xml", "<p:ISO5436_2 xmlns:p='http://www.opengps.eu/2008/ISO5436_2'></p:ISO5436_2>")
    with pytest.raises(UploadError):
        read_instrument(file.getvalue())


@pytest.mark.skipif(not MEASURED.is_dir(), reason="the measured maps are not here")
def test_real_files_agree_with_the_images_made_from_them() -> None:
    for entry in json.loads((MEASURED / "surfaces.json").read_text()):
        height_map = decode((MEASURED / entry["instrument_file"]).read_bytes())
        image = decode((MEASURED / entry["png"]).read_bytes())
        assert height_map.pixel_size == pytest.approx((entry["pixel_size_y_um"] * 1e-6, entry["pixel_size_x_um"] * 1e-6))
        assert height_map.missing == entry["missing_pixels"]
        known = ~np.isnan(height_map.values)
        heights = height_map.values[known] * height_map.height_unit
        np.testing.assert_allclose(
            (heights - heights.min()) * 1e6,
            image.values[known] * entry["height_range_um"],
            atol=1e-5 * entry["height_range_um"],
        )
