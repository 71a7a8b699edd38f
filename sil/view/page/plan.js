// SPDX-License-Identifier: MIT
// The plan view: draws all layers of a frame, in order, on a canvas that fits its box.
class Plan {
  constructor(canvas, source, chart, ruler) {
    Object.assign(this, { canvas, ruler });
    this.source = source;
    this.camera = new Camera();
    this.ground = new Ground(chart);
    this.said = "";
  }

  /** Fits the canvas to its box and the screen's pixel ratio. */
  resize() {
    const { clientWidth: width, clientHeight: height } = this.canvas;
    const ratio = Math.min(window.devicePixelRatio || 1, 2);
    if (this.canvas.width !== Math.round(width * ratio) || this.canvas.height !== Math.round(height * ratio)) {
      this.camera.placed = false;
      this.canvas.width = Math.round(width * ratio);
      this.canvas.height = Math.round(height * ratio);
    }
    [this.camera.width, this.camera.height] = [width, height];
    const ctx = this.canvas.getContext("2d", { alpha: false });
    ctx.setTransform(ratio, 0, 0, ratio, 0, 0);
    return ctx;
  }

  /** Draws a frame with the trails of the last `window_s` seconds; `chosen`: key of one vessel. */
  draw(frame, window_s, chosen) {
    if (!this.canvas.clientWidth || !this.canvas.clientHeight) return; // hidden: another tab of the page is open
    const ctx = this.resize(), camera = this.camera;
    camera.aim(frame.vessels);
    ctx.lineJoin = "round";
    const placed = frame.vessels.filter(isPlaced);
    this.ground.draw(ctx, camera, placed, (key) => this.source.track(key), [frame.t_s, window_s, frame.origin]);
    const byId = new Map(placed.map((vessel) => [vessel.id, vessel]));
    for (const vessel of placed) {
      const leader = byId.get(vessel.leader);
      if (leader && leader !== vessel) drawFollows(ctx, camera, vessel, leader);
    }
    for (const vessel of frame.vessels) {
      if (vessel.slot) drawSlot(ctx, camera, vessel, byId.get(vessel.leader)?.psi_rad ?? vessel.psi_rad ?? 0);
    }
    for (const vessel of placed.filter(({ kind }) => kind === "leader")) drawVirtual(ctx, camera, vessel);
    for (const vessel of placed.filter(({ kind }) => kind !== "leader")) {
      drawThrust(ctx, camera, vessel);
      drawHull(ctx, camera, vessel, vessel.key === chosen);
      drawNumber(ctx, camera, vessel);
    }
    this.labels(ctx, placed);
    this.ruler.draw(ctx, camera);
    this.describe(frame);
  }

  /** How long the fastest vessel needs for a pixel: until then, the picture looks the same. */
  same_ms(vessels, least, most) {
    const fastest = Math.max(0, ...vessels.map(({ u_mps, v_mps }) => Math.hypot(u_mps ?? 1, v_mps ?? 0)));
    return Math.min(most, Math.max(least, 1000 / (fastest * this.camera.scale)));
  }

  /** Writes beside a vessel only what is wrong with it. */
  labels(ctx, placed) {
    ctx.font = `600 ${FONT}`;
    const boats = placed.filter((vessel) => vessel.kind !== "leader");
    const middle = boats.reduce((sum, vessel) => sum + vessel.y_m, 0) / boats.length;
    for (const vessel of placed) {
      const [right, down] = this.camera.at(vessel.x_m, vessel.y_m), virtual = vessel.kind === "leader";
      const [text, colour] = virtual ? [vessel.plan_of ? "plan" : "leader", isElsewhere(vessel) ? "stale" : "ink"] : this.label(vessel);
      if (!text) continue;
      const beside = virtual ? 0.72 * ringPx(vessel, this.camera) + 3 : Math.min(0.55 * hullPx(vessel, this.camera), 60) + 6;
      // on the west side of boats in the west, so that neighbours' texts do not overlap
      const width = ctx.measureText(text).width;
      const west = !virtual && vessel.y_m < middle - 1e-6 && right - beside - width > 0;
      write(ctx, text, west ? right - beside - width : right + beside, down + (virtual ? -beside : 4), theme[colour]);
    }
  }

  /** Text and colour of a boat's note. */
  label(vessel) {
    if (isSilent(vessel)) return [`silent ${age(vessel.link_age_s)}`, "stale"];
    if (isElsewhere(vessel)) return [`was here ${age(vessel.place_age_s)} ago`, "stale"];
    if (isClosing(vessel)) return [closing(vessel), "calm"];
    return vessel.state === "FORMATION" ? [null] : [vessel.state, STATE_THEME[vessel.state]];
  }

  /** The key of the vessel at a pixel, or null. */
  under(right, down, vessels) {
    let best = null, least = 22;
    for (const vessel of vessels.filter(isPlaced)) {
      const [x, y] = this.camera.at(vessel.x_m, vessel.y_m);
      const far = Math.hypot(x - right, y - down) - 0.3 * hullPx(vessel, this.camera);
      if (far < least) [best, least] = [vessel.key, far];
    }
    return best;
  }

  describe({ vessels }) {
    const told = vessels.map((vessel) => `${nameOf(vessel)}${vessel.state ? ` ${vessel.state}` : ""}${toldPlan(vessel)}`);
    const text = `Plan view, north up: ${told.join(", ") || "no vessel"}`;
    if (text !== this.said) this.canvas.setAttribute("aria-label", text);
    this.said = text;
  }
}
