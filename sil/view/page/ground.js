// SPDX-License-Identifier: MIT
// The layer under the vessels: chart, grid, fences, plans, trails, scale, north. Redrawn once a second and when the view
// moves; in between, only the latest part of each trail is added.
const TRAIL_POINTS = 3000, FADES = 6; // of all trails together
const FRESH_S = 1;

class Ground {
  constructor(chart) {
    this.chart = chart;
    this.canvas = document.createElement("canvas");
    this.drawn = "";
    this.t_s = NaN;
  }

  /** Fills the canvas of `ctx`; trails show the last `window_s` of `track(key)` before `t_s`. */
  draw(ctx, camera, vessels, track, [t_s, window_s, origin]) {
    const { width, height } = ctx.canvas;
    const view = [width, height, camera.north, camera.east, camera.scale, window_s, dark.matches, this.chart.version, origin];
    const plans = vessels.map(({ plan, item }) => `${numberOfPlan(plan)} ${item}`);
    const wanted = [...view, ...vessels.map((vessel) => `${vessel.key} ${vessel.kind}`), ...plans].join();
    if (wanted !== this.drawn || !(t_s >= this.t_s && t_s < this.t_s + FRESH_S)) {
      [this.drawn, this.t_s] = [wanted, t_s];
      this.renew(camera, vessels, track, [t_s - window_s, t_s, origin], [width, height]);
    }
    ctx.save();
    ctx.resetTransform(); // copy pixel by pixel
    ctx.drawImage(this.canvas, 0, 0);
    ctx.restore();
    for (const vessel of vessels) drawTail(ctx, camera, vessel, track(vessel.key), [this.t_s, t_s]);
  }

  renew(camera, vessels, track, [from_s, to_s, origin], [width, height]) {
    [this.canvas.width, this.canvas.height] = [width, height];
    const ctx = this.canvas.getContext("2d", { alpha: false });
    ctx.fillStyle = theme.water;
    ctx.fillRect(0, 0, width, height);
    ctx.scale(width / camera.width, height / camera.height);
    ctx.lineJoin = "round";
    this.chart.draw(ctx, camera, origin);
    drawGrid(ctx, camera);
    for (const vessel of vessels) drawFence(ctx, camera, vessel.plan);
    for (const vessel of vessels) drawPlanned(ctx, camera, vessel);
    const most = Math.min(600, Math.max(60, TRAIL_POINTS / vessels.length));
    for (const vessel of vessels) drawTrail(ctx, camera, vessel, track(vessel.key), [from_s, to_s, most]);
    drawScaleBar(ctx, camera);
    drawNorth(ctx, camera);
  }
}

/** Makes the samples with these indices the current path; whether it ends at the last of them. */
function layTrail(ctx, camera, { x_m, y_m }, indices) {
  let drawn = false;
  ctx.beginPath();
  for (const i of indices) {
    if (!known(x_m[i]) || !known(y_m[i])) drawn = false;
    else {
      const [right, down] = camera.at(x_m[i], y_m[i]);
      if (drawn) ctx.lineTo(right, down);
      else ctx.moveTo(right, down);
      drawn = true;
    }
  }
  return drawn;
}

function strokeTrail(ctx, vessel, share) {
  ctx.strokeStyle = colourOf(vessel);
  ctx.lineWidth = 1.6;
  ctx.setLineDash(vessel.kind === "leader" ? [4, 4] : []);
  ctx.globalAlpha = 0.08 + 0.72 * share;
  ctx.stroke();
  ctx.globalAlpha = 1;
  ctx.setLineDash([]);
}

/** Draws a trail that fades with age. */
function drawTrail(ctx, camera, vessel, track, [from_s, to_s, most]) {
  const indices = track.indices(from_s, to_s, most);
  for (let fade = 0; fade < FADES; fade += 1) {
    const begin = Math.floor((fade * indices.length) / FADES), end = Math.floor(((fade + 1) * indices.length) / FADES);
    layTrail(ctx, camera, track.columns, indices.slice(begin, end + 1));
    strokeTrail(ctx, vessel, (fade + 1) / FADES);
  }
}

/** Draws from the trail's end to the vessel. */
function drawTail(ctx, camera, vessel, track, [from_s, to_s]) {
  if (layTrail(ctx, camera, track.columns, track.indices(from_s, to_s, Infinity))) {
    ctx.lineTo(...camera.at(vessel.x_m, vessel.y_m));
  }
  strokeTrail(ctx, vessel, 1);
}
