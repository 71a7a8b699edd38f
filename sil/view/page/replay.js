// SPDX-License-Identifier: MIT
// Plays a replay: the clock, the slider, the speed.
const PLAY_MS = 50;

class Player {
  constructor(source, changed) {
    this.source = source;
    this.changed = changed;
    this.slider = document.getElementById("at");
    this.speed = document.getElementById("speed");
    [this.slider.min, this.slider.max] = [source.begin_s, source.end_s];
    this.slider.addEventListener("input", () => this.seek(Number(this.slider.value)));
    this.timer = null;
    this.speed.value = "4";
    this.seek(source.begin_s);
  }

  /** Starts as soon as it is visible, unless the user prefers reduced motion. */
  begin(place) {
    if (window.matchMedia("(prefers-reduced-motion: reduce)").matches || this.source.end_s <= this.source.begin_s) return;
    const watch = new IntersectionObserver((seen) => {
      if (!seen.some(({ isIntersecting }) => isIntersecting)) return;
      watch.disconnect();
      if (!this.playing && this.source.t_s === this.source.begin_s) this.toggle();
    });
    watch.observe(place);
  }

  get playing() {
    return this.timer !== null;
  }

  seek(s) {
    this.source.seek(s);
    this.slider.value = this.source.t_s;
    this.slider.setAttribute("aria-valuetext", clock(this.source.t_s));
    this.changed();
  }

  toggle() {
    if (this.playing) {
      clearInterval(this.timer);
      this.timer = null;
    } else {
      if (this.source.t_s >= this.source.end_s) this.source.seek(this.source.begin_s);
      this.last = performance.now();
      this.timer = setInterval(() => this.step(), PLAY_MS);
    }
    this.changed();
  }

  step() {
    const now = performance.now();
    const next = this.source.t_s + (Number(this.speed.value) * (now - this.last)) / 1000;
    this.last = now;
    if (next >= this.source.end_s) this.toggle();
    this.seek(next);
  }
}
