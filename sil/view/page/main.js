// SPDX-License-Identifier: MIT
// Assembles the page: a source of frames, the views, user input.
// redraw intervals of each view, for few vessels and, live, for many
const PLAN_MS = [95, 240], CARDS_MS = [250, 500], PLOTS_MS = [500, 2000], MANY = 8, MOST_PLOTTED = 40;
const WINDOWS_S = [30, 60, 120, 300, 600];
const byName = (id) => document.getElementById(id);
const PAGES = ["fleet", "what-if"];

readTheme();
let source = null, player = null, plots = null, whatIf = null;
let paused_ms = null; // time of the pause of a live page
let shown = null, drawing = false, touched = true, later = 0;
const due = { plan: 0, cards: 0, plots: 0 };

/** Requests a redraw: at once after user input, else when the next is due. */
function schedule(at_once = false) {
  touched ||= at_once;
  if (drawing) return;
  drawing = true;
  const wait = at_once ? 0 : Math.max(0, due.plan - performance.now());
  setTimeout(() => requestAnimationFrame(draw), wait);
}

function window_s() {
  const chosen = Number(byName("window").value);
  return chosen > 0 ? chosen : Infinity;
}

function range(t_s) {
  const wide = window_s();
  if (!player) return [t_s - wide, t_s];
  return Number.isFinite(wide) ? [Math.max(source.begin_s, t_s - wide), Math.max(t_s, source.begin_s + wide)] : [source.begin_s, source.end_s];
}

function draw() {
  drawing = false;
  const now = performance.now(), every = touched;
  touched = false;
  if (paused_ms === null || shown === null) shown = source.frame;
  const many = !player && shown.vessels.length > MANY ? 1 : 0;
  const chosen = plan.camera.mode in { fleet: 0, free: 0 } ? null : plan.camera.mode;
  plan.draw(shown, window_s(), chosen);
  due.plan = now + (player ? 0 : plan.same_ms(shown.vessels, ...PLAN_MS));
  if (every || now >= due.cards) {
    due.cards = now + CARDS_MS[many];
    noteClose(shown.vessels);
    cards.show(shown.vessels, chosen);
    tell(shown, chosen);
    tellFleet(source.frame);
    events.draw(source, player ? [source.begin_s, source.end_s] : range(shown.t_s), shown.t_s);
  }
  if (plots && (every || now >= due.plots)) {
    due.plots = now + PLOTS_MS[many];
    drawPlots(chosen, every);
  }
  if (plots && player) plots.cursor(shown.t_s);
  // views not due yet are drawn later, even if no further frame arrives
  const wait = Math.max(0, Math.max(due.cards, plots ? due.plots : 0) - performance.now());
  clearTimeout(later);
  if (!every) later = setTimeout(() => schedule(true), wait);
}

let drawnPlots = "";

function drawPlots(chosen, every) {
  const [from, to] = range(shown.t_s);
  const wanted = `${from} ${to} ${chosen} ${dark.matches} ${plots.charts.error.width}`;
  if (player && wanted === drawnPlots) return;
  if (paused_ms !== null && !every) return;
  drawnPlots = wanted;
  const plotted = shown.vessels.filter((vessel, i) => i < MOST_PLOTTED || vessel.key === chosen);
  plots.draw(plotted, from, to, chosen);
}

/** Shows connection, alarms and traffic of the newest frame, also while an older one is shown. */
function tellFleet(frame) {
  const [kind, text] = source.status, paused = paused_ms !== null;
  byName("status").setAttribute("aria-live", paused ? "off" : "polite"); // not every second
  say(byName("status"), paused ? `paused for ${fixed((performance.now() - paused_ms) / 1000, 0)} s` : text);
  byName("status").className = paused ? "warn" : kind;
  document.body.classList.toggle("cut", source.cut || paused);
  alarm(source.cut ? text : frame.heard?.alarm);
  noteClose(frame.vessels);
  for (const [name, line] of Object.entries(fleetLine(frame.vessels))) say(byName(`line-${name}`), line);
  say(byName("line-table"), frame.table ?? "");
  const troubles = byName("line-troubles").textContent, isWell = !troubles || troubles.startsWith("none");
  byName("line-troubles").className = isWell ? "good" : "bad";
  if (!player) entitle(source.cut ? text : isWell ? "" : troubles);
  if (frame.heard) {
    const { address, bytes_per_s, damaged, ignored } = frame.heard;
    const garbage = source.garbage ? ` · ${source.garbage} frames not understood` : "";
    const parts = [address ?? "", `${bytes(bytes_per_s)}/s`, `${frame.vessels.length} vessels`, `${bytes(damaged)} damaged`, `${fixed(ignored, 0)} messages ignored`];
    say(byName("heard"), source.frames ? parts.join(" · ") + garbage : "");
  }
}

