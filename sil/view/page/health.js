// SPDX-License-Identifier: MIT
// Which vessels are in trouble and why, and the line about the whole fleet.
const UNASKED = ["MANUAL", "TEST"]; // unmet conditions of FORMATION do not matter there

/** Notes on every boat as `close` the boat whose middle is nearer than a hull's length, if any. */
function noteClose(vessels) {
  const boats = vessels.filter((vessel) => vessel.kind === "boat" && isPlaced(vessel) && !isElsewhere(vessel));
  for (const boat of boats) boat.close = null;
  boats.forEach((boat, i) => {
    for (const other of boats.slice(i + 1)) {
      const apart_m = Math.hypot(boat.x_m - other.x_m, boat.y_m - other.y_m), hull_m = Math.max(boat.length_m || 1, other.length_m || 1);
      if (apart_m >= hull_m) continue;
      for (const [one, near] of [[boat, other], [other, boat]]) {
        if (!one.close || apart_m < one.close.apart_m) one.close = { near, apart_m };
      }
    }
  });
}

/** The vessel's troubles, one sentence each; empty if it is well. */
function troublesOf(vessel) {
  if (isSilent(vessel)) return [`silent for ${age(vessel.link_age_s)}${vessel.state ? `, last heard in ${vessel.state}` : ""}`];
  const asked = !UNASKED.includes(vessel.state);
  const out = asked ? [...vessel.held] : [];
  if (!out.length && ["FAULT", "COAST"].includes(vessel.state)) {
    // the text that tells of the state comes before the list of conditions
    const told = vessel.text?.startsWith(`${vessel.state}: `);
    out.push(told ? vessel.text.slice(vessel.state.length + 2) : vessel.state === "FAULT" ? "it reports a fault and gives no reason" : "it coasts and gives no reason");
  }
  if (vessel.senders > 1) out.push(`two vessels use system id ${vessel.id}`);
  if (asked && known(vessel.conditions_lost_s)) out.push(`conditions unknown for ${age(vessel.conditions_lost_s)}`);
  if (isElsewhere(vessel)) out.push(`position unknown: last heard ${age(vessel.place_age_s)} ago`);
  if (vessel.close) out.push(`${metres(vessel.close.apart_m)} from boat ${vessel.close.near.id}: nearer than a hull's length`);
  if (known(vessel.unknown_mode)) out.push(`state unknown: its HEARTBEAT has custom_mode ${vessel.unknown_mode}`);
  else if (vessel.stateLost) out.push("state unknown: no HEARTBEAT for more than 5 s");
  return out;
}

/** The line about all boats: number in their slots, states, worst distance, troubles. */
function fleetLine(vessels) {
  const boats = vessels.filter(({ kind }) => kind === "boat");
  if (!boats.length) return { boats: vessels.length ? "No Flotilla boat among them" : "", states: "", worst: "", troubles: "" };
  const heard = boats.filter((boat) => !isSilent(boat));
  const count = `${boats.length} boat${boats.length > 1 ? "s" : ""}`;
  const inSlot = heard.filter((boat) => ["FORMATION", "AUTO", "GUIDED", "LOITER", "RTL"].includes(boat.state) && boat.in_slot >= 1).length;
  const states = new Map();
  for (const boat of boats) {
    const state = (isSilent(boat) ? null : boat.state) ?? "unknown";
    states.set(state, (states.get(state) ?? 0) + 1);
  }
  const worst = heard.filter((boat) => known(boat.error_m)).reduce((a, b) => (a && a.error_m >= b.error_m ? a : b), null);
  const troubled = boats.filter((boat) => troublesOf(boat).length).length;
  return {
    boats: heard.some((boat) => known(boat.in_slot)) ? `${count}, ${inSlot} in ${boats.length > 1 ? "their slots" : "its slot"}` : count,
    states: [...states].map(([state, n]) => `${n} ${state}`).join(", "),
    worst: worst ? `farthest from its slot: boat ${worst.id}, ${metres(worst.error_m)}` : "",
    troubles: troubled ? `${troubled} in trouble` : "none in trouble",
  };
}
