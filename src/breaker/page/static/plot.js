"use strict";
// Curves as SVG: panels that share their times. The wheel or + and - zoom, dragging or the arrows
// move, a double click or 0 shows all, a click sets the cursor.

const LEFT = 58, RIGHT = 10, ROW = 13; // pixels: of the labels of axes, and of a line of text

function svg(tag, attributes = {}, text = "") {
  const made = document.createElementNS("http://www.w3.org/2000/svg", tag);
  for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
  made.textContent = text;
  return made;
}

function ticksOf(low, high, count) { // round numbers
  const rough = (high - low) / count, power = 10 ** Math.floor(Math.log10(rough));
  const step = [1, 2, 5, 10].map((k) => k * power).find((size) => size >= rough);
  const made = [];
  for (let k = Math.ceil(low / step); k * step <= high; k += 1) made.push(Number((k * step).toPrecision(9)));
  return made;
}

class Plot {
  constructor(place, data, say) {
    Object.assign(this, { place, data, say, window: data.window, cursor: null });
    this.panels = document.createElement("div");
    this.panels.tabIndex = 0;
    place.append(this.legend(), this.panels);
    this.panels.addEventListener("wheel", (event) => {
      event.preventDefault();
      this.zoom(event.deltaY < 0 ? 0.8 : 1.25, this.timeAt(event));
    }, { passive: false });
    this.panels.addEventListener("pointerdown", (event) => this.grab(event));
    this.panels.addEventListener("dblclick", () => this.show(data.window));
    this.panels.addEventListener("keydown", (event) => this.press(event));
    new ResizeObserver(() => this.draw()).observe(place);
  }

  legend() { // names of phases, then of other records
    const row = document.createElement("div"), names = new Map();
    row.className = "legend";
    for (const { look, name, phase, colour } of this.data.panels.flatMap((panel) => panel.curves)) {
      names.set(look ? name : phase || name, look ? "" : colour);
    }
    for (const [name, colour] of [...names].sort((a, b) => !a[1] - !b[1])) {
      const style = `border-color: ${colour || "transparent"}`;
      row.append(Object.assign(document.createElement("span"), { textContent: name, style }));
    }
    return row;
  }

  show(window) {
    this.window = window;
    this.draw();
  }

  zoom(factor, around) {
    this.show(this.window.map((end) => around + factor * (end - around)));
  }

  press(event) {
    const [begin, end] = this.window, width = end - begin;
    const moved = { ArrowLeft: -0.1, ArrowRight: 0.1 }[event.key], factor = { "+": 0.8, "-": 1.25 }[event.key];
    if (moved) this.show([begin + moved * width, end + moved * width]);
    else if (factor) this.zoom(factor, begin + width / 2);
    else if (event.key === "0") this.show(this.data.window);
    else return;
    event.preventDefault();
  }

  timeAt(event) {
    const { left, width } = this.panels.getBoundingClientRect(), [begin, end] = this.window;
    return begin + (event.clientX - left - LEFT) / (width - LEFT - RIGHT) * (end - begin);
  }

  grab(event) { // moves the curves; without a movement it is a click
    const before = this.window, at = event.clientX, width = this.panels.clientWidth - LEFT - RIGHT;
    const move = (now) => this.show(before.map((end) => end + (at - now.clientX) / width * (before[1] - before[0])));
    const release = (now) => {
      removeEventListener("pointermove", move);
      if (Math.abs(now.clientX - at) < 3) this.read(this.timeAt(now));
    };
    addEventListener("pointermove", move);
    addEventListener("pointerup", release, { once: true });
  }

  read(time) { // travels of the samples nearest to the cursor
    const nearest = (x) => x.reduce((best, at, i) => Math.abs(at - time) < Math.abs(x[best] - time) ? i : best, 0);
    const travels = this.data.panels[0].curves.filter((curve) => curve.name === "travel");
    const values = travels.map(({ phase, x, y }) => `${phase} ${y[nearest(x)]?.toFixed(2) ?? "–"} mm`);
    this.say([`${time.toFixed(2)} ms`, ...values].join(", "));
    this.cursor = time;
    this.draw();
  }

