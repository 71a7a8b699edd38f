// SPDX-License-Identifier: MIT
// The plan view's section: north up, a centre (metres north and east), pixels per metre.
const LEAST_PX_M = 1e-4, MOST_PX_M = 400;
const ROOM_PX = { left: 50, right: 90, top: 56, bottom: 44 }; // margins around the fleet, for names and tools

class Camera {
  constructor() {
    this.north = this.east = 0;
    this.scale = 10;
    this.width = this.height = 1;
    this.mode = "fleet"; // or "plans": with them, "free", or the key of the followed vessel
    this.placed = false;
  }

  /** Pixels [right, down] of a position. */
  at(north, east) {
    return [this.width / 2 + (east - this.east) * this.scale, this.height / 2 - (north - this.north) * this.scale];
  }

  /** The position [north, east] at a pixel. */
  place(right, down) {
    return [this.north - (down - this.height / 2) / this.scale, this.east + (right - this.width / 2) / this.scale];
  }

  /** Zooms by a factor; the position under the pixel (right, down) stays there. */
  zoom(factor, right = this.width / 2, down = this.height / 2) {
    const scale = Math.min(Math.max(this.scale * factor, LEAST_PX_M), MOST_PX_M);
    const [dx, dy] = [right - this.width / 2, down - this.height / 2];
    if (this.fits) this.mode = "free";
    if (this.mode === "free") {
      this.east += dx * (1 / this.scale - 1 / scale);
      this.north -= dy * (1 / this.scale - 1 / scale);
    }
    this.scale = scale;
  }

  /** Whether the view is to hold all vessels. */
  get fits() {
    return this.mode === "fleet" || this.mode === "plans";
  }

  drag(dx, dy) {
    this.mode = "free";
    this.east -= dx / this.scale;
    this.north += dy / this.scale;
  }

  /** Moves the view to its target. A fleet well within the view does not move it. */
  aim(vessels) {
    const all = vessels.filter(isPlaced), heard = all.filter((vessel) => !isElsewhere(vessel));
    const placed = heard.length && this.fits ? heard : all;
    if (this.mode === "free" || !placed.length) return;
    if (!this.fits) {
      const followed = placed.find((vessel) => vessel.key === this.mode);
      if (followed) [this.north, this.east] = [followed.x_m, followed.y_m];
      return;
    }
    const points = placed.flatMap(({ x_m, y_m, slot }) => (slot ? [[x_m, y_m], slot] : [[x_m, y_m]]));
    if (this.mode === "plans") points.push(...placed.flatMap(({ plan }) => plan?.way ?? []));
    const room = Math.max(...placed.map((vessel) => vessel.length_m || 1)) / 2;
    const [north, east] = [0, 1].map((i) => {
      const values = points.map((point) => point[i]);
      return [Math.min(...values) - room, Math.max(...values) + room];
    });
    const share = Math.min(1, this.width / 400, this.height / 400);
    const [left, right, top, bottom] = ["left", "right", "top", "bottom"].map((side) => share * ROOM_PX[side]);
    const wide = Math.max(east[1] - east[0], 4), high = Math.max(north[1] - north[0], 4);
    const ideal = Math.min((this.width - left - right) / wide, (this.height - top - bottom) / high, MOST_PX_M);
    const [west, upper] = this.at(north[1], east[0]), [east_most, lower] = this.at(north[0], east[1]);
    const inside = west > left / 2 && upper > top / 2 && east_most < this.width - 0.7 * right && lower < this.height - bottom / 2;
    if (this.placed && inside && ideal < 1.8 * this.scale) return;
    this.scale = ideal / (this.placed ? 1.15 : 1.0);
    this.north = (north[0] + north[1] + (top - bottom) / this.scale) / 2;
    this.east = (east[0] + east[1] + (right - left) / this.scale) / 2;
    this.placed = true;
  }
}

/** Lets fingers, mouse and wheel move the camera; `moved` is called after each change. */
function steer(canvas, camera, moved) {
  const fingers = new Map();
  const middle = () => {
    const all = [...fingers.values()];
    const [x, y] = [0, 1].map((i) => all.reduce((sum, p) => sum + p[i], 0) / all.length);
    const spread = all.length > 1 ? Math.hypot(all[0][0] - all[1][0], all[0][1] - all[1][1]) : 0;
    return { x, y, spread };
  };
  canvas.addEventListener("pointerdown", (event) => {
    canvas.setPointerCapture(event.pointerId);
    fingers.set(event.pointerId, [event.offsetX, event.offsetY]);
  });
  canvas.addEventListener("pointermove", (event) => {
    if (!fingers.has(event.pointerId)) return;
    const before = middle();
    fingers.set(event.pointerId, [event.offsetX, event.offsetY]);
    const after = middle();
    const far = Math.hypot(after.x - before.x, after.y - before.y);
    if (far > 0 && (camera.mode === "free" || far > 0.5)) camera.drag(after.x - before.x, after.y - before.y);
    if (before.spread > 0 && after.spread > 0) camera.zoom(after.spread / before.spread, after.x, after.y);
    moved();
  });
  for (const end of ["pointerup", "pointercancel"]) {
    canvas.addEventListener(end, (event) => fingers.delete(event.pointerId));
  }
  // in an iframe, the wheel and vertical swipes scroll the outer page until the plan has the focus
  const inside = window !== window.top;
  if (inside) canvas.style.touchAction = "pan-y";
  canvas.addEventListener("wheel", (event) => {
    if (inside && document.activeElement !== canvas) return;
    event.preventDefault();
    camera.zoom(Math.exp(-0.0015 * event.deltaY), event.offsetX, event.offsetY);
    moved();
  }, { passive: false });
}
