// SPDX-License-Identifier: MIT
// One row per vessel; a card with all its values for a vessel in trouble or selected. A value that a
// vessel no longer sends is "unknown"; a value that no vessel ever sent is left out.
const LATE_S = 1.5;
const UNKNOWN = "unknown";
const FACTS = [
  ["error_m", "from slot", (v) => metres(v.error_m)],
  ["speed_mps", "speed", (v) => withUnit(tracked(v).speed_mps, 2, "m/s")],
  ["battery_V", "battery", (v) => withUnit(v.battery_V, 1, "V")],
  ["psi_rad", "heading", (v) => degrees(v.psi_rad)],
  ["link_age_s", "heard", (v) => (known(v.link_age_s) ? `${age(v.link_age_s)} ago` : DASH)],
  ["leader_age_s", "leader's state", (v) => (known(v.leader_age_s) ? `${age(v.leader_age_s)} old` : DASH)],
];
const IN_ROWS = 3; // the first of them are shown in a row too

function element(tag, parent, attributes = {}) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name === "text") made.textContent = value;
    else made.setAttribute(name, value);
  }
  parent?.append(made);
  return made;
}

/** Sets a text only if it changed, to save the browser a layout. */
function say(place, text) {
  if (place.textContent !== text) place.textContent = text;
}

function style(place, name, value) {
  if (place.style.getPropertyValue(name) !== value) place.style.setProperty(name, value);
}

function hide(place, hidden) {
  if (place.hidden !== hidden) place.hidden = hidden;
}

class Card {
  constructor(vessel, parent, choose, filled) {
    this.filled = filled; // names of values that some vessel has sent
    this.told = new Set(); // names of values that this one has sent
    this.root = element("article", parent, { "aria-label": nameOf(vessel) });
    const head = element("div", this.root, { class: "head" });
    this.name = element("button", element("h3", head), { title: "follow in the plan view, and show all it says", text: nameOf(vessel) });
    this.name.addEventListener("click", () => choose(vessel.key));
    this.state = element("span", head, { class: "state" });
    this.follows = element("span", head, { class: "follows" });
    this.why = element("p", this.root, { class: "why held" });
    this.text = element("p", this.root, { class: "why said" });
    const list = element("dl", this.root);
    this.facts = FACTS.map(([, label], i) => {
      const row = element("div", list, { class: i < IN_ROWS ? "" : "more", hidden: "" });
      element("dt", row, { text: label });
      return [row, element("dd", row)];
    });
    this.makeDrives();
  }

  /** One row per propeller: thrust against its limits, and its ESC's telemetry. */
  makeDrives() {
    this.table = element("table", this.root, { hidden: "", "aria-label": "Propellers and ESCs" });
    const head = element("tr", element("thead", this.table));
    for (const text of ["", "", "N"]) element("th", head, { text });
    const heads = ESC_CELLS.map(([, text]) => element("th", head, { text, scope: "col" }));
    const body = element("tbody", this.table);
    this.drives = SIDES.map((side) => {
      const row = element("tr", body, { class: side });
      element("th", row, { text: side, scope: "row" });
      const bar = element("i", element("td", row, { class: "gauge" }));
      return { bar, thrust: element("td", row), escs: ESC_CELLS.map(() => element("td", row, { class: "esc" })) };
    });
    this.escColumns = ESC_CELLS.map(([name], i) => [name, [heads[i], ...this.drives.map(({ escs }) => escs[i])]]);
  }

  /** The text; without a value "unknown" if this vessel ever sent one, else nothing. */
  read(name, text) {
    if (text !== DASH) {
      this.told.add(name);
      this.filled.add(name);
      return text;
    }
    return this.told.has(name) ? UNKNOWN : "";
  }

