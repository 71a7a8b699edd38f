// SPDX-License-Identifier: MIT
// A card a vessel: state, why, ages, numbers, ESCs. Rows that were never known are not shown.
const LATE_S = 1.5;
const FACTS = [
  ["error_m", "from slot", (v) => metres(v.error_m)],
  ["speed", "speed", (v) => withUnit(tracked(v).speed_mps, 2, "m/s")],
  ["psi_rad", "heading", (v) => degrees(v.psi_rad)],
  ["link_age_s", "heard", (v) => (known(v.link_age_s) ? `${age(v.link_age_s)} ago` : DASH)],
  ["leader_age_s", "leader's state", (v) => (known(v.leader_age_s) ? `${age(v.leader_age_s)} old` : DASH)],
  ["battery_V", "battery", (v) => withUnit(v.battery_V, 1, "V")],
];

function element(tag, parent, attributes = {}) {
  const made = document.createElement(tag);
  for (const [name, value] of Object.entries(attributes)) {
    if (name === "text") made.textContent = value;
    else made.setAttribute(name, value);
  }
  parent?.append(made);
  return made;
}

/** Sets a text only where it is another: the browser lays out nothing else. */
function say(place, text) {
  if (place.textContent !== text) place.textContent = text;
}

function style(place, name, value) {
  if (place.style.getPropertyValue(name) !== value) place.style.setProperty(name, value);
}

class Card {
  constructor(vessel, parent, choose) {
    this.root = element("article", parent, { class: "card", "aria-label": nameOf(vessel) });
    const head = element("div", this.root);
    this.name = element("button", element("h3", head), { title: "follow in the plan view", text: nameOf(vessel) });
    this.name.addEventListener("click", () => choose(vessel.key));
    this.follows = element("span", head, { class: "follows" });
    this.state = element("span", head, { class: "state" });
    this.why = element("p", this.root, { class: "why held" });
    this.text = element("p", this.root, { class: "why said" });
    this.facts = this.makeFacts();
    this.drives = this.makeDrives();
  }

  makeFacts() {
    const list = element("dl", this.root);
    return FACTS.map(([, label]) => {
      const row = element("div", list, { hidden: "" });
      element("dt", row, { text: label });
      return [row, element("dd", row)];
    });
  }

  /** A row a propeller: thrust against its limits, and what its ESC says. */
  makeDrives() {
    const table = element("table", this.root, { hidden: "", "aria-label": "Propellers and ESCs" });
    const head = element("tr", element("thead", table));
    for (const text of ["", "", "N"]) element("th", head, { text });
    for (const [, text] of ESC_CELLS) element("th", head, { text, class: "esc", scope: "col" });
    const body = element("tbody", table);
    const rows = SIDES.map((side) => {
      const row = element("tr", body);
      element("th", row, { text: side, scope: "row" });
      const bar = element("i", element("td", row, { class: "gauge" }));
      return { bar, thrust: element("td", row), escs: ESC_CELLS.map(() => element("td", row, { class: "esc" })) };
    });
    return { table, rows };
  }

  show(vessel, byId, chosen) {
    style(this.root, "--boat", colourOf(vessel));
    this.root.className = `card${chosen ? " chosen" : ""}${isSilent(vessel) ? " stale" : ""}`;
    this.name.setAttribute("aria-pressed", String(chosen));
    const leader = byId.get(vessel.leader);
    const virtual = leader ? leader.kind === "leader" : false;
    say(this.follows, vessel.leader === null || vessel.leader === 0 ? "" : virtual ? "follows leader" : `follows ${vessel.leader}`);
    say(this.state, isClosing(vessel) ? closing(vessel) : vessel.state ?? (vessel.kind === "leader" ? "virtual" : ""));
    this.state.className = `state ${isClosing(vessel) ? "closing" : vessel.state ?? ""}`;
    say(this.why, isSilent(vessel) ? `silent for ${age(vessel.link_age_s)}` : vessel.held.join("; "));
    say(this.text, vessel.text && vessel.text !== vessel.state ? `“${vessel.text}”` : "");
    FACTS.forEach(([name, , read], i) => {
      const [row, place] = this.facts[i], text = read(vessel);
      if (text !== DASH) row.hidden = false;
      say(place, text);
      place.className = name === "link_age_s" ? (isSilent(vessel) ? "age" : vessel[name] > LATE_S ? "late" : "") : "";
    });
    this.showDrives(vessel);
  }

  showDrives({ thrust_N, limits_N, escs }) {
    if (thrust_N || escs.length) this.drives.table.hidden = false;
    if (escs.length) this.drives.table.className = "with-escs";
    const [low, high] = limits_N ?? [0, 0], wide = high - low;
    const percent = (value) => (wide > 0 ? (100 * (Math.min(Math.max(value, low), high) - low)) / wide : 50);
    this.drives.rows.forEach((row, side) => {
      const thrust = thrust_N?.[side], zero = percent(0), end = known(thrust) ? percent(thrust) : zero;
      say(row.thrust, fixed(thrust, 1));
      style(row.bar, "--zero", `${zero.toFixed(1)}%`);
      style(row.bar, "--from", `${Math.min(zero, end).toFixed(1)}%`);
      style(row.bar, "--wide", `${Math.abs(end - zero).toFixed(1)}%`);
      ESC_CELLS.forEach(([name, , digits], i) => say(row.escs[i], fixed(escs[side]?.[name], digits)));
    });
  }
}

class Cards {
  constructor(place, choose) {
    this.place = place;
    this.choose = choose;
    this.cards = new Map();
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
      if (!this.cards.has(name)) {
        this.cards.set(name, new Card(vessel, this.place, this.choose));
        this.sort([...here.keys()]);
      }
      this.cards.get(name).show(vessel, byId, vessel.key === chosen);
    }
  }

  sort(order) {
    const cards = order.map((name) => this.cards.get(name)).filter(Boolean);
    cards.forEach((card, i) => {
      if (this.place.children[i] !== card.root) this.place.insertBefore(card.root, this.place.children[i] ?? null);
    });
  }
}
