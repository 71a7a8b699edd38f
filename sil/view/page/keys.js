// SPDX-License-Identifier: MIT
// What the reader touches: buttons, plots, keys.
const KEYS = {
  " ": () => togglePause(),
  f: () => centreOn("fleet"),
  "+": () => zoom(1.4), "=": () => zoom(1.4), "-": () => zoom(1 / 1.4),
  ArrowLeft: (event) => player?.seek(source.t_s - (event.shiftKey ? 10 : 1)),
  ArrowRight: (event) => player?.seek(source.t_s + (event.shiftKey ? 10 : 1)),
  Home: () => player?.seek(source.begin_s),
  End: () => player?.seek(source.end_s),
};

function zoom(factor) {
  plan.camera.zoom(factor);
  schedule(true);
}

/** A key acts where the focus is on nothing that uses it itself. */
function keyed(event) {
  if (byName("fleet").hidden || event.ctrlKey || event.altKey || event.metaKey) return;
  const focus = document.activeElement?.tagName;
  const own = focus === "SELECT" || (focus === "BUTTON" && event.key === " ") || (focus === "INPUT" && event.key.length > 1 && !event.key.startsWith("Arrow"));
  const act = KEYS[event.key.length === 1 ? event.key.toLowerCase() : event.key];
  if (own || !act || (!player && event.key.length > 1)) return;
  event.preventDefault();
  act(event);
}

function listen() {
  byName("pause").addEventListener("click", togglePause);
  byName("fit").addEventListener("click", () => centreOn("fleet"));
  byName("nearer").addEventListener("click", () => zoom(1.4));
  byName("farther").addEventListener("click", () => zoom(1 / 1.4));
  byName("centre").addEventListener("change", (event) => centreOn(event.target.value));
  byName("window").addEventListener("change", () => schedule(true));
  for (const name of ["fleet", "failsafe"]) byName(`tab-${name}`).addEventListener("click", () => openPage(name));
  document.addEventListener("keydown", keyed);
  steer(byName("plan"), plan.camera, () => schedule(true));
  byName("plan").addEventListener("dblclick", (event) => {
    const key = plan.under(event.offsetX, event.offsetY, shown?.vessels ?? []);
    centreOn(key ?? "fleet");
  });
  for (const name of ["error", "thrust", "speed"]) {
    byName(`plot-${name}`).addEventListener("click", (event) => player?.seek(plots.timeAt(event)));
  }
  dark.addEventListener("change", () => {
    readTheme();
    plots?.restyle();
    drawnPlots = "";
    schedule(true);
  });
  new ResizeObserver(() => schedule(true)).observe(byName("plan-box"));
}
