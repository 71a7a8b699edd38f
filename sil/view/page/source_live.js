// SPDX-License-Identifier: MIT
// The live source: frames from the view's WebSocket. Counts and ignores invalid ones.
const SILENT_MS = 3000, LOAD_MS = 30000;
const RETRY_MS = [250, 500, 1000, 2000];
const NUMBERS = ["x_m", "y_m", "psi_rad", "u_mps", "v_mps", "length_m", "leader", "error_m", "in_slot", "conditions_lost_s", "senders", "unknown_mode", "link_age_s", "place_age_s", "leader_age_s", "text_age_s", "battery_V", "item"];
const STATES = CONFIG.supervisor.states;

const textOr = (x) => (typeof x === "string" ? x : null);

/** A vessel with every member that the page reads, of the right type or null; null without an id. */
function cleanVessel(raw) {
  if (raw === null || typeof raw !== "object" || !Number.isInteger(raw.id)) return null;
  const out = { id: raw.id, key: `${raw.id}`, kind: ["boat", "leader"].includes(raw.kind) ? raw.kind : "vessel" };
  for (const name of NUMBERS) out[name] = numberOr(raw[name]);
  for (const name of ["slot", "thrust_N", "limits_N"]) out[name] = pair(raw[name]);
  out.state = STATES.includes(raw.state) ? raw.state : null;
  out.stateLost = out.kind === "boat" && raw.state === null && !isSilent(out);
  out.held = Array.isArray(raw.held) ? raw.held.filter((x) => typeof x === "string") : [];
  out.text = textOr(raw.text);
  const escs = Array.isArray(raw.escs) ? raw.escs.slice(0, 2) : [];
  out.escs = escs.map((esc) => (esc !== null && typeof esc === "object" ? esc : {}));
  return out;
}

const isText = (x) => Array.isArray(x) && x.length === 5 && x.slice(0, 3).every(known) && typeof x[4] === "string";

/** The frame in a received message; null if invalid. `over`: it was the last. */
function cleanFrame(text) {
  let raw;
  try {
    raw = JSON.parse(text);
  } catch {
    return null;
  }
  if (raw?.over === true) return { over: true };
  if (raw === null || typeof raw !== "object" || !known(raw.t_s) || !Array.isArray(raw.vessels)) return null;
  const unique = new Map();
  for (const vessel of raw.vessels.map(cleanVessel)) if (vessel) unique.set(vessel.id, vessel);
  const vessels = [...unique.values()].sort((a, b) => a.id - b.id);
  const texts = Array.isArray(raw.texts) ? raw.texts.filter(isText) : [];
  return { t_s: raw.t_s, plans: cleanPlans(raw.plans), texts, table: textOr(raw.table), origin: pair(raw.origin_deg), heard: raw.heard && typeof raw.heard === "object" ? raw.heard : {}, vessels };
}

class LiveSource {
  /**
   * `changed` is called after each frame, and with true whenever the connection opens or closes; `over`
   * at the end, with the history of everything heard.
   */
  constructor(changed, over) {
    this.changed = changed;
    this.over = over;
    this.frame = { t_s: 0, origin: null, heard: {}, vessels: [] };
    this.events = [];
    this.changes = new Changes();
    this.texts = 0; // number of the last one
    this.tracks = new Map();
    this.plans = new Map();
    this.garbage = 0;
    this.frames = 0;
    this.tries = 0;
    this.status = ["warn", "connecting"];
    this.connect();
  }

  get cut() {
    return this.status[0] === "bad";
  }

  connect() {
    const url = new URL("live", location.href);
    url.protocol = url.protocol === "https:" ? "wss:" : "ws:";
    url.hash = url.search = "";
    const socket = new WebSocket(url);
    socket.onopen = () => {
      this.watch();
      // after a loss, the frame shown is old until the first new one
      this.say(this.cut ? "bad" : "warn", "connected, waiting for the first frame");
    };
    socket.onmessage = (event) => this.take(event.data);
    socket.onclose = () => this.renew("connection to the view lost, trying again");
    this.socket = socket;
    this.watch();
  }

  /** Renews the connection unless a frame arrives within 3 s. */
  watch() {
    clearTimeout(this.watchdog);
    this.watchdog = setTimeout(() => this.renew("the view says nothing any more, trying again"), SILENT_MS);
  }

  /** Replaces the connection; a half-open one would take a minute to close. */
  renew(why) {
    this.drop();
    this.say("bad", why);
    setTimeout(() => this.connect(), RETRY_MS[Math.min(this.tries++, RETRY_MS.length - 1)]);
  }

  drop() {
    clearTimeout(this.watchdog);
    this.socket.onopen = this.socket.onmessage = this.socket.onclose = null;
    this.socket.close();
  }

  say(kind, text) {
    if (this.status[0] === kind && this.status[1] === text) return;
    this.status = [kind, text];
    this.changed(true);
  }

  take(data) {
    const frame = typeof data === "string" ? cleanFrame(data) : null;
    if (frame === null) {
      this.garbage += 1;
      return;
    }
    if (frame.over) {
      this.end();
      return;
    }
    this.watch();
    this.tries = 0;
    this.frames += 1;
    this.status = ["good", "live"];
    // a restarted view counts from 0
    if (frame.t_s < this.frame.t_s - 1) this.forget();
    // plans come now and then only, as they are long
    if (frame.plans) this.plans = frame.plans;
    for (const vessel of frame.vessels) vessel.plan = this.plans.get(vessel.id) ?? null;
    this.frame = frame;
    const here = new Set(frame.vessels.map((vessel) => vessel.key));
    for (const key of this.tracks.keys()) if (!here.has(key)) this.tracks.delete(key);
    this.listen(frame);
    for (const vessel of frame.vessels) {
      this.track(vessel.key).push(frame.t_s, vessel);
      this.events.push(...this.changes.of(frame.t_s, vessel));
    }
    if (this.events.length > MOST_EVENTS) this.events.splice(0, this.events.length - MOST_EVENTS);
    this.changed();
  }

  /** Lists the texts that are new to this page; when it opens, the last ones from before. */
  listen({ texts, vessels }) {
    const byId = new Map(vessels.map((vessel) => [vessel.id, vessel]));
    for (const [number, t_s, id, severity, text] of texts) {
      if (number <= this.texts) continue;
      this.texts = number;
      const event = byId.has(id) ? eventOf(t_s, byId.get(id), "texts", text, severity) : null;
      if (event) this.events.push(event);
    }
  }

  forget() {
    this.texts = 0;
    this.tracks.clear();
    this.plans = new Map();
    [this.events, this.changes] = [[], new Changes()];
  }

  /** The server has stopped listening: continue as a replay. */
  async end() {
    this.drop();
    this.say("bad", "the view has ended, loading what it heard");
    let history;
    try {
      history = await (await fetch("history", { signal: AbortSignal.timeout(LOAD_MS) })).json();
    } catch {
      this.renew("what the view heard cannot be loaded, trying again");
      return;
    }
    this.over(history);
  }

  track(key) {
    if (!this.tracks.has(key)) this.tracks.set(key, new Track());
    return this.tracks.get(key);
  }
}
