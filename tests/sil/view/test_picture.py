# SPDX-License-Identifier: MIT
"""The picture of the page is up to date with the page and the boats."""

import pytest
from PIL import Image

from tests.sil.view import picture

RENEW = "renew it, and look at it: python -m tests.sil.view.picture"


@pytest.mark.nightly
def test_picture_of_the_page_is_of_this_page_and_of_these_boats() -> None:
    with Image.open(picture.PATH) as image:
        made_of = image.info.get(picture.MADE_OF)
        now = picture.digest(image, picture.frames())
    assert made_of == now, f"{picture.PATH.name} was made of another page or fleet; {RENEW}"
