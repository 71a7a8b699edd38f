# SPDX-License-Identifier: MIT
"""A chart under the boats, from a file of the user's: GeoJSON lines or raster MBTiles.

Sources: RFC 7946 (GeoJSON); the MBTiles specification 1.3, whose rows count from the south.
"""

import json
import sqlite3
from collections.abc import Iterator
from contextlib import closing
from pathlib import Path
from typing import Any

_DEPTH = {"LineString": 1, "MultiLineString": 2, "Polygon": 2, "MultiPolygon": 3}
_RASTER = {"png": "image/png", "jpg": "image/jpeg", "jpeg": "image/jpeg", "webp": "image/webp"}
Line = list[tuple[float, float]]


class Chart:
    """A chart file: `about`, which is sent to the page, and its tiles; ValueError in one line.

    `about` is `{"lines": [[[longitude, latitude], …], …]}` in degrees, or `{"least", "most"}`, the
    range of zooms of the tiles.
    """

    def __init__(self, path: Path) -> None:
        self._path: Path | None = None
        self.kind = ""
        try:
            with path.open("rb") as file:
                is_database = file.read(15) == b"SQLite format 3"
            if is_database:
                self._path = path
                self.about = self._tiles(path)
            else:
                self.about = {"lines": list(_lines(json.loads(path.read_text(encoding="utf-8"))))}
        except OSError as error:
            raise ValueError(f"{path}: {error.strerror}") from None
        except (KeyError, TypeError, IndexError, ValueError, sqlite3.Error) as error:
            wanted = "a chart is a GeoJSON file (RFC 7946, degrees) or raster MBTiles"
            raise ValueError(f"{path}: {error}; {wanted}") from None
        if not self.about.get("lines", True):
            raise ValueError(f"{path}: contains no lines or polygons; nothing else is drawn")

    def tile(self, zoom: int, column: int, row: int) -> bytes | None:
        """A tile's image, `row` counted from the north; None if there is no such tile."""
        if self._path is None or not 0 <= zoom < 30:
            return None
        with closing(_open(self._path)) as database:
            found = database.execute(
                "SELECT tile_data FROM tiles WHERE zoom_level=? AND tile_column=? AND tile_row=?",
                (zoom, column, (1 << zoom) - 1 - row),
            ).fetchone()
        return None if found is None else bytes(found[0])

    def _tiles(self, path: Path) -> dict[str, Any]:
        with closing(_open(path)) as database:
            kind = dict(database.execute("SELECT name, value FROM metadata")).get("format", "png")
            least, most = database.execute(
                "SELECT min(zoom_level), max(zoom_level) FROM tiles"
            ).fetchone()
        if kind not in _RASTER:
            raise ValueError(f'its tiles are "{kind}", not images')
        if least is None:
            raise ValueError("it has no tiles")
        self.kind = _RASTER[kind]
        return {"least": least, "most": most}


def _open(path: Path) -> sqlite3.Connection:
    return sqlite3.connect(f"{path.absolute().as_uri()}?mode=ro", uri=True)


def _lines(thing: Any) -> Iterator[Line]:
    """All lines and all rings of polygons."""
    kind = thing["type"]
    if kind == "FeatureCollection":
        for feature in thing["features"]:
            yield from _lines(feature)
    elif kind == "Feature":
        if thing["geometry"] is not None:
            yield from _lines(thing["geometry"])
    elif kind == "GeometryCollection":
        for geometry in thing["geometries"]:
            yield from _lines(geometry)
    elif kind in _DEPTH:
        yield from _flat(thing["coordinates"], _DEPTH[kind])
    elif kind not in ("Point", "MultiPoint"):
        raise ValueError(f'"{kind}" is not a GeoJSON type')


def _flat(coordinates: Any, depth: int) -> Iterator[Line]:
    if depth > 1:
        for inner in coordinates:
            yield from _flat(inner, depth - 1)
        return
    line = [(round(float(at[0]), 7), round(float(at[1]), 7)) for at in coordinates]
    if any(not (abs(longitude) <= 360 and abs(latitude) <= 90) for longitude, latitude in line):
        raise ValueError("a position is not longitude and latitude in degrees")
    yield line
