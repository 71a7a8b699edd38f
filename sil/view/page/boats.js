// SPDX-License-Identifier: MIT
// The fleet on the plan view: tree, slots, hulls to scale.
const LEAST_HULL_PX = 32; // so that its number can be read on it
const SILENT_S = 5;
// outline of a hull of length 1: forward, starboard; the same as in reports' pictures
const HULL = [[0.5, 0], [0.2, 0.17], [-0.5, 0.14], [-0.5, -0.14], [0.2, -0.17]];

const hullPx = (vessel, camera) => Math.max(LEAST_HULL_PX, (vessel.length_m || 1) * camera.scale);
const isPlaced = (vessel) => known(vessel.x_m) && known(vessel.y_m);
const isSilent = (vessel) => known(vessel.link_age_s) && vessel.link_age_s > SILENT_S;
/** Whether only its last position can be drawn: it is silent or sends no position. */
const isElsewhere = (vessel) => isSilent(vessel) || (known(vessel.place_age_s) && vessel.place_age_s > SILENT_S);

/** Makes a hull of `px` pixels, heading `psi` rad, the current path. */
function layHull(ctx, [right, down], psi, px) {
  const cos = Math.cos(psi), sin = Math.sin(psi);
  ctx.beginPath();
  for (const [ahead, starboard] of HULL) {
    const north = cos * ahead - sin * starboard, east = sin * ahead + cos * starboard;
    ctx.lineTo(right + px * east, down - px * north);
  }
  ctx.closePath();
}

/** Draws a line from a follower to its leader, with an arrow in the middle towards the leader. */
function drawFollows(ctx, camera, vessel, leader) {
  const [x, y] = camera.at(vessel.x_m, vessel.y_m), [to_x, to_y] = camera.at(leader.x_m, leader.y_m);
  const length = Math.hypot(to_x - x, to_y - y);
  ctx.strokeStyle = theme.stale;
  ctx.lineWidth = 1;
  ctx.setLineDash([2, 4]);
  ctx.beginPath();
  ctx.moveTo(x, y);
  ctx.lineTo(to_x, to_y);
  ctx.stroke();
  ctx.setLineDash([]);
  if (length < 40) return;
  const [dx, dy] = [(to_x - x) / length, (to_y - y) / length];
  const [tip_x, tip_y] = [(x + to_x) / 2 + 5 * dx, (y + to_y) / 2 + 5 * dy];
  ctx.beginPath();
  ctx.moveTo(tip_x - 9 * dx - 4 * dy, tip_y - 9 * dy + 4 * dx);
  ctx.lineTo(tip_x, tip_y);
  ctx.lineTo(tip_x - 9 * dx + 4 * dy, tip_y - 9 * dy - 4 * dx);
  ctx.stroke();
}

function drawSlot(ctx, camera, vessel, psi) {
  const slot = camera.at(...vessel.slot);
  ctx.strokeStyle = colourOf(vessel);
  ctx.globalAlpha = isSilent(vessel) ? 0.35 : 0.9;
  ctx.lineWidth = 1;
  if (isPlaced(vessel)) {
    ctx.beginPath();
    ctx.moveTo(...camera.at(vessel.x_m, vessel.y_m));
    ctx.lineTo(...slot);
    ctx.stroke();
  }
  layHull(ctx, slot, psi, 1.25 * hullPx(vessel, camera));
  ctx.setLineDash([4, 2]);
  ctx.lineWidth = 1.3;
  ctx.stroke();
  ctx.setLineDash([]);
  ctx.globalAlpha = 1;
}

/** Draws the virtual leader: a ring around room for a boat, and its heading. */
const ringPx = (vessel, camera) => Math.max(12, 0.66 * hullPx(vessel, camera));

function drawVirtual(ctx, camera, vessel) {
  const [right, down] = camera.at(vessel.x_m, vessel.y_m), px = ringPx(vessel, camera);
  ctx.beginPath();
  ctx.arc(right, down, px, 0, 2 * Math.PI);
  if (known(vessel.psi_rad)) {
    const [ahead_x, ahead_y] = [Math.sin(vessel.psi_rad), -Math.cos(vessel.psi_rad)];
    ctx.moveTo(right + px * ahead_x, down + px * ahead_y);
    ctx.lineTo(right + (px + 14) * ahead_x, down + (px + 14) * ahead_y);
  }
  ctx.strokeStyle = isElsewhere(vessel) ? theme.stale : theme.ink;
  ctx.lineWidth = 1.4;
  ctx.stroke();
}

const NUMBERS_DRAWN = new Map(); // drawing a text costs more than copying its image

/** A number as an image of 40 by 24 pixels, at twice that resolution. */
function numberOf(id, size, ink, hull) {
  const name = `${id} ${size} ${ink} ${hull}`;
  if (!NUMBERS_DRAWN.has(name)) {
    const made = Object.assign(document.createElement("canvas"), { width: 80, height: 48 });
    const ctx = made.getContext("2d");
    ctx.scale(2, 2);
    ctx.font = `700 ${size}px system-ui, sans-serif`;
    write(ctx, `${id}`, 20, 16, ink, "center", hull);
    if (NUMBERS_DRAWN.size > 1000) NUMBERS_DRAWN.clear();
    NUMBERS_DRAWN.set(name, made);
  }
  return NUMBERS_DRAWN.get(name);
}

/** Draws a vessel's number on its hull. */
function drawNumber(ctx, camera, vessel) {
  const [right, down] = camera.at(vessel.x_m, vessel.y_m);
  const empty = isElsewhere(vessel) || vessel.kind === "vessel", hull = empty ? theme.water : colourOf(vessel);
  const size = Math.round(Math.min(18, Math.max(11, 0.26 * hullPx(vessel, camera))));
  ctx.drawImage(numberOf(vessel.id, size, empty ? theme.ink : readableOn(hull), hull), right - 20, down - 12, 40, 24);
}

function drawHull(ctx, camera, vessel, chosen) {
  const at = camera.at(vessel.x_m, vessel.y_m), px = hullPx(vessel, camera);
  const silent = isElsewhere(vessel), psi = vessel.psi_rad;
  if (known(psi)) {
    const [ahead_x, ahead_y] = [Math.sin(psi), -Math.cos(psi)];
    ctx.strokeStyle = silent ? theme.stale : colourOf(vessel);
    ctx.lineWidth = 1.5;
    ctx.beginPath();
    ctx.moveTo(at[0], at[1]);
    ctx.lineTo(at[0] + ahead_x * (0.5 * px + 12), at[1] + ahead_y * (0.5 * px + 12));
    ctx.stroke();
    layHull(ctx, at, psi, px);
  } else {
    ctx.beginPath();
    ctx.arc(at[0], at[1], px / 3, 0, 2 * Math.PI);
  }
  ctx.fillStyle = silent || vessel.kind === "vessel" ? theme.water : colourOf(vessel);
  ctx.fill();
  ctx.strokeStyle = silent ? theme.stale : vessel.kind === "vessel" ? theme.soft : theme.water;
  ctx.lineWidth = silent || vessel.kind === "vessel" ? 1.5 : 1;
  ctx.stroke();
  if (!chosen) return;
  ctx.strokeStyle = theme.ink;
  if (px < 50) {
    ctx.beginPath();
    ctx.arc(at[0], at[1], 0.75 * px + 5, 0, 2 * Math.PI);
  } else ctx.lineWidth = 2.5;
  ctx.stroke();
}
