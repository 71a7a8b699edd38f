// SPDX-License-Identifier: MIT
// Distance and bearing between two positions clicked on the plan view.
class Ruler {
  constructor() {
    this.on = false;
    this.ends = []; // [north, east] each
  }

  toggle() {
    [this.on, this.ends] = [!this.on, []];
  }

  /** A third click begins a new measurement. */
  put(place) {
    this.ends = this.ends.length === 1 ? [this.ends[0], place] : [place];
  }

  text() {
    if (!this.on) return "";
    if (this.ends.length < 2) return this.ends.length ? "Now the second place." : "Click two places, or press Enter for the middle of the map.";
    const [[north, east], [to_north, to_east]] = this.ends;
    const far = Math.hypot(to_north - north, to_east - east), course = Math.atan2(to_east - east, to_north - north);
    return `${far < 10000 ? withUnit(far, far < 100 ? 2 : 0, "m") : withUnit(far / 1000, 1, "km")}, bearing ${degrees(course)}`;
  }

  draw(ctx, camera) {
    if (!this.on) return;
    const ends = this.ends.map((end) => camera.at(...end));
    if (!ends.length && document.activeElement?.id === "plan") ends.push([camera.width / 2, camera.height / 2]);
    for (const [colour, width] of [[theme.water, 5], [theme.ink, 2]]) {
      [ctx.strokeStyle, ctx.lineWidth] = [colour, width];
      ctx.beginPath();
      for (const end of ends) ctx.lineTo(...end);
      ctx.stroke();
      for (const [right, down] of ends) {
        ctx.beginPath();
        ctx.arc(right, down, 4, 0, 2 * Math.PI);
        ctx.stroke();
      }
    }
  }
}