  show(vessel, byId, chosen) {
    const silent = isSilent(vessel), troubles = troublesOf(vessel), whole = chosen || troubles.length > 0;
    this.rank = troubles.length ? 0 : vessel.kind === "leader" ? 2 : 1;
    style(this.root, "--boat", colourOf(vessel));
    const name = `card ${whole ? "whole" : "row"}${troubles.length ? " trouble" : ""}${chosen ? " chosen" : ""}${silent ? " stale" : ""}`;
    if (this.root.className !== name) this.root.className = name;
    this.name.setAttribute("aria-pressed", String(chosen));
    this.showState(vessel, silent);
    // the last values of a silent vessel are outdated
    FACTS.forEach(([fact, , read], i) => {
      const text = this.read(fact, silent && fact !== "link_age_s" ? DASH : read(vessel));
      const [row, place] = this.facts[i];
      hide(row, !this.filled.has(fact) || (whole && !text));
      say(place, text);
      if (fact === "link_age_s") place.className = silent ? "age" : vessel[fact] > LATE_S ? "late" : "";
    });
    if (!whole) return;
    const leader = byId.get(vessel.leader);
    say(this.follows, vessel.leader === null || vessel.leader === 0 ? "" : leader?.kind === "leader" ? "follows leader" : `follows ${vessel.leader}`);
    say(this.why, troubles.join("; "));
    const ago = known(vessel.text_age_s) ? ` ${age(vessel.text_age_s)} ago` : "";
    say(this.text, vessel.text && vessel.text !== vessel.state ? `“${vessel.text}”${ago}` : "");
    this.showDrives(silent ? { ...vessel, thrust_N: null, escs: [] } : vessel);
  }

  showState(vessel, silent) {
    const state = silent ? null : vessel.state;
    const unknown = silent || vessel.stateLost ? UNKNOWN : vessel.kind === "leader" && !vessel.plan_of ? "virtual" : "";
    say(this.state, isClosing(vessel) && !silent ? "closing" : state ?? unknown);
    const name = `state ${silent ? "" : isClosing(vessel) ? "closing" : state ?? ""}`;
    if (this.state.className !== name) this.state.className = name;
  }

  showDrives({ thrust_N, limits_N, escs }) {
    const [low, high] = limits_N ?? [0, 0], wide = high - low;
    for (const [name] of ESC_CELLS) for (const esc of escs) this.read(name, fixed(esc[name], 0));
    const percent = (value) => (wide > 0 ? (100 * (Math.min(Math.max(value, low), high) - low)) / wide : 50);
    this.drives.forEach((row, side) => {
      const thrust = thrust_N?.[side], zero = percent(0), end = known(thrust) ? percent(thrust) : zero;
      say(row.thrust, this.read("thrust", fixed(thrust, 1)));
      style(row.bar, "--zero", `${zero.toFixed(1)}%`);
      style(row.bar, "--from", `${Math.min(zero, end).toFixed(1)}%`);
      style(row.bar, "--wide", `${Math.abs(end - zero).toFixed(1)}%`);
      ESC_CELLS.forEach(([name, , digits], i) => say(row.escs[i], this.read(name, fixed(escs[side]?.[name], digits))));
    });
    for (const [name, cells] of this.escColumns) for (const cell of cells) hide(cell, !this.told.has(name));
    hide(this.table, !this.told.has("thrust") && !this.escColumns.some(([name]) => this.told.has(name)));
  }
}

class Cards {
  constructor(place, choose) {
    this.place = place;
    this.choose = choose;
    this.cards = new Map();
    this.filled = new Set();
    this.heads = element("div", place, { class: "heads", "aria-hidden": "true" });
    element("span", this.heads);
    this.headsOf = FACTS.slice(0, IN_ROWS).map(([name, text]) => [name, element("span", this.heads, { text })]);
  }

  clear() {
    for (const card of this.cards.values()) card.root.remove();
    this.cards.clear();
    this.filled.clear();
  }

  show(vessels, chosen) {
    const byId = new Map(vessels.map((vessel) => [vessel.id, vessel]));
    const here = new Map(vessels.map((vessel) => [`${vessel.key} ${vessel.kind}`, vessel]));
    for (const [name, card] of this.cards) {
      if (here.has(name)) continue;
      card.root.remove();
      this.cards.delete(name);
    }
    for (const [name, vessel] of here) {
      if (!this.cards.has(name)) this.cards.set(name, new Card(vessel, this.place, this.choose, this.filled));
      this.cards.get(name).show(vessel, byId, vessel.key === chosen);
    }
    for (const [name, place] of this.headsOf) hide(place, !this.filled.has(name));
    hide(this.heads, ![...this.cards.values()].some(({ rank }) => rank > 0));
    this.sort([...here.keys()]);
  }

  /** Sorts: vessels in trouble, boats, virtual leaders; the column heads precede the rows. */
  sort(names) {
    const cards = names.map((name) => this.cards.get(name));
    const order = [0, 1, 2].flatMap((rank) => cards.filter((card) => card.rank === rank).map(({ root }) => root));
    const begin = cards.filter(({ rank }) => rank === 0).length;
    order.splice(begin, 0, this.heads);
    order.forEach((root, i) => {
      if (this.place.children[i] !== root) this.place.insertBefore(root, this.place.children[i] ?? null);
    });
  }
}
