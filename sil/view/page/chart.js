// SPDX-License-Identifier: MIT
// The user's own chart under the boats: GeoJSON lines or MBTiles tiles from the page's server.
// Positions are converted to the boats' frame, the tangent plane of WGS 84 at its origin.
const A_M = 6378137, E2 = 0.00669437999014;
const NEAR_M = 1e5; // nothing farther from the origin is drawn
const MOST_TILES = 60, KEPT_TILES = 300, TILE_M = 156543.034; // metres per pixel of zoom 0 at the equator

const radians = (degrees) => (degrees * Math.PI) / 180;

function ecef(latitude, longitude) {
  const [phi, lambda] = [radians(latitude), radians(longitude)];
  const n = A_M / Math.sqrt(1 - E2 * Math.sin(phi) ** 2);
  return [n * Math.cos(phi) * Math.cos(lambda), n * Math.cos(phi) * Math.sin(lambda), n * (1 - E2) * Math.sin(phi)];
}

/** A function from latitude and longitude (degrees) to [north, east] of the origin; null if far away. */
function projection([latitude, longitude]) {
  const [sp, cp] = [Math.sin(radians(latitude)), Math.cos(radians(latitude))];
  const [sl, cl] = [Math.sin(radians(longitude)), Math.cos(radians(longitude))];
  const origin = ecef(latitude, longitude);
  return (lat, lon) => {
    const [x, y, z] = ecef(lat, lon).map((p, i) => p - origin[i]);
    const north = -sp * cl * x - sp * sl * y + cp * z, east = -sl * x + cl * y;
    return Math.hypot(x, y, z) < NEAR_M ? [north, east] : null;
  };
}

class SeaChart {
  constructor(changed) {
    this.changed = changed;
    this.about = null;
    this.version = 0; // changes whenever it must be redrawn
    this.tiles = new Map();
    this.again_ms = 30000; // a tile that failed, as one does while the view is away, is asked for again
    if (CONFIG.has_chart) this.load();
  }

  async load() {
    this.about = await (await fetch("chart")).json();
    this.renew();
  }

  renew() {
    this.version += 1;
    this.changed();
  }

  draw(ctx, camera, origin) {
    if (!this.about || !origin) return;
    if (origin.join() !== this.origin) {
      [this.origin, this.place] = [origin.join(), projection(origin)];
      this.path = this.about.lines ? this.laid() : null;
    }
    ctx.save();
    if (this.path) this.drawLines(ctx, camera);
    else this.drawTiles(ctx, camera, origin);
    ctx.restore();
  }

  /** All lines as one path; metres east and south. */
  laid() {
    const path = new Path2D();
    for (const line of this.about.lines) {
      let drawn = false;
      for (const [longitude, latitude] of line) {
        const at = this.place(latitude, longitude);
        if (at) path[drawn ? "lineTo" : "moveTo"](at[1], -at[0]);
        drawn = at !== null;
      }
    }
    return path;
  }

  drawLines(ctx, camera) {
    const [right, down] = camera.at(0, 0);
    ctx.transform(camera.scale, 0, 0, camera.scale, right, down);
    ctx.strokeStyle = theme.coast;
    ctx.lineWidth = 2 / camera.scale;
    ctx.stroke(this.path);
  }

  drawTiles(ctx, camera, [latitude, longitude]) {
    const metre_deg = 1 / 111320, narrow = Math.cos(radians(latitude));
    const box = [camera.place(0, 0), camera.place(camera.width, camera.height)].map(([north, east]) => [
      Math.min(85, Math.max(-85, latitude + north * metre_deg)), longitude + (east * metre_deg) / narrow]);
    const { least, most } = this.about;
    let zoom = Math.min(most, Math.max(least, Math.round(Math.log2(TILE_M * narrow * camera.scale))));
    let tiles = tilesOf(box, zoom);
    while (tiles.length > MOST_TILES && zoom > least) tiles = tilesOf(box, (zoom -= 1));
    for (const [x, y] of tiles.slice(0, MOST_TILES)) this.drawTile(ctx, camera, [zoom, x, y]);
  }

  drawTile(ctx, camera, [zoom, x, y]) {
    const corners = [[x, y], [x + 1, y], [x, y + 1]].map((at) => this.place(...cornerOf(zoom, ...at)));
    const image = this.tile(`tile/${zoom}/${x}/${y}`);
    if (!image.naturalWidth || corners.includes(null)) return;
    const [nw, ne, sw] = corners.map((at) => camera.at(...at));
    ctx.save();
    ctx.transform(ne[0] - nw[0], ne[1] - nw[1], sw[0] - nw[0], sw[1] - nw[1], ...nw);
    ctx.drawImage(image, 0, 0, 1, 1);
    ctx.restore();
  }

  tile(address) {
    if (!this.tiles.has(address)) {
      const image = new Image();
      image.onload = () => this.renew();
      image.onerror = () => setTimeout(() => this.tiles.delete(address) && this.renew(), this.again_ms);
      image.src = address;
      this.tiles.set(address, image);
      if (this.tiles.size > KEPT_TILES) this.tiles.delete(this.tiles.keys().next().value);
    }
    return this.tiles.get(address);
  }
}

/** Columns and rows of the tiles from the north-west corner to the south-east one. */
function tilesOf(box, zoom) {
  const count = 2 ** zoom;
  const [[west, north], [east, south]] = box.map(([latitude, longitude]) => [
    Math.floor(((longitude + 180) / 360) * count),
    Math.floor(((1 - Math.asinh(Math.tan(radians(latitude))) / Math.PI) / 2) * count)]);
  const out = [];
  if ((east - west + 1) * (south - north + 1) > 4 * MOST_TILES) return Array(4 * MOST_TILES).fill([-1, -1]);
  for (let x = west; x <= east; x += 1) for (let y = north; y <= south; y += 1) out.push([((x % count) + count) % count, y]);
  return out.filter(([, y]) => y >= 0 && y < count);
}

/** Latitude and longitude of a tile's north-west corner. */
function cornerOf(zoom, x, y) {
  const count = 2 ** zoom;
  return [(Math.atan(Math.sinh(Math.PI * (1 - (2 * y) / count))) * 180) / Math.PI, (x / count) * 360 - 180];
}