  draw() {
    const width = this.place.clientWidth - LEFT - RIGHT, last = this.data.panels.length - 1;
    if (width < 50) return; // hidden
    this.panels.replaceChildren(...this.data.panels.map((panel, k) => this.panel(panel, width, k === last ? this.data.axis : "")));
  }

  panel({ name, height, label, curves }, width, axis) {
    const [begin, end] = this.window, isLog = name === "resistance", scale = isLog ? Math.log10 : Number;
    const lines = curves.map((curve) => ({ ...curve, y: curve.y.map((y) => y === null ? null : scale(y)) }));
    const [low, high] = rangeOf(lines.map(({ x, y }) => y.filter((_, k) => x[k] >= begin && x[k] <= end)));
    const pad = 0.08 * (high - low) || 1, top = name === "travel" ? 2 * ROW : 3;
    const X = (x) => (x - begin) / (end - begin) * width;
    const Y = (y) => top + (high + pad - y) / (high - low + 2 * pad) * (height - top);
    const chart = svg("svg", { width: LEFT + width + RIGHT, height: height + (axis ? 38 : 6), role: "img", "aria-label": label });
    const inner = svg("svg", { x: LEFT, width, height, overflow: "hidden" });
    for (const y of ticksOf(low - pad, high + pad, height / 30)) {
      const text = isLog ? Number((10 ** y).toPrecision(2)) : y;
      inner.append(svg("line", { class: "grid", x2: width, y1: Y(y), y2: Y(y) }));
      chart.append(svg("text", { x: LEFT - 5, y: Y(y) + 4, "text-anchor": "end" }, String(text)));
    }
    for (const x of ticksOf(begin, end, width / 80)) {
      inner.append(svg("line", { class: "grid", x1: X(x), x2: X(x), y2: height }));
      if (axis) chart.append(svg("text", { x: LEFT + X(x), y: height + ROW, "text-anchor": "middle" }, String(x)));
    }
    chart.append(svg("text", { x: LEFT + width / 2, y: height + 32, "text-anchor": "middle" }, axis));
    chart.append(svg("text", { transform: `translate(12 ${height / 2}) rotate(-90)`, "text-anchor": "middle" }, label));
    for (const line of lines) inner.append(svg("path", { class: line.look, stroke: line.colour, d: pathOf(line, X, Y, this.window) }));
    if (this.cursor !== null) inner.append(svg("line", { class: "cursor", x1: X(this.cursor), x2: X(this.cursor), y2: height }));
    if (name === "travel") this.addMarks(inner, X, Y);
    chart.append(inner);
    return chart;
  }

  addMarks(inner, X, Y) { // a name once for all poles, the names in two rows by turns
    const named = new Set();
    for (const mark of this.data.marks.sort((a, b) => a.x - b.x)) {
      const [x, y] = [X(mark.x), Y(mark.y)];
      inner.append(svg("circle", { cx: x, cy: y, r: 4, fill: mark.colour }));
      if (named.has(mark.name)) continue;
      const above = ROW * (named.size % 2);
      named.add(mark.name);
      inner.append(svg("line", { class: "mark", x1: x, x2: x, y1: above, y2: y }));
      inner.append(svg("text", { x: x + 4, y: above + 10 }, mark.name));
    }
  }
}

function rangeOf(lists) {
  const known = lists.flat().filter(Number.isFinite); // not null, nor of log(0)
  if (!known.length) return [0, 1];
  return [known.reduce((a, b) => Math.min(a, b)), known.reduce((a, b) => Math.max(a, b))];
}

function pathOf({ x, y }, X, Y, [begin, end]) { // samples that are shown, and one beyond each end
  let path = "", pen = "M";
  for (let k = 0; k < x.length; k += 1) {
    if (x[k + 1] < begin || x[k - 1] > end || !Number.isFinite(y[k]) || x[k] === null) {
      pen = "M";
      continue;
    }
    path += `${pen}${X(x[k]).toFixed(1)} ${Y(y[k]).toFixed(1)}`;
    pen = "L";
  }
  return path;
}
