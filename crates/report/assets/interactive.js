"use strict";
// Draws dots, curves over time and maps in the places of their figures, from the data that stands in the page.

// ---------------------------------------------------------------- elements

/** A new element with these properties and children. */
function make(tag, properties = {}, ...children) {
  const own = document.createElement(tag);
  for (const [name, value] of Object.entries(properties)) {
    if (name in own) own[name] = value;
    else own.setAttribute(name, value);
  }
  own.append(...children);
  return own;
}

/** The colour that a custom property of the page's style has now: light or dark. */
const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue(name).trim();
const series = (index) => colour(`--series-${index % 5}`);

/** Calls `redraw` when the page turns dark or light, and `resize` when `host` has another width. */
function follow(host, redraw, resize) {
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", redraw);
  let width = host.clientWidth;
  new ResizeObserver(() => {
    if (host.clientWidth !== width) resize((width = host.clientWidth));
  }).observe(host);
}

function button(words, act, properties = {}) {
  const own = make("button", { type: "button", ...properties }, words);
  own.addEventListener("click", act);
  return own;
}

function choice(label, options, chosen, act) {
  const own = make("select", {}, ...options.map(([value, words]) => make("option", { value }, words)));
  own.value = chosen;
  own.addEventListener("change", () => act(own.value));
  return make("label", {}, label, " ", own);
}

function check(words, checked, act, mark) {
  const own = make("input", { type: "checkbox", checked });
  own.addEventListener("change", () => act(own.checked));
  const label = make("label", { className: "check" }, own);
  if (mark) label.append(make("span", { className: "swatch", style: `background: var(${mark})` }));
  label.append(words);
  return label;
}

/** A value as the page prints it, with four digits unless `short`. */
function shown(value, kind, short = false) {
  if (value === null || value === undefined) return "–";
  if (kind === "text") return value;
  if (short || Number.isInteger(value)) return String(value).replace(/-/g, "−");
  const size = Math.abs(value);
  const text = size >= 1e-3 && size < 1e4 ? value.toPrecision(4) : String(Number(value.toPrecision(4)));
  return text.replace(/-/g, "−");
}

/** Whether no value of a column needs more than two decimals. */
const isShort = (rows, column) => rows.every((row) => typeof row[column] !== "number" || row[column] === Number(row[column].toFixed(2)));

const titled = (column) => column.name + (column.unit && column.unit !== "1" ? ` [${column.unit}]` : "");

// ---------------------------------------------------------------- CSV

