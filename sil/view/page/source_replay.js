// SPDX-License-Identifier: MIT
// The replay source: a history's columns, and the frame at any time of it.

/** Decodes base64 of little-endian float32. */
function columnOf(text) {
  const raw = Uint8Array.from(atob(text), (letter) => letter.charCodeAt(0));
  const view = new DataView(raw.buffer);
  return Float32Array.from({ length: raw.length >> 2 }, (_, i) => view.getFloat32(4 * i, true));
}

/** The entry valid at time s in a list of [t_s, value]; null before the first. */
function entryAt(list, s) {
  let found = null;
  for (const entry of list ?? []) {
    if (entry[0] > s + 1e-9) break;
    found = entry;
  }
  return found;
}

/** The value valid at time s in a list of [t_s, value]. */
function holding(list, s, otherwise) {
  const entry = entryAt(list, s);
  return entry ? entry[1] : otherwise;
}

const ESCS = SIDES.map((side) => ESC_CELLS.map(([name]) => [name, `${side}_${name}`]));
const CHANGING = [
  "x_m", "y_m", "psi_rad", "u_mps", "v_mps", "slot_x_m", "slot_y_m", "error_m", "in_slot", "conditions_lost_s", "senders", "unknown_mode",
  "thrust_port_N", "thrust_stbd_N", "link_age_s", "place_age_s", "leader_age_s", "battery_V",
  ...ESCS.flatMap((esc) => esc.map(([, column]) => column)),
];

class ReplaySource {
  constructor(history) {
    this.t = columnOf(history.t_s);
    this.vessels = history.vessels.map((vessel, i) => {
      const columns = Object.fromEntries(
        CHANGING.filter((name) => typeof vessel[name] === "string").map((name) => [name, columnOf(vessel[name])]));
      const plans = (vessel.plans ?? []).map(([t_s, plan]) => [t_s, cleanPlan(plan)]);
      return { ...vessel, key: `${i}`, columns, plans };
    });
    this.begin_s = this.t[0] ?? 0;
    this.end_s = this.t[this.t.length - 1] ?? 0;
    this.status = ["good", "replay"];
    this.origin = pair(history.origin_deg);
    this.events = this.vessels.flatMap((vessel) => eventsOf(vessel, this.t)).sort((a, b) => a.t_s - b.t_s);
    this.tracks = new Map(this.vessels.map((vessel) => [vessel.key, this.trackOf(vessel)]));
    this.seek(this.begin_s);
  }

  get cut() {
    return false;
  }

  trackOf({ columns }) {
    const nothing = new Float32Array(this.t.length).fill(NaN);
    const { u_mps: u, v_mps: v, link_age_s } = columns;
    // draw no line through the silence of a vessel
    const line = (column) => column?.map((x, i) => (link_age_s?.[i] > SILENT_S ? NaN : x)) ?? nothing;
    return new Track(this.t, {
      x_m: line(columns.x_m), y_m: line(columns.y_m), error_m: line(columns.error_m),
      port_N: line(columns.thrust_port_N), stbd_N: line(columns.thrust_stbd_N),
      speed_mps: line(u && v && u.map((x, i) => Math.hypot(x, v[i]))),
    });
  }

  track(key) {
    return this.tracks.get(key);
  }

  seek(s) {
    this.t_s = Math.min(Math.max(s, this.begin_s), this.end_s);
    const after = Math.min(this.tracks.size ? this.tracks.get("0").index(this.t_s) : 0, this.t.length - 1);
    const before = Math.max(after - 1, 0);
    const span = this.t[after] - this.t[before];
    const share = span > 0 ? (this.t_s - this.t[before]) / span : 1;
    const vessels = this.vessels.map((vessel) => this.vesselAt(vessel, before, after, share));
    this.frame = { t_s: this.t_s, origin: this.origin, heard: null, vessels };
  }

  vesselAt(vessel, before, after, share) {
    const at = (name) => {
      const column = vessel.columns[name];
      if (!column) return null;
      const a = column[before], b = column[after];
      if (!known(a) || !known(b)) return numberOr(share < 0.5 ? a : b);
      const gap = name === "psi_rad" ? Math.atan2(Math.sin(b - a), Math.cos(b - a)) : b - a;
      return a + share * gap;
    };
    const both = (one, other) => (known(one) && known(other) ? [one, other] : null);
    const values = Object.fromEntries(CHANGING.map((name) => [name, at(name)]));
    const state = holding(vessel.states, this.t_s, undefined); // null: not known any more
    const [said_s, text] = entryAt(vessel.texts, this.t_s) ?? [null, null];
    const escs = ESCS.map((esc) => Object.fromEntries(esc.map(([name, column]) => [name, values[column]])));
    return {
      id: vessel.id, key: vessel.key, kind: vessel.kind, leader: vessel.leader ?? null,
      plan_of: vessel.plan_of ?? null,
      length_m: vessel.length_m ?? null, limits_N: pair(vessel.limits_N), ...values,
      escs: escs.some((esc) => Object.values(esc).some(known)) ? escs : [],
      slot: both(values.slot_x_m, values.slot_y_m),
      thrust_N: both(values.thrust_port_N, values.thrust_stbd_N),
      state: state ?? null,
      stateLost: vessel.kind === "boat" && (state === null || known(values.unknown_mode)) && !isSilent(values),
      held: holding(vessel.held, this.t_s, []),
      text, text_age_s: text === null ? null : this.t_s - said_s,
      plan: holding(vessel.plans, this.t_s, null),
      item: holding(vessel.items, this.t_s, null),
    };
  }
}
