// SPDX-License-Identifier: MIT
// Thrust behind a hull that is drawn large enough: one bar per propeller, half a hull long at the limit.
const LEAST_FOR_BARS_PX = 34;
const PROPELLERS = [-0.1, 0.1]; // starboard offset, in hull lengths

function drawThrust(ctx, camera, vessel) {
  const px = hullPx(vessel, camera);
  if (px < LEAST_FOR_BARS_PX || !vessel.thrust_N || !vessel.limits_N || !known(vessel.psi_rad) || isSilent(vessel)) return;
  const [right, down] = camera.at(vessel.x_m, vessel.y_m);
  const cos = Math.cos(vessel.psi_rad), sin = Math.sin(vessel.psi_rad);
  const most = Math.max(...vessel.limits_N.map(Math.abs)) || 1;
  vessel.thrust_N.forEach((thrust, side) => {
    const begin = [-0.52, PROPELLERS[side]], end = [-0.52 - (0.5 * thrust) / most, PROPELLERS[side]];
    ctx.strokeStyle = theme.ink;
    ctx.lineWidth = Math.max(2, 0.06 * px);
    ctx.beginPath();
    for (const [ahead, starboard] of [begin, end]) {
      ctx.lineTo(right + px * (sin * ahead + cos * starboard), down - px * (cos * ahead - sin * starboard));
    }
    ctx.stroke();
  });
}
