// SPDX-License-Identifier: MIT
// Formats numbers for people; null and non-finite numbers are a dash.
const DASH = "–";
const SIDES = ["port", "stbd"];
// of an ESC: name, heading, digits
const ESC_CELLS = [["rpm", "rpm", 0], ["voltage_V", "V", 1], ["current_A", "A", 1], ["temperature_C", "°C", 0], ["errors", "errs", 0]];

const known = (x) => typeof x === "number" && Number.isFinite(x);

const numberOr = (x) => (known(x) ? x : null);

const pair = (x) => (Array.isArray(x) && x.length === 2 && x.every(known) ? x : null);

const fixed = (x, digits) => (known(x) ? x.toFixed(digits).replace("-", "−") : DASH);

const withUnit = (x, digits, unit) => (known(x) ? `${fixed(x, digits)} ${unit}` : DASH);

/** Metres: with millimetres if small, without decimals if large. */
const metres = (x) => withUnit(x, Math.abs(x) < 1 ? 3 : Math.abs(x) < 100 ? 2 : 0, "m");

/** Text for a boat in FORMATION that has not reached its slot: "closing, 9.5 m". */
const isClosing = (vessel) => vessel.state === "FORMATION" && known(vessel.in_slot) && vessel.in_slot < 1;
const closing = (vessel) => `closing, ${withUnit(vessel.error_m, 1, "m")}`;

/** An age in seconds. */
const age = (s) => withUnit(s, s < 10 ? 1 : 0, "s");

/** A heading in radians as degrees with three digits. */
function degrees(rad) {
  if (!known(rad)) return DASH;
  const whole = Math.round((rad * 180) / Math.PI);
  return `${String(((whole % 360) + 360) % 360).padStart(3, "0")}°`;
}

/** A time in seconds; from ten minutes on in minutes and seconds. */
function clock(s) {
  if (!known(s)) return DASH;
  if (s < 600) return `${fixed(s, 1)} s`;
  const whole = Math.floor(s);
  return `${Math.floor(whole / 60)}:${String(whole % 60).padStart(2, "0")} min`;
}

function bytes(n) {
  if (!known(n)) return DASH;
  return n < 1000 ? `${Math.round(n)} B` : n < 1e6 ? `${fixed(n / 1e3, 1)} kB` : `${fixed(n / 1e6, 1)} MB`;
}

/** 1, 2 or 5 times a power of ten, not above x. */
function roundDown(x) {
  const power = 10 ** Math.floor(Math.log10(x));
  return power * (x >= 5 * power ? 5 : x >= 2 * power ? 2 : 1);
}
