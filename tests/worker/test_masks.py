from io import BytesIO

import numpy as np
from PIL import Image

from worker.masks import mask_png


def test_a_mask_is_one_bit_a_pixel_white_in_contact_rows_downwards() -> None:
    mask = np.random.default_rng(0).random((5, 11)) > 0.5
    image = Image.open(BytesIO(mask_png(mask)))
    assert (image.mode, image.size) == ("1", (11, 5))
    np.testing.assert_array_equal(np.asarray(image.convert("L")), np.where(mask, 255, 0))