/** Shows the clock, and which vessels the view can follow. */
function tell(frame, chosen) {
  byName("nothing").hidden = frame.vessels.length > 0;
  say(byName("nothing"), frame.heard?.bytes_per_s > 0 ? "Bytes come in, but no vessel's HEARTBEAT is among them: check the baud rate, and that this is MAVLink." : "Nothing is heard yet.");
  say(byName("clock"), clock(frame.t_s));
  say(byName("pause"), player ? (player.playing ? "Pause" : "Play") : paused_ms !== null ? "Go on" : "Pause");
  byName("pause").setAttribute("aria-label", byName("pause").textContent);
  const planned = frame.vessels.some(({ plan }) => plan?.way.length) ? [["plans", "fleet and plans"]] : [];
  const options = [["fleet", "whole fleet"], ...planned, ["free", "free"], ...frame.vessels.map((vessel) => [vessel.key, nameOf(vessel)])];
  fill(byName("centre"), options, plan.camera.mode);
}

/** Puts what is wrong before a live page's title, which a tab shows. */
function entitle(wrong) {
  const title = [wrong, byName("title").textContent].filter(Boolean).join(" · ");
  if (document.title !== title) document.title = title;
}

/** Shows in red why nothing is heard; hidden if all is well. */
function alarm(text) {
  hide(byName("alarm"), typeof text !== "string");
  say(byName("alarm"), typeof text === "string" ? text : "");
}

/** Sets a select's options if they changed. */
function fill(select, options, value) {
  const wanted = options.map(([, text]) => text).join("\n");
  if (select.dataset.options !== wanted) {
    select.replaceChildren(...options.map(([key, text]) => new Option(text, key)));
    select.dataset.options = wanted;
  }
  if (select.value !== value) select.value = value;
}

function centreOn(mode) {
  plan.camera.mode = mode;
  plan.camera.placed = false;
  schedule(true);
}

function togglePause() {
  if (player) player.toggle();
  else paused_ms = paused_ms === null ? performance.now() : null;
  schedule(true);
}

function openPage(name) {
  for (const page of PAGES) {
    byName(page).hidden = page !== name;
    byName(`tab-${page}`).setAttribute("aria-selected", String(page === name));
  }
  if (name === "what-if") {
    whatIf ??= new WhatIf();
    whatIf.offer((shown ?? source.frame).vessels);
  }
  schedule(true);
}

/** Replays a history: the page's own, or that of a live view. */
function replay(history) {
  document.body.className = "replay";
  byName("line-troubles").setAttribute("aria-live", "off"); // they are not of now
  byName("title").textContent = document.title = history.title;
  source = new ReplaySource(history);
  player = new Player(source, () => schedule(!player?.playing));
  fill(byName("window"), [["0", "all"], ...WINDOWS], "0");
  say(byName("heard"), "");
  [paused_ms, shown] = [null, null];
  plan.camera.placed = false;
  cards.clear();
  plots?.follow(source);
  player.begin(byName("plan"));
  schedule(true);
}

const ruler = new Ruler();
const chart = new SeaChart(() => schedule(true));
const plan = new Plan(byName("plan"), { track: (key) => source.track(key) }, chart, ruler);
const cards = new Cards(byName("cards"), (key) => centreOn(plan.camera.mode === key ? "fleet" : key));
const events = new Events(byName("events"), byName("event-track"), ({ t_s, key }) => (player ? player.seek(t_s) : centreOn(key)));
const WINDOWS = WINDOWS_S.map((s) => [`${s}`, s < 60 ? `${s} s` : `${s / 60} min`]);
const given = JSON.parse(byName("history").textContent);

if (given !== null) replay(given);
else {
  fill(byName("window"), WINDOWS, "60");
  source = new LiveSource((at_once) => schedule(at_once), replay);
}
listen();
schedule(true);
// the plots of the library follow after the first picture
setTimeout(() => {
  plots = new Plots(source);
  schedule(true);
}, 0);
openPage(location.hash === "#what-if" ? "what-if" : "fleet");
window.flotilla = { supervise, cleanFrame, plan, cards, chart, ruler, get shown() { return shown; }, get source() { return source; }, get plots() { return plots; }, get player() { return player; } };
