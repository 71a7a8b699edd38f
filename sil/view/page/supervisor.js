// SPDX-License-Identifier: MIT
// The firmware's supervisor, by the firmware's own table: the first matching row decides.

/** The most careful reaction to what is lost in a state, and what is; has: met conditions, choices. */
function responseTo(state, has) {
  const { losses, choices } = CONFIG.supervisor;
  const CARE = ["HOLD", "LOITER", "RTL", "COAST", "MANUAL", "none"];
  const chosen = (name) => {
    const { reactions, default: usual } = choices.find((choice) => choice.name === name);
    const value = [...reactions.keys()].findLast((number) => has.has(`${name} ${number}`));
    return reactions[value ?? usual];
  };
  let reaction = "none", lost = [];
  for (const { in: states, needs, choice } of losses) {
    const unmet = states.includes(state) ? needs.filter((name) => !has.has(name)) : [];
    const next = chosen(choice), more = CARE.indexOf(next) - CARE.indexOf(reaction);
    if (!unmet.length || more > 0) continue;
    lost = more ? unmet : [...lost, ...unmet];
    reaction = next;
  }
  if (reaction !== "COAST" && reaction !== "MANUAL") return { reaction, lost };
  if (state === "FORMATION") return { reaction, lost };
  if (state !== "COAST") return { reaction: "HOLD", lost };
  if (has.has("coast_running")) return { reaction: "COAST", lost };
  return { reaction: chosen("FS_COAST_ACT"), lost: ["coast_running"] };
}

/**
 * Applies the table to a state, a request and the names of met conditions and choices. Returns the new
 * state, whether the request was granted, missing and lost conditions, whether propellers may turn, and
 * the row that decided.
 */
function supervise(state, request, met) {
  const { table, drives } = CONFIG.supervisor;
  const has = new Set(met);
  const response = responseTo(state, has);
  const mayDrive = (now) => now in drives && drives[now].every((name) => has.has(name));
  let missing = [];
  for (const [i, row] of table.entries()) {
    if (!row.from.includes(state) || row.request !== request) continue;
    if (row.on.length && !row.on.includes(response.reaction)) continue;
    const unmet = row.needs.filter((name) => !has.has(name));
    const lost = row.lacks.filter((name) => !has.has(name));
    if (!unmet.length && (!row.lacks.length || lost.length)) {
      const blamed = row.on.length ? row.lacks.filter((name) => response.lost.includes(name)) : lost;
      return { state: row.to, granted: true, missing: blamed, drives: mayDrive(row.to), row: i };
    }
    missing = unmet;
  }
  const refused = request === "nothing" ? [] : missing;
  return { state, granted: false, missing: refused, drives: mayDrive(state), row: null };
}
