// SPDX-License-Identifier: MIT
// The firmware's supervisor, by the firmware's own table: the first matching row decides.

/**
 * Applies the table to a state, a request and the names of met conditions and choices. Returns the new
 * state, whether the request was granted, missing and lost conditions, whether propellers may turn, and
 * the row that decided.
 */
function supervise(state, request, met) {
  const { table, drives } = CONFIG.supervisor;
  const has = new Set(met);
  const mayDrive = (now) => now in drives && drives[now].every((name) => has.has(name));
  let missing = [];
  for (const [i, row] of table.entries()) {
    if (!row.from.includes(state) || row.request !== request) continue;
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
