// SPDX-License-Identifier: MIT
// The three plots over time, by Chart.js without animation and events: lines only.
const LEAST_ERROR_M = 1e-4;
const POINTS = 1600; // per plot, shared by its lines
const DECADE = (value) => Math.abs(Math.log10(value) - Math.round(Math.log10(value))) < 1e-9;

const LINES = {
  error: [{ column: "error_m", dash: dashOf }],
  thrust: [{ column: "port_N", dash: () => [] }, { column: "stbd_N", dash: () => [4, 3] }],
  speed: [{ column: "speed_mps", dash: dashOf }],
};

/** Horizontal lines below the boats' lines, with labels above; [value, text] each. */
const marks = {
  id: "marks",
  places({ chartArea: { top, bottom }, scales, flotillaMarks }) {
    const places = (flotillaMarks ?? []).map(([value, text]) => [scales.y.getPixelForValue(value), text]);
    return places.filter(([down]) => down > top - 1 && down < bottom + 1);
  },
  beforeDatasetsDraw(chart) {
    const { ctx, chartArea: { left, right } } = chart;
    ctx.save();
    ctx.strokeStyle = theme.soft;
    ctx.setLineDash([6, 4]);
    ctx.beginPath();
    for (const [down] of this.places(chart)) {
      ctx.moveTo(left, down);
      ctx.lineTo(right, down);
    }
    ctx.stroke();
    ctx.restore();
  },
  afterDatasetsDraw(chart) {
    const { ctx, chartArea: { left, top } } = chart;
    ctx.save();
    ctx.font = SMALL;
    for (const [down, text] of this.places(chart)) write(ctx, text, left + 4, down < top + 16 ? down + 13 : down - 4, theme.soft, "left", theme.panel);
    ctx.restore();
  },
};

function scalesOf(name) {
  const ticks = { color: theme.soft, maxRotation: 0, font: { size: 11 } };
  const x = { type: "linear", grid: { color: theme.grid }, ticks: { ...ticks, maxTicksLimit: 6, includeBounds: false, callback: (v) => (v < 0 ? "" : `${fixed(v, 0)} s`) } };
  const y = { grid: { color: theme.grid }, ticks: { ...ticks, maxTicksLimit: 6, callback: (v) => String(Number(v.toPrecision(6))).replace("-", "−") } };
  if (name !== "error") return { x, y: { type: "linear", grace: "8%", beginAtZero: name === "speed", ...y } };
  y.ticks = { ...ticks, autoSkip: false, callback: (v) => (DECADE(v) ? String(Number(v.toPrecision(1))) : null) };
  return { x, y: { type: "logarithmic", ...y } };
}

/** The greatest value of `of` over a line's values. */
function greatest(data, of) {
  let found = -Infinity;
  for (const { y } of data) if (of(y) > found) found = of(y);
  return found;
}

function limitsText(limits) {
  const texts = limits.map((x) => fixed(x, Number.isInteger(x) ? 0 : 1));
  if (!limits.length) return "";
  return limits.length === 2 && limits[0] === -limits[1] ? `, limits ±${texts[1]}` : `, limits ${texts.join(", ")}`;
}

class Plots {
  constructor(source) {
    this.source = source;
    this.kept = new Map();
    this.charts = Object.fromEntries(Object.keys(LINES).map((name) => [name, this.make(name)]));
  }

  /** Draws from another source from now on. */
  follow(source) {
    this.source = source;
    this.kept.clear();
  }

  make(name) {
    return new Chart(document.getElementById(`plot-${name}`), {
      type: "line",
      data: { datasets: [] },
      plugins: [marks],
      options: {
        animation: false, responsive: true, maintainAspectRatio: false, events: [], parsing: false,
        normalized: true, devicePixelRatio: Math.min(window.devicePixelRatio || 1, 2),
        elements: { point: { radius: 0 }, line: { tension: 0 } },
        plugins: { legend: { display: false }, tooltip: { enabled: false } },
        layout: { padding: { right: 6 } },
        scales: scalesOf(name),
      },
    });
  }

