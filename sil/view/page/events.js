// SPDX-License-Identifier: MIT
// Events: changes of state, unmet conditions, texts, silence. Shown as a list and as marks over time.
const MOST_EVENTS = 400, MOST_READ = 5;
/** By kind of change: its colour and text, or null if it is not an event. */
const TOLD = {
  states: (state) => [STATE_THEME[state], state],
  held: (held) => (held.length ? ["bad", held.join("; ")] : ["good", "nothing is missing any more"]),
  texts: (text, severity) => (STATES.includes(text) ? null : [ofSeverity(severity), `“${text}”`]),
  silent: (silent) => (silent ? ["bad", `silent for ${SILENT_S} s`] : ["good", "heard again"]),
};

/** The colour of a MAV_SEVERITY, which may be unknown. */
const ofSeverity = (severity) => (!known(severity) || severity > 4 ? "calm" : severity > 3 ? "warn" : "bad");

function eventOf(t_s, vessel, what, value, severity = null) {
  const told = value === null ? null : TOLD[what](value, severity);
  return told && { t_s, key: vessel.key, name: nameOf(vessel), colour: told[0], text: told[1] };
}

/** Changes from one live frame to the next; texts are numbered, as a frame may have several. */
class Changes {
  constructor() {
    this.before = new Map();
  }

  of(t_s, vessel) {
    const out = [];
    for (const [what, value] of [["states", vessel.state], ["held", vessel.held], ["silent", isSilent(vessel)]]) {
      const name = `${vessel.key} ${what}`, before = this.before.get(name), now = JSON.stringify(value);
      if (before === undefined || value !== null) this.before.set(name, now);
      if (before !== undefined && before !== now && value !== null) out.push(eventOf(t_s, vessel, what, value));
    }
    return out.filter(Boolean);
  }
}

/** All events of a vessel of a history. */
function eventsOf(vessel, t) {
  const out = [];
  for (const what of ["states", "held", "texts"]) {
    for (const [t_s, value] of vessel[what] ?? []) {
      if (t_s > t[0]) out.push(eventOf(t_s, vessel, what, value, holding(vessel.severities, t_s, null)));
    }
  }
  const ages = vessel.columns.link_age_s ?? [];
  for (let i = 1; i < ages.length; i += 1) {
    const silent = ages[i] > SILENT_S;
    if (silent !== ages[i - 1] > SILENT_S) out.push(eventOf(t[i], vessel, "silent", silent));
  }
  return out.filter(Boolean);
}

class Events {
  /** `pick` is called with the event that the user selects. */
  constructor(list, track, pick) {
    Object.assign(this, { list, track, pick });
    this.drawn = "";
    this.marked = null;
    this.rows = [];
  }

  /** Shows the events of `source` between two times; a replay's list follows its time `t_s`. */
  draw(source, [from_s, to_s], t_s) {
    const { events } = source;
    const listed = `${source.begin_s ?? "live"} ${events.length} ${events[events.length - 1]?.t_s}`;
    if (listed !== this.listed) {
      this.listed = listed;
      this.fill(events.slice(-MOST_EVENTS), source);
    }
    if (source.begin_s !== undefined) this.mark(t_s);
    const { clientWidth: wide, clientHeight: high } = this.track;
    const drawn = `${listed} ${from_s} ${to_s} ${wide} ${dark.matches}`;
    if (drawn === this.drawn || !wide || (!events.length && this.drawn)) return;
    this.drawn = drawn;
    [this.track.width, this.track.height] = [wide, high];
    const ctx = this.track.getContext("2d");
    for (const event of events) {
      if (event.t_s < from_s || event.t_s > to_s) continue;
      ctx.fillStyle = theme[event.colour];
      ctx.fillRect(((wide - 2) * (event.t_s - from_s)) / (to_s - from_s || 1), event.colour === "bad" ? 0 : high / 2, 2, high);
    }
    this.track.setAttribute("aria-label", `${events.length} events over time; the list has them`);
  }

  /** A replay's events in order of time, live ones newest first. */
  fill(events, source) {
    const isLive = source.begin_s === undefined, order = isLive ? [...events].reverse() : events;
    if (isLive) this.read(order);
    this.rows = order.map((event) => {
      const row = element("li"), button = element("button", row, { type: "button" });
      element("span", button, { class: "when", text: clock(event.t_s) });
      element("b", button, { text: event.name });
      element("span", button, { class: "told", text: event.text, style: `color:var(--${event.colour})` });
      button.addEventListener("click", () => this.pick(event));
      return [event, row];
    });
    this.list.replaceChildren(...this.rows.map(([, row]) => row));
    const since = isLive ? " since this page was opened" : "";
    if (!order.length) element("li", this.list, { class: "none", text: `No change of state, fault or message${since}.` });
    this.marked = null;
  }

  /** Has a screen reader read the events that are new to the list. */
  read(order) {
    const before = order.indexOf(this.rows[0]?.[0]), fresh = order.slice(0, before < 0 ? MOST_READ : Math.min(before, MOST_READ));
    say(document.getElementById("newest"), fresh.map(({ name, text }) => `${name}: ${text}`).join(". "));
  }

  /** Highlights the last event before a replay's time and scrolls the list to it. */
  mark(t_s) {
    const row = this.rows.filter(([event]) => event.t_s <= t_s + 1e-3).pop()?.[1] ?? null;
    if (row === this.marked) return;
    this.marked?.removeAttribute("aria-current");
    row?.setAttribute("aria-current", "time");
    this.marked = row;
    this.list.scrollTop = row ? row.offsetTop - this.list.offsetTop - this.list.clientHeight / 2 : 0;
  }
}
