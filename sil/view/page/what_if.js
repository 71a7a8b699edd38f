// SPDX-License-Identifier: MIT
// The what-if panel: an interactive supervisor. Nothing in it reaches a boat.
const LONGEST_STORY = 30;
const PUSHES = "propellers may turn", STANDS = "propellers stand still";

class WhatIf {
  constructor() {
    const { conditions, states, requests, choices } = CONFIG.supervisor;
    this.complaints = new Map(conditions.map(({ name, complaint }) => [name, complaint]));
    this.state = "FORMATION";
    this.boxes = new Map();
    const places = Object.fromEntries(["verdict", "states", "requests", "choices", "boats", "conditions", "story"].map((id) => [id, document.getElementById(id)]));
    this.places = places;
    this.pills = states.map((state) => this.button(places.states, state, () => this.put(state)));
    for (const request of requests) if (request !== "nothing") this.button(places.requests, request, () => this.ask(request));
    for (const choice of choices) this.choice(choice);
    for (const condition of conditions) this.condition(condition);
    this.rows();
    this.put(this.state);
  }

  button(place, text, act) {
    const made = element("button", place, { text, type: "button" });
    made.addEventListener("click", act);
    return made;
  }

  choice({ name, reactions, default: usual }) {
    const label = element("label", this.places.choices);
    element("code", label, { text: name });
    const select = element("select", label, { id: name });
    reactions.forEach((reaction, value) => element("option", select, { value, text: `${value}: ${reaction}` }));
    select.value = usual;
    select.addEventListener("change", () => this.settle([`${name} is ${select.value} now`]));
  }

  condition({ name, complaint, limit }) {
    const label = element("label", this.places.conditions);
    const box = element("input", label, { type: "checkbox", id: `met-${name}` });
    box.checked = true;
    element("code", label, { text: limit ? `${name} (${limit})` : name });
    element("small", label, { text: `else: ${complaint}` });
    box.addEventListener("change", () => this.settle([`${name} ${box.checked ? "is met again" : "is lost"}`]));
    this.boxes.set(name, box);
  }

  rows() {
    const body = document.querySelector("#rows tbody");
    const everywhere = CONFIG.supervisor.states.length;
    this.tableRows = CONFIG.supervisor.table.map((row) => {
      const made = element("tr", body);
      const from = row.from.length === everywhere ? "any" : row.from.join(", ");
      for (const text of [from, row.request, row.needs.join(", "), row.lacks.join(", "), row.on.join(", "), row.to]) element("td", made, { text });
      return made;
    });
  }

  /** Names of the ticked conditions and the selected choices. */
  met() {
    const names = [...this.boxes].filter(([, box]) => box.checked).map(([name]) => name);
    const chosen = CONFIG.supervisor.choices.map(({ name }) => `${name} ${document.getElementById(name).value}`);
    return [...names, ...chosen];
  }

  why(missing) {
    return missing.map((name) => this.complaints.get(name) ?? name).join("; ");
  }

  put(state) {
    this.state = state;
    this.settle([`put into ${state}`]);
  }

  /** Makes a button for each boat whose state is known. */
  offer(vessels) {
    for (const made of this.places.boats.querySelectorAll("button")) made.remove();
    const boats = vessels.filter((vessel) => vessel.state !== null);
    this.places.boats.hidden = !boats.length;
    for (const boat of boats) this.button(this.places.boats, nameOf(boat), () => this.take(boat));
  }

  /** Loads a boat's present state and its missing conditions. */
  take({ id, state, held }) {
    for (const [name, box] of this.boxes) box.checked = !held.includes(this.complaints.get(name));
    this.state = state;
    this.settle([`as boat ${id} is: ${state}`]);
  }

  ask(request) {
    const before = this.state, verdict = supervise(before, request, this.met());
    this.state = verdict.state;
    const refused = verdict.missing.length ? `: ${this.why(verdict.missing)}` : `: ${before} does not allow it`;
    const told = verdict.granted ? `${request}: granted, ${before} → ${verdict.state}` : `${request}: refused${refused}`;
    this.settle([told], verdict);
  }

  /** Applies the automatic transitions, tick by tick, and shows the final state. */
  settle(told, asked = null) {
    let last = asked, moved = true;
    for (let ticks = 0; moved && ticks < CONFIG.supervisor.states.length; ticks += 1) {
      const next = supervise(this.state, "nothing", this.met());
      moved = next.granted && next.state !== this.state;
      if (!moved) break;
      const cause = next.missing.length ? this.why(next.missing) : "all is well again";
      told.push(`${this.state} → ${next.state} by itself: ${cause}`);
      this.state = next.state;
      last = next;
    }
    this.show(told, last);
  }

  show(told, verdict) {
    const { drives } = supervise(this.state, "nothing", this.met());
    this.pills.forEach((pill) => pill.setAttribute("aria-pressed", String(pill.textContent === this.state)));
    this.places.verdict.replaceChildren();
    this.places.verdict.className = this.state;
    const line = element("p", this.places.verdict);
    element("span", line, { class: `state ${this.state}`, text: this.state });
    element("span", line, { text: ` · ${drives ? PUSHES : STANDS}` });
    element("p", this.places.verdict, { text: told[told.length - 1], id: "because" });
    for (const text of told) this.places.story.prepend(element("li", null, { text }));
    while (this.places.story.children.length > LONGEST_STORY) this.places.story.lastChild.remove();
    const blamed = new Set(verdict?.missing ?? []);
    for (const [name, box] of this.boxes) {
      box.parentElement.className = `${box.checked ? "" : "lost"} ${blamed.has(name) ? "blamed" : ""}`;
    }
    this.tableRows.forEach((row, i) => row.classList.toggle("decided", verdict?.row === i));
  }
}
