// SPDX-License-Identifier: MIT
// User input: buttons, plots, keys.
const PAN_PX = 60;
const KEYS = {
  m: () => measure(),
  Escape: () => ruler.on && measure(),
  " ": () => togglePause(),
  f: () => centreOn("fleet"),
  "+": () => zoom(1.4), "=": () => zoom(1.4), "-": () => zoom(1 / 1.4),
  ArrowLeft: (event) => player?.seek(source.t_s - (event.shiftKey ? 10 : 1)),
  ArrowRight: (event) => player?.seek(source.t_s + (event.shiftKey ? 10 : 1)),
  Home: () => player?.seek(source.begin_s),
  End: () => player?.seek(source.end_s),
};

const PANS = { ArrowLeft: [1, 0], ArrowRight: [-1, 0], ArrowUp: [0, 1], ArrowDown: [0, -1] };

/** Applies a key to the focused plan; whether the key has a function there. */
function keyedOnPlan({ key }) {
  if (key in PANS) plan.camera.drag(...PANS[key].map((step) => PAN_PX * step));
  else if (key === "Enter" && ruler.on) putEnd(plan.camera.width / 2, plan.camera.height / 2);
  else return false;
  schedule(true);
  return true;
}

function measure() {
  ruler.toggle();
  byName("measure").setAttribute("aria-pressed", String(ruler.on));
  say(byName("measured"), ruler.text());
  schedule(true);
}

function putEnd(right, down) {
  ruler.put(plan.camera.place(right, down));
  say(byName("measured"), ruler.text());
  schedule(true);
}

/** A click on the plan: the pointer went up close to where it went down. */
function clicks(canvas, act) {
  let down = [0, 0];
  canvas.addEventListener("pointerdown", (event) => (down = [event.offsetX, event.offsetY]));
  canvas.addEventListener("click", (event) => {
    if (Math.hypot(event.offsetX - down[0], event.offsetY - down[1]) < 5) act(event.offsetX, event.offsetY);
  });
}

function zoom(factor) {
  plan.camera.zoom(factor);
  schedule(true);
}

/** Keys act unless the focused element uses them itself. */
function keyed(event) {
  if (byName("fleet").hidden || event.ctrlKey || event.altKey || event.metaKey) return;
  const focus = document.activeElement?.tagName;
  if (focus === "CANVAS" && keyedOnPlan(event)) {
    event.preventDefault();
    return;
  }
  const own = focus === "SELECT" || (focus === "BUTTON" && event.key === " ") || (focus === "INPUT" && event.key.length > 1 && !event.key.startsWith("Arrow"));
  const act = KEYS[event.key.length === 1 ? event.key.toLowerCase() : event.key];
  if (own || !act || (!player && event.key.length > 1 && event.key !== "Escape")) return;
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
  for (const name of PAGES) byName(`tab-${name}`).addEventListener("click", () => openPage(name));
  document.addEventListener("keydown", keyed);
  steer(byName("plan"), plan.camera, () => schedule(true));
  byName("measure").addEventListener("click", measure);
  clicks(byName("plan"), (right, down) => ruler.on && putEnd(right, down));
  byName("plan").addEventListener("dblclick", (event) => {
    if (ruler.on) return;
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