const quoted = (value) => {
  const text = value === null || value === undefined ? "" : String(value);
  return /[",\r\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text;
};

/** Offers rows as a file, in the order in which they are shown. */
function download(name, head, rows) {
  const text = [head, ...rows].map((row) => row.map(quoted).join(",")).join("\r\n") + "\r\n";
  const href = URL.createObjectURL(new Blob([text], { type: "text/csv" }));
  make("a", { href, download: name }).click();
  setTimeout(() => URL.revokeObjectURL(href), 10000);
}

// ---------------------------------------------------------------- tables

const MOST_ROWS = 100;

/** Lets a click, Enter or the space bar choose a row of a table; the arrow keys go to the rows beside it. */
function pickable(row, choose) {
  row.tabIndex = 0;
  row.addEventListener("click", choose);
  row.addEventListener("keydown", (event) => {
    const beside = { ArrowDown: row.nextElementSibling, ArrowUp: row.previousElementSibling };
    if (event.key === "Enter" || event.key === " ") choose();
    else if (beside[event.key]) beside[event.key].focus();
    else return;
    event.preventDefault();
  });
}

/** A table that is sorted by its heads; `pick(index)` is called with the index of a chosen row. */
class Table {
  constructor(host, file, columns, rows, pick) {
    Object.assign(this, { file, columns, rows, pick, most: MOST_ROWS, sorted: null, down: false, picked: null });
    this.kept = rows.map((_, index) => index);
    this.short = columns.map((_, index) => isShort(rows, index));
    this.count = make("span", { className: "count", role: "status" });
    this.more = button("Show more rows", () => this.show((this.most += 500)));
    this.body = make("tbody");
    this.heads = columns.map((column, index) => this.head(column, index));
    const table = make("table", { className: "compact" }, make("thead", {}, make("tr", {}, ...this.heads)), this.body);
    const bar = make("div", { className: "bar" }, this.count, button("Download CSV", () => this.download()));
    host.append(bar, make("div", { className: "scroll rows", tabIndex: 0, role: "region", ariaLabel: `Table of ${file}` }, table), this.more);
    this.show();
  }

  head(column, index) {
    const own = button(titled(column), () => this.sort(index), { className: "sort" });
    return make("th", { scope: "col", className: column.kind === "text" ? "" : "number" }, own);
  }

  sort(column) {
    this.down = this.sorted === column && !this.down;
    this.sorted = column;
    this.show();
  }

  /** Keeps the rows of these indices. */
  keep(indices) {
    this.kept = indices;
    this.most = MOST_ROWS;
    this.show();
  }

  /** Rows without a value come last, either way. */
  order() {
    if (this.sorted === null) return this.kept;
    const [sign, column] = [this.down ? -1 : 1, this.sorted];
    const compare = (one, other) => {
      const [a, b] = [this.rows[one][column], this.rows[other][column]];
      if (a === null || b === null) return (a === null) - (b === null);
      return sign * (typeof a === "string" ? a.localeCompare(b, "en", { numeric: true }) : a - b);
    };
    return [...this.kept].sort(compare);
  }

  show() {
    this.heads.forEach((head, index) => {
      if (index === this.sorted) head.ariaSort = this.down ? "descending" : "ascending";
      else head.removeAttribute("aria-sort");
    });
    const order = this.order();
    this.body.replaceChildren(...order.slice(0, this.most).map((index) => this.row(index)));
    this.count.textContent = `${order.length} of ${this.rows.length} rows`;
    this.more.hidden = order.length <= this.most;
  }

  row(index) {
    const cell = (column, i) =>
      make("td", { className: column.kind === "text" ? "" : "number" }, shown(this.rows[index][i], column.kind, this.short[i]));
    const own = make("tr", {}, ...this.columns.map(cell));
    own.dataset.row = index;
    own.classList.toggle("picked", index === this.picked);
    pickable(own, () => {
      this.mark(index);
      this.pick(index);
    });
    return own;
  }

  /** Marks a row and scrolls the table, not the page, to it; `null` marks none. */
  mark(index) {
    this.picked = index;
    for (const row of this.body.children) row.classList.toggle("picked", Number(row.dataset.row) === index);
    const own = this.body.querySelector(".picked");
    const box = this.body.closest(".rows");
    if (!own) return;
    const [top, height] = [own.offsetTop, box.clientHeight];
    if (top < box.scrollTop + 40 || top + own.offsetHeight > box.scrollTop + height) box.scrollTop = top - height / 2;
  }

  download() {
    const values = (index) => this.rows[index];
    download(`${this.file}.csv`, this.columns.map(titled), this.order().map(values));
  }
}

// ---------------------------------------------------------------- plots

function axis(label, more = {}) {
  const ink = () => colour("--soft");
  const grid = { stroke: () => colour("--line"), width: 1 };
  const named = label ? { label, labelSize: 22, labelFont: "13px system-ui, sans-serif" } : {};
  return { ...named, font: "12px system-ui, sans-serif", stroke: ink, grid, ticks: grid, ...more };
}

/** uPlot listens to the mouse: a finger that moves sideways brushes, too. */
function touchable(plot) {
  const sent = { pointerdown: "mousedown", pointermove: "mousemove", pointerup: "mouseup" };
  for (const [type, as] of Object.entries(sent)) {
    plot.over.addEventListener(type, (event) => {
      if (event.pointerType !== "touch") return;
      const { clientX, clientY } = event;
      const target = type === "pointerup" ? document : plot.over;
      target.dispatchEvent(new MouseEvent(as, { clientX, clientY, movementX: 1, bubbles: true, button: 0 }));
    });
  }
}

/** Arrow keys pan by a tenth, + and − zoom about the centre, 0 or Escape shows all. */
function keys(element, act) {
  const moves = { ArrowLeft: [-0.1, 1], ArrowRight: [0.1, 1], "+": [0, 0.8], "=": [0, 0.8], "-": [0, 1.25], 0: null, Escape: null };
  element.tabIndex = 0;
  element.addEventListener("keydown", (event) => {
    if (event.ctrlKey || event.metaKey || event.altKey || !(event.key in moves)) return;
    event.preventDefault();
    act(moves[event.key]);
  });
}

/** A range moved by a share of its length and scaled about its centre. */
function moved([low, high], [shift, scale]) {
  const [centre, half] = [(low + high) / 2 + shift * (high - low), ((high - low) / 2) * scale];
  return [centre - half, centre + half];
}

// ---------------------------------------------------------------- dots

/** A dot per row: dragging over dots, typed limits and the checked groups filter the table below. */
class Dots {
  constructor(host, { columns, rows, axes, group }, file) {
    Object.assign(this, { host, columns, rows, axes: [...axes], group, ring: null, view: null });
    this.groups = [...new Set(rows.map((row) => row[group]))];
    this.hidden = new Set();
    this.logs = axes.map((column) => this.spreads(column));
    this.limits = [[null, null], [null, null]];
    this.controls = make("div", { className: "bar" });
    this.box = make("div", { className: "plot", role: "application", ariaLabel: "Dots of trials: arrow keys pan, plus and minus zoom, 0 shows all" });
    this.under = make("p", { className: "note", role: "status" });
    this.typed = make("div", { className: "bar" });
    host.append(this.controls, this.box, this.under, this.typed);
    this.table = new Table(host, file, columns, rows, (index) => this.mark(index));
    this.fill();
    this.fields();
    this.draw();
    keys(this.box, (move) => this.zoom(move));
    follow(this.box, () => this.draw(), () => this.draw());
  }

  /** Whether the column needs a logarithmic axis to be read: positive, over more than two decades. */
  spreads(column) {
    const values = this.rows.map((row) => row[column]).filter((value) => value !== null);
    const [low, high] = [Math.min(...values), Math.max(...values)];
    return low > 0 && high / low > 100;
  }

  fill() {
    const numbers = this.columns.map((column, index) => [index, titled(column), column.kind]).filter((own) => own[2] === "number");
    const select = (which, label) =>
      choice(label, numbers, this.axes[which], (value) => {
        this.axes[which] = Number(value);
        this.logs[which] = this.spreads(this.axes[which]);
        this.reset();
        this.fields();
      });
    this.controls.append(
      select(0, "Across"),
      select(1, "Up"),
      ...this.groups.map((name, index) => check(String(name), true, (on) => this.toggle(name, on), `--series-${index % 5}`)),
      button("Zoom to brush", () => this.closer()),
      button("Show all", () => this.reset()),
    );
  }

  toggle(name, on) {
    if (on) this.hidden.delete(name);
    else this.hidden.add(name);
    this.draw();
    this.filter();
  }

  /** Fields for the limits of both axes: what the brush sets, for those who type. */
  fields() {
    this.inputs = this.axes.map((column, which) => [0, 1].map((side) => {
      const own = make("input", { type: "number", step: "any", ariaLabel: `${this.columns[column].name} ${side ? "at most" : "at least"}`, placeholder: side ? "max" : "min" });
      own.addEventListener("change", () => {
        this.limits[which][side] = own.value === "" ? null : Number(own.value);
        this.brush();
        this.filter();
      });
      return own;
    }));
    const logarithmic = (which) => check("logarithmic", this.logs[which], (on) => {
      this.logs[which] = on;
      this.reset();
    });
    const row = (column, which) => make("span", { className: "limits" }, make("span", { className: "name" }, this.columns[column].name), this.inputs[which][0], " to ", this.inputs[which][1], " ", logarithmic(which));
    this.typed.replaceChildren(...this.axes.map(row));
  }

  reset() {
    this.view = null;
    this.limits = [[null, null], [null, null]];
    this.table.picked = this.ring = null;
    this.draw();
    this.filter();
  }

  value(row, which) {
    const value = this.rows[row][this.axes[which]];
    return value !== null && this.logs[which] && value <= 0 ? null : value;
  }

  visible(index) {
    return !this.hidden.has(this.rows[index][this.group]);
  }

  draw() {
    const all = this.rows.map((_, index) => index).filter((index) => this.value(index, 0) !== null && this.value(index, 1) !== null);
    all.sort((a, b) => this.value(a, 0) - this.value(b, 0));
    this.drawn = all;
    const up = (name) => all.map((index) => (this.rows[index][this.group] === name && this.visible(index) ? this.value(index, 1) : null));
    const data = [all.map((index) => this.value(index, 0)), ...this.groups.map(up)];
    this.plot?.destroy();
    this.plot = new uPlot(this.options(), data, this.box);
    touchable(this.plot);
    this.plot.over.addEventListener("click", (event) => this.nearest(event));
    this.plot.over.addEventListener("dblclick", () => this.reset());
    this.brush();
  }

  options() {
    const scale = (which) => ({ time: false, distr: this.logs[which] ? 3 : 1, ...(this.view ? { range: () => this.view[which] } : {}) });
    const dots = this.groups.map((name, index) => ({
      label: String(name), stroke: () => series(index), paths: () => null, points: { show: true, size: 6, width: 1, fill: () => `${series(index)}66` },
    }));
    return {
      width: this.box.clientWidth, height: Math.min(420, Math.max(280, this.box.clientWidth * 0.55)),
      legend: { show: false }, cursor: { drag: { x: true, y: true, setScale: false }, points: { show: false } },
      scales: { x: scale(0), y: scale(1) },
      axes: [axis(titled(this.columns[this.axes[0]]), { size: 34 }), axis(titled(this.columns[this.axes[1]]), { size: 62 })],
      series: [{}, ...dots],
      hooks: { setSelect: [(plot) => this.brushed(plot)], draw: [(plot) => this.circle(plot)] },
    };
  }

  brushed(plot) {
    const { left, top, width, height } = plot.select;
    if (this.placing || (width < 3 && height < 3)) return;
    const short = (value) => Number(value.toPrecision(4));
    const at = (from, to, scale) => [short(plot.posToVal(from, scale)), short(plot.posToVal(to, scale))];
    this.limits = [at(left, left + width, "x"), at(top + height, top, "y")];
    this.brush();
    this.filter();
  }

  /** Shows the limits as typed and as a frame on the plot. */
  brush() {
    this.limits.forEach((own, which) => own.forEach((value, side) => (this.inputs[which][side].value = value ?? "")));
    const { over, scales } = this.plot;
    const place = (which, side, scale, least, most) => {
      const value = this.limits[which][side];
      if (value === null || (this.logs[which] && value <= 0) || scales[scale].min === null) return side ? most : least;
      const at = this.plot.valToPos(value, scale);
      return Math.min(Math.max(at, Math.min(least, most)), Math.max(least, most));
    };
    const any = this.limits.flat().some((value) => value !== null);
    const [left, right] = [0, 1].map((side) => place(0, side, "x", 0, over.clientWidth));
    const [bottom, top] = [0, 1].map((side) => place(1, side, "y", over.clientHeight, 0));
    this.placing = true;
    this.plot.setSelect(any ? { left, top, width: right - left, height: bottom - top } : { left: 0, top: 0, width: 0, height: 0 }, false);
    this.placing = false;
  }

  /** The ranges of both axes now. */
  ranges() {
    const { x, y } = this.plot.scales;
    return [[x.min, x.max], [y.min, y.max]];
  }

  closer() {
    const now = this.ranges();
    const own = this.limits.map((limits, which) => limits.map((value, side) => value ?? now[which][side]));
    if (own.every(([low, high], which) => low < high && !(this.logs[which] && low <= 0))) this.look(own);
  }

  zoom(move) {
    if (!move) return this.reset();
    const scaled = ([low, high], which) => {
      const by = [which ? 0 : move[0], move[1]];
      return this.logs[which] ? moved([Math.log(low), Math.log(high)], by).map(Math.exp) : moved([low, high], by);
    };
    this.look(this.ranges().map(scaled));
  }

  look(view) {
    this.view = view;
    this.draw();
    this.filter();
  }

  /** What is out of the view, out of the brush or unchecked leaves the table; without either, rows without a dot stay. */
  filter() {
    const now = this.view ?? [[null, null], [null, null]];
    const within = (value, [low, high]) => (low === null && high === null) || (value !== null && (low === null || value >= low) && (high === null || value <= high));
    const kept = (index) => this.visible(index) && [0, 1].every((which) => {
      const value = this.rows[index][this.axes[which]];
      return within(value, this.limits[which]) && within(value, now[which]);
    });
    this.table.keep(this.rows.map((_, index) => index).filter(kept));
    this.say();
  }

  say() {
    const lacking = this.rows.length - this.drawn.length;
    this.under.textContent = this.ring !== null
      ? this.columns.map((column, i) => `${column.name} ${shown(this.rows[this.ring][i], column.kind)}`).join(", ")
      : lacking ? `${lacking} rows have no dot: a value is missing${this.logs.some(Boolean) ? ", or not above 0" : ""}.` : "";
  }

  mark(index) {
    this.ring = index;
    this.plot.redraw(false);
    this.say();
  }

  /** A click, not a drag, picks the nearest dot. */
  nearest(event) {
    if (this.plot.select.width > 2 && this.limits.flat().every((value) => value === null)) return;
    const box = this.plot.over.getBoundingClientRect();
    const [x, y] = [event.clientX - box.left, event.clientY - box.top];
    const away = (index) => Math.hypot(this.plot.valToPos(this.value(index, 0), "x") - x, this.plot.valToPos(this.value(index, 1), "y") - y);
    const visible = this.drawn.filter((index) => this.visible(index)).map((index) => [away(index), index]);
    const [distance, index] = visible.reduce((best, own) => (own[0] < best[0] ? own : best), [12, null]);
    if (index === null || distance >= 12) return;
    this.table.mark(index);
    this.mark(index);
  }

  circle(plot) {
    if (this.ring === null || this.value(this.ring, 0) === null || this.value(this.ring, 1) === null) return;
    const { ctx } = plot;
    const [x, y] = [plot.valToPos(this.value(this.ring, 0), "x", true), plot.valToPos(this.value(this.ring, 1), "y", true)];
    ctx.save();
    ctx.strokeStyle = colour("--ink");
    ctx.lineWidth = 2 * devicePixelRatio;
    ctx.beginPath();
    ctx.arc(x, y, 8 * devicePixelRatio, 0, 2 * Math.PI);
    ctx.stroke();
    ctx.restore();
  }
}

// ---------------------------------------------------------------- over time

const STATES = [["surge speed u", "m/s"], ["sway speed v", "m/s"], ["yaw rate r", "rad/s"]];

/** Measured and simulated u, v and r of one window, zoomed together. */
class Curves {
  constructor(host, { windows }) {
    Object.assign(this, { host, windows, own: 0, plots: [] });
    const named = (window) => (windows.filter((other) => other.source === window.source).length > 1 ? `${window.source}, window ${window.window}` : window.source);
    const step = (by) => () => this.open((this.own + by + windows.length) % windows.length);
    const label = choice("Recording", windows.map((window, index) => [index, named(window)]), 0, (value) => this.open(Number(value)));
    this.select = label.querySelector("select");
    this.name = named;
    host.append(make("div", { className: "bar" }, label, button("Previous", step(-1)), button("Next", step(1)), button("Show all", () => this.look(null)), button("Download CSV", () => this.download())));
    this.box = make("div", { className: "plots", role: "application", ariaLabel: "Curves over time: arrow keys pan, plus and minus zoom, 0 shows all" });
    host.append(this.box);
    this.open(0);
    keys(this.box, (move) => this.look(move && moved(this.range(), move)));
    follow(this.box, () => this.draw(), () => this.draw());
  }

  open(index) {
    this.own = index;
    this.select.value = index;
    this.view = null;
    this.draw();
  }

  range() {
    const { min, max } = this.plots[0].scales.x;
    return [min, max];
  }

  /** Shows a range of time in all plots; `null` shows all. */
  look(range) {
    const { t } = this.windows[this.own];
    this.view = range;
    const [min, max] = range ?? [t[0], t[t.length - 1]];
    for (const plot of this.plots) plot.setScale("x", { min, max });
  }

  draw() {
    this.plots.forEach((plot) => plot.destroy());
    this.plots = STATES.map((_, d) => this.plot(d));
    if (this.view) this.look(this.view);
  }

  plot(d) {
    const { t, measured, simulated, half } = this.windows[this.own];
    const edge = (sign) => simulated[d].map((value, k) => (value === null || half[d][k] === null ? null : value + sign * half[d][k]));
    const [name, unit] = STATES[d];
    const value = (_, number) => (number === null || number === undefined ? "–" : shown(number));
    const bound = { stroke: () => `${colour("--series-0")}00`, value, points: { show: false }, width: 0 };
    const plot = new uPlot({
      width: this.box.clientWidth, height: 210,
      cursor: { sync: { key: "time", setSeries: false }, drag: { x: true, y: false, setScale: false }, points: { size: 6 } },
      scales: { x: { time: false } },
      axes: [axis(d === 2 ? "time [s]" : "", { size: 34 }), axis(`${name} [${unit}]`, { size: 58 })],
      bands: [{ series: [3, 4], fill: () => `${colour("--series-0")}33` }],
      series: [
        { label: "t [s]", value },
        { label: "measured", stroke: () => colour("--ink"), width: 1.5, points: { show: false }, value },
        { label: "simulated", stroke: () => colour("--series-0"), width: 2, points: { show: false }, value },
        { label: "high", ...bound },
        { label: "low", ...bound },
      ],
      hooks: { setSelect: [(own) => this.dragged(own)] },
    }, [t, measured[d], simulated[d], edge(1), edge(-1)], this.box);
    touchable(plot);
    plot.over.addEventListener("dblclick", () => this.look(null));
    return plot;
  }

  dragged(plot) {
    const { left, width } = plot.select;
    if (width < 4) return;
    const range = [plot.posToVal(left, "x"), plot.posToVal(left + width, "x")];
    this.plots.forEach((own) => own.setSelect({ left: 0, top: 0, width: 0, height: 0 }, false));
    this.look(range);
  }

  download() {
    const { t, measured, simulated, half } = this.windows[this.own];
    const names = ["u [m/s]", "v [m/s]", "r [rad/s]"];
    const head = ["t [s]", ...["measured", "simulated", "half band"].flatMap((what) => names.map((name) => `${what} ${name}`))];
    const rows = t.map((time, k) => [time, ...[measured, simulated, half].flatMap((all) => all.map((own) => own[k]))]);
    download(`${this.name(this.windows[this.own])}.csv`, head, rows);
  }
}

// ---------------------------------------------------------------- maps

const LAND = "#e2c59c";
const NO_GO = "#e6cfe6";

/** Places of a line, [north, east] in metres. */
function places(line) {
  const all = [];
  for (let k = 0, east = 0, north = 0; k < line.length; k += 2) {
    all.push([(north += line[k + 1]) / 10, (east += line[k]) / 10]);
  }
  return all;
}

/** The colour of land, of water not to be entered, or of a band of depth. */
function ground(kind, bands) {
  if (kind === "land") return LAND;
  if (kind === "no-go") return NO_GO;
  if (bands < 2) return "#d9e9f5";
  const mix = (from, to) => Math.round(from + (kind / (bands - 1)) * (to - from));
  return `rgb(${mix(143, 240)}, ${mix(194, 247)}, ${mix(229, 252)})`;
}

/** Cells as a picture in `pane`: pairs of a colour and the runs of cells that have it. */
function picture(pane, [west, south, cell, columns, rows], painted) {
  // Browsers limit the size of a canvas.
  const coarser = Math.max(1, columns / 4096, rows / 4096);
  const canvas = make("canvas", { width: Math.ceil(columns / coarser), height: Math.ceil(rows / coarser) });
  const context = canvas.getContext("2d");
  context.scale(canvas.width / columns, canvas.height / rows);
  for (const [paint, runs] of painted) {
    context.fillStyle = paint;
    let at = 0;
    runs.forEach((run, index) => {
      for (let from = at, end = at + run; index % 2 && from < end; ) {
        const row = Math.floor(from / columns);
        const to = Math.min(end, (row + 1) * columns);
        context.fillRect(from % columns, rows - 1 - row, to - from, 1);
        from = to;
      }
      at += run;
    });
  }
  const bounds = [[south, west], [south + rows * cell, west + columns * cell]];
  return L.imageOverlay(canvas.toDataURL(), bounds, { pane, className: "cells", interactive: false });
}

/** A plan on its chart, with layers; a step of the maneuver sheet and its part of the track find each other. */
class Chart {
  constructor(host, map) {
    Object.assign(this, { own: map, parts: [], steps: [] });
    const [west, south, east, north] = map.frame;
    this.bounds = [[south, west], [north, east]];
    this.layers = make("div", { className: "bar layers" });
    const box = make("div", { className: `chart${map.uncharted ? " uncharted" : ""}`, role: "application", ariaLabel: "Map of the plan: arrow keys pan, plus and minus zoom" });
    host.append(this.layers, box);
    this.box = box;
    const calm = matchMedia("(prefers-reduced-motion: reduce)").matches;
    this.map = L.map(box, { crs: L.CRS.Simple, attributionControl: false, minZoom: -12, maxZoom: 4, zoomSnap: 0.25, scrollWheelZoom: false, zoomAnimation: !calm, fadeAnimation: !calm });
    // Else a reader who scrolls down the page would be caught by the map.
    this.map.on("focus", () => this.map.scrollWheelZoom.enable()).on("blur", () => this.map.scrollWheelZoom.disable());
    L.control.scale({ imperial: false }).addTo(this.map);
    this.map.fitBounds(this.bounds);
    this.layers.append(button("Show all", () => this.map.fitBounds(this.bounds)));
    this.draw();
    if (map.tracks.some((own) => own[4] !== null)) this.steps = [...document.querySelectorAll(".sheet tr[data-step]")];
    this.steps.forEach((row, step) => pickable(row, () => this.find(step)));
    follow(box, () => {}, () => this.map.invalidateSize());
  }

  /** Adds a layer that a box of its own shows and hides. */
  layer(name, all, on = true) {
    if (!all.length) return;
    const group = L.layerGroup(all);
    if (on) group.addTo(this.map);
    this.layers.append(check(name, on, (show) => (show ? group.addTo(this.map) : group.remove())));
  }

  ring(className, line, more = {}) {
    return L.polygon(places(line), { className, interactive: false, ...more });
  }

  draw() {
    const { own } = this;
    ["water", "cells", "ground", "marks"].forEach((name, index) => (this.map.createPane(name).style.zIndex = 300 + 20 * index));
    const water = L.rectangle(this.bounds, { pane: "water", className: "water", interactive: false });
    this.layer("chart", [water, ...this.cells(), ...this.areas(), ...own.contours.map(([depth, line]) => this.contour(depth, line))]);
    this.layer("margins", own.margins.map(([purpose, raster, runs]) => picture("marks", raster, [[purpose === "transit" ? "rgba(246, 189, 180, 0.85)" : "rgba(200, 40, 30, 0.18)", runs]])));
    this.layer("dangers and soundings", own.spots.map((spot) => this.spot(spot)));
    this.layer("swept by hulls", own.swept ? [picture("marks", own.swept[1], [["rgba(29, 36, 43, 0.28)", own.swept[2]]])] : []);
    this.layer("corridors", own.corridors.map((line) => this.ring("corridor", line)), false);
    this.layer("area and speed limits", [...(own.edge ? [this.ring("edge", own.edge)] : []), ...own.limits.map((line) => this.ring("limit", line))]);
    this.layer("names", own.names.map(([at, name]) => this.words(at, name, "place")));
    this.layer("abort tracks", (own.aborts ?? []).map((line) => L.polyline(places(line), { className: "abort", interactive: false })));
    this.layer("hulls", own.hulls.map((line) => this.ring("hull", line)));
    this.layer("track", this.tracks());
    this.layer("latitude and longitude", this.graticule(), false);
  }

  cells() {
    if (!this.own.cells) return [];
    const [raster, classes] = this.own.cells;
    return [picture("cells", raster, classes.filter(([kind]) => kind !== null).map(([kind, runs]) => [ground(kind, this.own.bands), runs]))];
  }

  areas() {
    const area = ([kind, rings]) => L.polygon(rings.map(places), { pane: "ground", interactive: false, className: `area ${typeof kind === "string" ? kind : "depth"}`, fillColor: ground(kind, this.own.bands) });
    return this.own.areas.filter(([kind]) => kind !== null).map(area);
  }

  contour(depth, line) {
    const own = L.polyline(places(line), { pane: "ground", className: "contour", interactive: depth !== null });
    return depth === null ? own : own.bindTooltip(`${depth} m`, { sticky: true });
  }

  spot([[east, north], symbol, depth, title]) {
    if (symbol === "sounding") return this.words([east, north], depth === null ? "·" : String(depth), "sounding");
    return L.circleMarker([north, east], { radius: 4, className: "danger" }).bindTooltip(make("span", {}, title));
  }

  words([east, north], words, className) {
    const html = make("span", {}, words);
    return L.marker([north, east], { interactive: false, keyboard: false, icon: L.divIcon({ className: `words ${className}`, html, iconSize: null }) });
  }

  tracks() {
    const { own } = this;
    const all = own.tracks.flatMap(([kind, maneuver, , line, step]) => {
      const at = places(line);
      const look = kind === "maneuver" && maneuver !== null ? `maneuver series-${maneuver % 5}` : kind === "run-in" ? "run-in" : "basic";
      const part = L.polyline(at, { className: `track ${look}`, interactive: step !== null, bubblingMouseEvents: false });
      part.on("click", () => this.pick(step));
      this.parts.push({ step, part, at });
      return [L.polyline(at, { className: "halo", interactive: false }), part];
    });
    const halos = all.filter((_, index) => index % 2 === 0);
    const parts = all.filter((_, index) => index % 2 === 1);
    const numbers = own.tracks.filter((track) => track[2] !== null).map((track, index, all) => this.number(track, all.slice(0, index)));
    const end = (place, className, name) => (place ? [L.circleMarker([place[1], place[0]], { radius: 6, className }).bindTooltip(name)] : []);
    return [...halos, ...parts, ...end(own.start, "start", "start"), ...end(own.goal, "goal", "end"), ...numbers];
  }

  /** The number of a maneuver where it begins, beside those of earlier ones that begin there, too. */
  number([, maneuver, number, line, step], earlier) {
    const at = places(line)[0];
    const near = (this.bounds[1][1] - this.bounds[0][1]) / 40;
    const beside = earlier.filter((other) => L.CRS.Simple.distance(L.latLng(places(other[3])[0]), L.latLng(at)) < near).length;
    const icon = L.divIcon({ className: `number series-${maneuver === null ? 5 : maneuver % 5}`, html: make("span", {}, String(number)), iconSize: [24, 24], iconAnchor: [12 - 22 * beside, 12] });
    const own = L.marker(at, { icon, title: this.own.maneuvers[maneuver] ?? "", keyboard: false, interactive: step !== null });
    return own.on("click", () => this.pick(step));
  }

  graticule() {
    const [west, south, east, north] = this.own.frame;
    const line = (at) => L.polyline(at, { className: "graticule", interactive: false });
    const up = this.own.meridians.flatMap(([x, label]) => [line([[south, x], [north, x]]), this.words([x, south], label, "degrees")]);
    return up.concat(this.own.parallels.flatMap(([y, label]) => [line([[y, west], [y, east]]), this.words([west, y], label, "degrees")]));
  }

  pick(step) {
    if (step === null) return;
    this.highlight(step);
    this.steps[step].scrollIntoView({ block: "center" });
    this.steps[step].focus({ preventScroll: true });
  }

  find(step) {
    this.highlight(step);
    this.box.scrollIntoView({ block: "nearest" });
    const at = this.parts.filter((own) => own.step === step).flatMap((own) => own.at);
    if (at.length) this.map.fitBounds(L.latLngBounds(at).pad(0.6), { maxZoom: 0, animate: false });
  }

  highlight(step) {
    this.steps.forEach((row, index) => row.classList.toggle("picked", index === step));
    for (const own of this.parts) own.part.getElement()?.classList.toggle("picked", own.step === step);
  }
}

// ---------------------------------------------------------------- the page

const KINDS = { dots: Dots, time: Curves, map: Chart };

for (const { id, data } of JSON.parse(document.getElementById("data").textContent)) {
  const host = document.getElementById(id);
  host.hidden = false;
  // For the console, and for scripts/page_check.py
  host.drawn = new KINDS[data.kind](host, data, id);
  host.previousElementSibling.classList.add("replaced");
}
