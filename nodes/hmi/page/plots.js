// Live plots of the last minute (uPlot), each with the same in words for who does not see it.
import uPlot from "./vendored/uplot.js";
import { number, word } from "./words.js";

const SPAN = 60; // [s] that is shown
const HEIGHT = 240; // [px]
const TOLD = 2000; // [ms] from one text of a plot to the next
const DRAWN = 250; // [ms] from one drawing to the next
const COLOURS = ["#0b6fb8", "#c2410c", "#15803d", "#7e22ce", "#a16207", "#be185d", "#0e7490", "#64748b"];
const DASHES = [[], [6, 4], [2, 3]]; // lines differ not by colour alone

/** One plot of several lines over plant time. */
export class Plot {
  constructor(place, title) {
    this.title = title;
    this.names = [];
    this.rows = [];
    this.told = -Infinity;
    const figure = document.createElement("div");
    figure.className = "plot";
    this.heading = document.createElement("h3");
    this.area = document.createElement("div");
    this.area.setAttribute("role", "img");
    figure.append(this.heading, this.area);
    place.append(figure);
    this.#label();
    document.addEventListener("language", () => {
      this.#label();
      this.#build();
    });
    new ResizeObserver(() => this.plot?.setSize(this.#size)).observe(this.area);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => this.#build());
    setInterval(() => this.#draw(), DRAWN);
  }

  /** Take values (null for one that is not known) at plant time t [s]; `names` are functions. */
  add(t, names, values) {
    if (names.length !== this.names.length) {
      this.names = names;
      this.rows = [];
      this.#build();
    }
    if (this.rows.length > 0 && t < this.rows.at(-1)[0]) this.rows = []; // another run
    this.rows.push([t, ...values]);
    while (this.rows[0][0] < t - SPAN) this.rows.shift();
    this.fresh = true;
  }

  get #size() {
    return { width: Math.max(this.area.clientWidth, 100), height: HEIGHT - 40 };
  }

  #build() {
    this.plot?.destroy();
    if (this.names.length === 0) return;
    const style = getComputedStyle(document.documentElement);
    const stroke = style.getPropertyValue("--text").trim();
    const grid = { stroke: style.getPropertyValue("--line").trim(), width: 0.5 };
    const series = this.names.map((name, i) => ({
      label: name(),
      stroke: COLOURS[i % COLOURS.length],
      dash: DASHES[Math.floor(i / COLOURS.length) % DASHES.length],
      width: 2,
      points: { show: false },
    }));
    const axis = { stroke, grid, ticks: grid };
    const options = {
      ...this.#size,
      series: [{ label: word("plots.time") }, ...series],
      axes: [axis, { ...axis, size: 60 }],
      scales: { x: { time: false } },
      legend: { show: this.names.length > 1, live: false },
      cursor: { show: false },
    };
    this.plot = new uPlot(options, this.#columns(), this.area);
    this.fresh = true;
  }

  #columns() {
    return [0, ...this.names.map((_, i) => i + 1)].map((i) => this.rows.map((row) => row[i]));
  }

  #draw() {
    if (!this.fresh || document.visibilityState !== "visible") return;
    this.fresh = false;
    this.plot?.setData(this.#columns());
    if (performance.now() - this.told > TOLD) this.#label();
  }

  #label() {
    this.told = performance.now();
    const title = word(this.title);
    this.heading.textContent = title;
    const last = this.rows.at(-1);
    const one = (value) => (value === null || value === undefined ? "–" : number(value, 1));
    const values = last
      ? this.names.map((name, i) => `${name()} ${one(last[i + 1])}`).join(", ")
      : word("plots.empty");
    this.area.setAttribute("aria-label", word("plots.now", { title, values }));
  }
}
