// SPDX-License-Identifier: MIT
// Plans, fences and rally points: what a vessel is going to do, and where it may be.
const WAYPOINT_PX = 4, NUMBERS_FROM_PX = 26; // numbers stand no closer than that

/** A polygon or circle of a fence, or null. */
function cleanShape(raw) {
  const inside = raw?.inside === true;
  const points = Array.isArray(raw?.points) ? raw.points.map(pair) : [];
  if (points.length > 2 && points.every(Boolean)) return { inside, points };
  const centre = pair(raw?.centre), radius_m = numberOr(raw?.radius_m);
  return centre && radius_m > 0 ? { inside, centre, radius_m } : null;
}

/** A plan as the view tells it, with what is not as it should be left out; null without any. */
function cleanPlan(raw) {
  if (raw === null || typeof raw !== "object") return null;
  const list = (value) => (Array.isArray(value) ? value : []);
  const way = list(raw.way).filter((at) => Array.isArray(at) && at.length === 3 && at.every(known));
  return { way, fence: list(raw.fence).map(cleanShape).filter(Boolean), rally: list(raw.rally).map(pair).filter(Boolean) };
}

/** By id of a vessel; null if the frame has none. */
function cleanPlans(raw) {
  if (raw === null || raw === undefined || typeof raw !== "object") return null;
  return new Map(Object.entries(raw).map(([id, plan]) => [Number(id), cleanPlan(plan)]));
}

const PLAN_NUMBERS = new WeakMap();
let plansSeen = 0;

/** A number that differs from that of any other plan; 0 for none. */
function numberOfPlan(plan) {
  if (!plan) return 0;
  if (!PLAN_NUMBERS.has(plan)) PLAN_NUMBERS.set(plan, (plansSeen += 1));
  return PLAN_NUMBERS.get(plan);
}

/** The index of the place ahead: the first whose item is not before the vessel's; -1 if unknown. */
function aheadOf({ plan, item }) {
  return plan && known(item) ? plan.way.findIndex(([, , number]) => number >= item) : -1;
}

/** The plan in words, for who does not see it. */
function toldPlan(vessel) {
  const { plan } = vessel;
  if (!plan) return "";
  const ahead = aheadOf(vessel), count = (n, what) => `${n} ${what}${n === 1 ? "" : "s"}`;
  const told = [
    plan.way.length && `plan of ${count(plan.way.length, "waypoint")}${ahead < 0 ? "" : `, waypoint ${ahead + 1} ahead`}`,
    plan.fence.length && `fence of ${count(plan.fence.length, "part")}`,
    plan.rally.length && count(plan.rally.length, "rally point"),
  ].filter(Boolean);
  return told.length ? ` (${told.join("; ")})` : "";
}

/** Makes places the current path; `closed`: back to the first. */
function layWay(ctx, camera, places, closed = false) {
  ctx.beginPath();
  for (const [north, east] of places) ctx.lineTo(...camera.at(north, east));
  if (closed) ctx.closePath();
}

/** Draws where the vessel may be (dashed) and where it may not be (filled); its rally points. */
function drawFence(ctx, camera, plan) {
  for (const { inside, points, centre, radius_m } of plan?.fence ?? []) {
    if (points) layWay(ctx, camera, points, true);
    else {
      ctx.beginPath();
      ctx.arc(...camera.at(...centre), radius_m * camera.scale, 0, 2 * Math.PI);
    }
    ctx.strokeStyle = ctx.fillStyle = inside ? theme.calm : theme.bad;
    ctx.lineWidth = 1.5;
    ctx.setLineDash(inside ? [10, 4] : []);
    ctx.stroke();
    ctx.setLineDash([]);
    if (inside) continue;
    ctx.globalAlpha = 0.14;
    ctx.fill();
    ctx.globalAlpha = 1;
  }
  ctx.font = `600 ${SMALL}`;
  for (const [north, east] of plan?.rally ?? []) {
    const [right, down] = camera.at(north, east);
    ctx.beginPath();
    ctx.arc(right, down, 8, 0, 2 * Math.PI);
    ctx.strokeStyle = theme.calm;
    ctx.lineWidth = 1.5;
    ctx.stroke();
    write(ctx, "R", right, down + 4, theme.calm, "center");
  }
}

/** Draws a vessel's waypoints, those behind it fainter, the one ahead filled. */
function drawPlanned(ctx, camera, vessel) {
  const way = vessel.plan?.way ?? [];
  if (!way.length) return;
  const ahead = aheadOf(vessel), begin = Math.max(0, ahead);
  ctx.strokeStyle = ctx.fillStyle = colourOf(vessel);
  ctx.lineWidth = 1.2;
  ctx.setLineDash([7, 5]);
  for (const [places, alpha] of [[way.slice(0, begin + 1), 0.3], [way.slice(Math.max(0, begin - 1)), 0.85]]) {
    ctx.globalAlpha = alpha;
    layWay(ctx, camera, places);
    ctx.stroke();
  }
  ctx.setLineDash([]);
  ctx.font = SMALL;
  let last = [-Infinity, -Infinity];
  for (const [i, [north, east]] of way.entries()) {
    const [right, down] = camera.at(north, east), isAhead = i === ahead;
    ctx.globalAlpha = i < begin ? 0.4 : 1;
    ctx.beginPath();
    ctx.arc(right, down, isAhead ? 1.5 * WAYPOINT_PX : WAYPOINT_PX, 0, 2 * Math.PI);
    ctx.strokeStyle = ctx.fillStyle = colourOf(vessel);
    if (isAhead) ctx.fill();
    else ctx.stroke();
    if (!isAhead && Math.hypot(right - last[0], down - last[1]) < NUMBERS_FROM_PX) continue;
    write(ctx, `${i + 1}`, right + 9, down - 7, isAhead ? theme.ink : theme.soft);
    last = [right, down];
  }
  ctx.globalAlpha = 1;
}
