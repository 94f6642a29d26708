"""Fields as files."""

import io

import numpy as np
from PIL import Image
from scipy.io import netcdf_file

from app.fields import UNITS, bundle, picture

VALUES = np.random.default_rng(0).random((5, 7)) * 3e9 - 1e9


def test_a_picture_runs_from_the_lowest_to_the_highest_value() -> None:
    codes = np.asarray(Image.open(io.BytesIO(picture(VALUES)))).astype(float)
    scaled = VALUES.min() + codes / 65535 * np.ptp(VALUES)
    np.testing.assert_allclose(scaled, VALUES, atol=np.ptp(VALUES) / 65535)
    assert not np.asarray(Image.open(io.BytesIO(picture(np.ones((2, 2)))))).any()


def test_a_bundle_has_a_unit_on_every_variable() -> None:
    fields = {"heights": VALUES, "pressure": VALUES, "probability": VALUES.astype(np.float32), "contact_mask": VALUES > 0}
    with netcdf_file(io.BytesIO(bundle(fields, (2e-6, 3e-6), {"title": "a test"})), mmap=False) as root:
        assert root.title == b"a test"
        for name, values in fields.items():
            variable = root.variables[name]
            assert variable.dimensions == ("y", "x")
            assert variable.units.decode() == UNITS[name]
            np.testing.assert_array_equal(variable[:], values)
        np.testing.assert_allclose(root.variables["x"][:], np.arange(7) * 3e-6)
        np.testing.assert_allclose(root.variables["y"][:], np.arange(5) * 2e-6)
        assert root.variables["x"].units == b"m"
