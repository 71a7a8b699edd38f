// SPDX-License-Identifier: MIT
// One vessel's values over time, for its trail and its lines in the plots.
const TRACKED = ["x_m", "y_m", "error_m", "port_N", "stbd_N", "speed_mps"];
const KEPT_S = 620;
const SAMPLE_S = 0.19; // at most five samples a second are kept

class Track {
  /** From complete columns, or empty and then filled by `push`. */
  constructor(t = [], columns = Object.fromEntries(TRACKED.map((name) => [name, []]))) {
    this.t = t;
    this.columns = columns;
    this.dropped = 0;
  }

  push(t, vessel) {
    const last = this.t[this.t.length - 1];
    if (last !== undefined && t - last < SAMPLE_S) return;
    this.t.push(t);
    // draw no line through the silence of a vessel
    const values = isSilent(vessel) ? {} : tracked(vessel);
    for (const name of TRACKED) this.columns[name].push(values[name] ?? NaN);
    if (t - this.t[0] > KEPT_S) this.drop(Math.ceil(this.t.length / 20));
  }

  drop(count) {
    this.dropped += count;
    for (const column of [this.t, ...Object.values(this.columns)]) column.splice(0, count);
  }

  /** First index at or after time s. */
  index(s) {
    let low = 0, high = this.t.length;
    while (low < high) {
      const middle = (low + high) >> 1;
      if (this.t[middle] < s) low = middle + 1;
      else high = middle;
    }
    return low;
  }

  /**
   * Indices from `from` to `to` seconds, at most about `most`. Steps are powers of two, counted from
   * the very first sample, so that a line does not flicker as time advances.
   */
  indices(from, to, most) {
    const begin = this.index(from), end = this.index(to + 1e-6);
    let step = 1;
    while ((end - begin) / step > most) step *= 2;
    const out = [];
    if (begin > 0) out.push(begin - 1);
    const first = begin + ((step - ((begin + this.dropped) % step)) % step);
    for (let i = first; i < end; i += step) out.push(i);
    if (end > begin && out[out.length - 1] !== end - 1) out.push(end - 1);
    return out;
  }
}

/** The values of a vessel that a track keeps. */
function tracked(vessel) {
  const known_speed = known(vessel.u_mps) && known(vessel.v_mps);
  return {
    x_m: vessel.x_m, y_m: vessel.y_m, error_m: vessel.error_m,
    port_N: vessel.thrust_N?.[0], stbd_N: vessel.thrust_N?.[1],
    speed_mps: known_speed ? Math.hypot(vessel.u_mps, vessel.v_mps) : null,
  };
}
