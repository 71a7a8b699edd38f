// SPDX-License-Identifier: MIT
// The firmware's supervisor, by the firmware's own table: the first matching row decides.

/** The most careful reaction to what is lost in a state; has: names of met conditions and choices. */
function reactionTo(state, has) {
  const { losses, choices } = CONFIG.supervisor;
  const CARE = ["HOLD", "LOITER", "RTL", "COAST", "MANUAL", "none"];
  const chosen = (name) => {
    const { reactions, default: usual } = choices.find((choice) => choice.name === name);
    const value = [...reactions.keys()].findLast((number) => has.has(`${name} ${number}`));
    return reactions[value ?? usual];
  };
  let worst = "none";
  for (const { in: states, needs, choice } of losses) {
    const lost = states.includes(state) && !needs.every((name) => has.has(name));
    if (lost && CARE.indexOf(chosen(choice)) < CARE.indexOf(worst)) worst = chosen(choice);
  }
  if (worst !== "COAST" && worst !== "MANUAL") return worst;
  if (state === "COAST") return has.has("coast_running") ? "COAST" : chosen("FS_COAST_ACT");
  return state === "FORMATION" ? worst : "HOLD";
}

/**
 * Applies the table to a state, a request and the names of met conditions and choices. Returns the new
 * state, whether the request was granted, missing and lost conditions, whether propellers may turn, and
 * the row that decided.
 */
function supervise(state, request, met) {
  const { table, drives } = CONFIG.supervisor;
  const has = new Set(met);
  const reaction = reactionTo(state, has);
  const mayDrive = (now) => now in drives && drives[now].every((name) => has.has(name));
  let missing = [];
  for (const [i, row] of table.entries()) {
    if (!row.from.includes(state) || row.request !== request) continue;
    if (row.on.length && !row.on.includes(reaction)) continue;
    const unmet = row.needs.filter((name) => !has.has(name));
    const lost = row.lacks.filter((name) => !has.has(name));
    if (!unmet.length && (!row.lacks.length || lost.length)) {
      return { state: row.to, granted: true, missing: lost, drives: mayDrive(row.to), row: i };
    }
    missing = unmet;
  }
  const refused = request === "nothing" ? [] : missing;
  return { state, granted: false, missing: refused, drives: mayDrive(state), row: null };
}
