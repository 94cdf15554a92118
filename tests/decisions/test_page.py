"""What the report opens on: from sentences and a row with signs of HTML in them."""

from html.parser import HTMLParser

import pandas as pd
import xarray as xr

from breaker.decisions import opening


class Read(HTMLParser):
    """Texts by their tag, and the attributes of images."""

    def __init__(self) -> None:
        super().__init__()
        self.found, self.images, self.tag = {}, [], ""

    def handle_starttag(self, tag, attrs):
        self.tag = tag
        if tag == "img":
            self.images.append(dict(attrs)["src"])

    def handle_data(self, data):
        if data.strip():
            self.found.setdefault(self.tag, []).append(data.strip())


def test_headline_sentences_picture_and_the_last_decision():
    names = ("headline", "wearing", "left", "trust")
    page = xr.Dataset(attrs={name: f"{name} <b> & more" for name in names})
    rows = pd.DataFrame({"operation": [1, 2], "limit": ["", "a < b"], "date": [None, None]})
    rows["operations_left"] = [None, 310.0]
    read = Read()
    read.feed(opening(page, rows, b"picture"))
    assert read.found["h1"] == ["headline <b> & more"]
    assert read.found["p"] == [f"{name} <b> & more" for name in names[1:]]
    assert read.images == ["data:image/png;base64,cGljdHVyZQ=="]
    assert read.found["td"] == ["2", "a < b", "310"]  # what is empty is left out
    assert not {"b", "script"} & set(read.found)