  /** Draws everything from `from` to `to` seconds; `chosen`: key of the highlighted vessel. */
  draw(vessels, from, to, chosen) {
    for (const [name, chart] of Object.entries(this.charts)) {
      chart.data.datasets = vessels.flatMap((vessel) => LINES[name].map((line) => this.line(vessel, line, from, to, chosen, vessels.length)));
      chart.data.datasets = chart.data.datasets.filter((line) => line.data.length);
      hide(chart.canvas.closest("figure"), vessels.length > 0 && !chart.data.datasets.length);
      [chart.options.scales.x.min, chart.options.scales.x.max] = [from, to];
      chart.flotillaMarks = this.marksOf(name, vessels, chart);
      chart.update("none");
    }
  }

  line(vessel, { column, dash }, from, to, chosen, count) {
    const track = this.source.track(vessel.key), values = track.columns[column];
    const most = Math.min(400, Math.max(60, POINTS / count));
    const floor = column === "error_m" ? LEAST_ERROR_M : -Infinity;
    const data = [];
    let some = false;
    for (const i of track.indices(from, to, most)) {
      some ||= known(values[i]);
      data.push({ x: track.t[i], y: Math.max(values[i], floor) });
    }
    const faint = chosen !== null && chosen !== vessel.key;
    // Chart.js is slower with a new line object
    const name = `${column} ${vessel.key}`;
    if (!this.kept.has(name)) this.kept.set(name, {});
    return Object.assign(this.kept.get(name), {
      data: some ? data : [], borderDash: dash(vessel), borderWidth: faint ? 0.8 : chosen === null ? 1.4 : 2,
      borderColor: faint ? theme.stale : colourOf(vessel), order: faint ? 1 : 0,
    });
  }

  /** Levels to mark: the settling limit; the thrust limits, if near enough. */
  marksOf(name, vessels, chart) {
    if (name === "error") {
      this.decades(chart);
      return [[CONFIG.settled_m, `settled: ${CONFIG.settled_m} m`]];
    }
    if (name !== "thrust") return [];
    const limits = [...new Set(vessels.flatMap((vessel) => vessel.limits_N ?? []))].sort((a, b) => a - b);
    say(document.getElementById("thrust-note"), `stbd dashed${limitsText(limits)}`);
    const most = Math.max(0, ...chart.data.datasets.map(({ data }) => greatest(data, Math.abs)));
    const near = limits.filter((limit) => Math.abs(limit) < 2.5 * most);
    const scale = chart.options.scales.y;
    [scale.suggestedMin, scale.suggestedMax] = [Math.min(...near, 0), Math.max(...near, 0)];
    return near.map((limit) => [limit, `limit ${fixed(limit, Number.isInteger(limit) ? 0 : 1)} N`]);
  }

  /** Whole decades around the errors. */
  decades(chart) {
    const least = -Math.max(-1, ...chart.data.datasets.map(({ data }) => greatest(data, (y) => -y)));
    const most = Math.max(0.1, ...chart.data.datasets.map(({ data }) => greatest(data, (y) => y)));
    const { y } = chart.options.scales;
    [y.min, y.max] = [10 ** Math.floor(Math.log10(Math.min(least, 0.04))), 10 ** Math.ceil(Math.log10(most))];
  }

  restyle() {
    for (const [name, chart] of Object.entries(this.charts)) chart.options.scales = scalesOf(name);
  }

  /** Marks time s in every plot by an element over the canvas, without redrawing. */
  cursor(s) {
    for (const { canvas, chartArea, scales } of Object.values(this.charts)) {
      const box = canvas.parentElement;
      let line = box.querySelector(".cursor");
      if (!line) {
        line = document.createElement("span");
        line.className = "cursor";
        box.append(line);
      }
      const right = scales.x.getPixelForValue(s);
      line.hidden = !chartArea || right < chartArea.left - 1 || right > chartArea.right + 1;
      if (!line.hidden) line.style.cssText = `left:${right}px;top:${chartArea.top}px;height:${chartArea.bottom - chartArea.top}px`;
    }
  }

  /** The time at an event on a plot's canvas. */
  timeAt(event) {
    const { scales } = Object.values(this.charts).find(({ canvas }) => canvas === event.target);
    return scales.x.getValueForPixel(event.offsetX);
  }
}
