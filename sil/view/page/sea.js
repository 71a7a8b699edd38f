// SPDX-License-Identifier: MIT
// Under the fleet: a grid labelled in metres at its edges, scale bar, north arrow.
const SMALL = '11px system-ui, "Segoe UI", Roboto, sans-serif';
const FONT = '12px system-ui, "Segoe UI", Roboto, "Helvetica Neue", sans-serif';

/** Text that is legible on any background. */
function write(ctx, text, right, down, colour, align = "left", paper = theme.water) {
  ctx.textAlign = align;
  ctx.lineWidth = 3;
  ctx.strokeStyle = paper;
  ctx.setLineDash([]);
  ctx.strokeText(text, right, down);
  ctx.fillStyle = colour;
  ctx.fillText(text, right, down);
}

/** Multiples of `step` within `half` of `middle`; few if the numbers are too large for the step. */
function multiples(middle, half, step) {
  const first = Math.ceil((middle - half) / step) * step;
  return Array.from({ length: Math.floor((2 * half) / step) + 1 }, (_, i) => first + i * step).filter((x) => x <= middle + half);
}

function drawGrid(ctx, camera) {
  const step = roundDown(150 / camera.scale) || 1;
  const digits = Math.max(0, -Math.floor(Math.log10(step)));
  ctx.strokeStyle = theme.grid;
  ctx.lineWidth = 1;
  ctx.beginPath();
  const labels = [];
  const half = [camera.width / 2 / camera.scale, camera.height / 2 / camera.scale];
  for (const east of multiples(camera.east, half[0], step)) {
    const right = Math.round(camera.at(0, east)[0]) + 0.5;
    ctx.moveTo(right, 0);
    ctx.lineTo(right, camera.height);
    labels.push([`${fixed(east, digits)} E`, right, camera.height - 6, "center"]);
  }
  for (const north of multiples(camera.north, half[1], step)) {
    const down = Math.round(camera.at(north, 0)[1]) + 0.5;
    ctx.moveTo(0, down);
    ctx.lineTo(camera.width, down);
    if (down > 60 && down < camera.height - 46) labels.push([`${fixed(north, digits)} N`, camera.width - 6, down - 4, "right"]);
  }
  ctx.stroke();
  const [from, to] = [150, camera.width - 40];
  ctx.font = SMALL;
  for (const [text, right, down, align] of labels) {
    if (align === "right" || (right > from && right < to)) write(ctx, text, right, down, theme.stale, align);
  }
}

function drawScaleBar(ctx, camera) {
  const length = roundDown(120 / camera.scale);
  const [left, down, right] = [14, camera.height - 14, 14 + length * camera.scale];
  for (const [colour, width] of [[theme.water, 5], [theme.ink, 1.5]]) {
    ctx.strokeStyle = colour;
    ctx.lineWidth = width;
    ctx.beginPath();
    ctx.moveTo(left, down - 6);
    ctx.lineTo(left, down);
    ctx.lineTo(right, down);
    ctx.lineTo(right, down - 6);
    ctx.stroke();
  }
  ctx.font = FONT;
  const text = length >= 1000 ? `${length / 1000} km` : length >= 1 ? `${length} m` : `${fixed(100 * length, 0)} cm`;
  write(ctx, text, (left + right) / 2, down - 6, theme.ink, "center");
}

function drawNorth(ctx, camera) {
  const right = camera.width - 24, down = 30;
  ctx.beginPath();
  ctx.moveTo(right, down - 18);
  ctx.lineTo(right + 7, down + 8);
  ctx.lineTo(right, down + 3);
  ctx.lineTo(right - 7, down + 8);
  ctx.closePath();
  ctx.fillStyle = theme.ink;
  ctx.fill();
  ctx.font = FONT;
  write(ctx, "N", right, down + 22, theme.ink, "center");
}
