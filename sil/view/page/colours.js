// SPDX-License-Identifier: MIT
// One colour per boat, as in all pictures; from the eighth boat on also another dash.
const CONFIG = JSON.parse(document.getElementById("config").textContent);
const DASHES = [[], [7, 3], [2, 2], [9, 3, 2, 3]];
const dark = window.matchMedia("(prefers-color-scheme: dark)");
let theme = {};

function readTheme() {
  const style = getComputedStyle(document.documentElement);
  theme = {};
  for (const name of ["paper", "panel", "water", "grid", "coast", "ink", "soft", "line", "stale", "good", "warn", "bad", "calm", "hand", "odd"]) {
    theme[name] = style.getPropertyValue(`--${name}`).trim();
  }
}

/** A colour for a dark background: a third closer to white, so that deep blue and wine are visible. */
function lighter(hex) {
  const parts = [1, 3, 5].map((i) => parseInt(hex.slice(i, i + 2), 16));
  return `rgb(${parts.map((p) => Math.round(p + (255 - p) * 0.33)).join(" ")})`;
}

const place = (id) => Math.max(0, id - 1);

function colourOf(vessel) {
  if (vessel.kind === "leader") return theme.ink;
  if (vessel.kind !== "boat") return theme.soft;
  const colour = CONFIG.colours[place(vessel.id) % CONFIG.colours.length];
  return dark.matches ? lighter(colour) : colour;
}

/** Black or white, whichever contrasts more with a colour, which the canvas gives as "#rrggbb". */
function readableOn(colour) {
  const linear = (x) => (x <= 0.04045 ? x / 12.92 : ((x + 0.055) / 1.055) ** 2.4);
  const [r, g, b] = (colour.startsWith("#") ? [1, 3, 5].map((i) => parseInt(colour.slice(i, i + 2), 16)) : colour.match(/\d+/g).map(Number)).map((x) => linear(x / 255));
  return 0.2126 * r + 0.7152 * g + 0.0722 * b > 0.179 ? "#000000" : "#ffffff";
}

function dashOf(vessel) {
  if (vessel.kind === "leader") return [4, 3];
  return DASHES[Math.floor(place(vessel.id) / CONFIG.colours.length) % DASHES.length];
}

const STATE_THEME = {
  DISARMED: "calm", HOLD: "warn", MANUAL: "hand", FORMATION: "good", AUTO: "good", GUIDED: "good", LOITER: "good", RTL: "good", COAST: "warn", TEST: "odd", FAULT: "bad",
};

function nameOf(vessel) {
  if (vessel.kind === "leader") return vessel.plan_of ? `Plan of boat ${vessel.plan_of}` : `Leader ${vessel.id}`;
  return `${vessel.kind === "boat" ? "Boat" : "Vessel"} ${vessel.id}`;
}
