"use strict";
// Curves as SVG: panels that share their times. The wheel or + and - zoom, dragging or the arrows
// move, a double click or 0 shows all, a click sets a cursor.

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
  constructor(place, data, readings) {
    Object.assign(this, { place, data, readings, window: data.window, marks: [], spot: null });
    this.cursors = [null, null];
    this.hidden = new Set();
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

  legend() { // names of the curves of the travel, each a button that hides it
    const row = document.createElement("div");
    row.className = "legend";
    const panels = this.data.panels.filter((panel, k) => k === 0 || !panel.name); // without a name: of a file
    const curves = panels.flatMap((panel) => panel.curves).sort((a, b) => Boolean(a.look) - Boolean(b.look));
    for (const curve of curves) {
      const name = curve.look ? curve.name : curve.phase || curve.name;
      if ([...row.children].some((made) => made.textContent === name)) continue;
      const made = document.createElement("button");
      Object.assign(made, { type: "button", textContent: name, title: "hide or show" });
      made.setAttribute("aria-pressed", "true");
      if (!curve.look) made.style.borderBottomColor = curve.colour;
      made.addEventListener("click", () => {
        const shown = this.hidden.delete(name);
        if (!shown) this.hidden.add(name);
        made.setAttribute("aria-pressed", String(shown));
        this.draw();
      });
      row.append(made);
    }
    return row;
  }

  shows(curve) {
    return !this.hidden.has(curve.look ? curve.name : curve.phase || curve.name);
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
    let moved = false;
    const move = (now) => {
      moved ||= Math.abs(now.clientX - at) > 3;
      const by = (at - now.clientX) / width * (before[1] - before[0]);
      if (moved) this.show(before.map((end) => end + by));
    };
    const release = (now) => {
      removeEventListener("pointermove", move);
      if (moved) return;
      this.cursors[now.shiftKey ? 1 : 0] = this.timeAt(now);
      this.draw();
      this.readings(this.cursors, this.travels.bind(this));
    };
    addEventListener("pointermove", move);
    addEventListener("pointerup", release, { once: true });
  }

  travels(time) { // at the samples nearest to a time, by phase
    const nearest = (x) => x.reduce((best, at, k) => Math.abs(at - time) < Math.abs(x[best] - time) ? k : best, 0);
    const curves = this.data.panels[0].curves.filter((curve) => curve.name === "travel");
    return curves.map(({ phase, x, y }) => [phase, y[nearest(x)]]);
  }

  draw() {
    const width = this.place.clientWidth - LEFT - RIGHT;
    if (width < 50) return;
    const last = this.data.panels.filter((panel) => panel.name !== "resistance").length - 1;
    this.panels.replaceChildren(...this.data.panels.map((panel, k) => this.panel(panel, width, k === last)));
  }

  panel(panel, width, hasTimes) {
    const overTravel = panel.name === "resistance", curves = panel.curves.filter((curve) => this.shows(curve));
    const xs = overTravel ? rangeOf(curves.map((curve) => curve.x)) : this.window;
    const within = curves.map(({ x, y }) => y.filter((_, k) => x[k] >= xs[0] && x[k] <= xs[1]));
    const scale = overTravel ? Math.log10 : Number, [low, high] = rangeOf(within.map((y) => y.map((one) => one === null ? one : scale(one))));
    const pad = 0.08 * (high - low) || 1, top = panel.name === "travel" ? 2 * ROW : 3, height = panel.height;
    const axis = overTravel ? "travel (mm)" : hasTimes ? this.data.axis : "";
    const X = (x) => (x - xs[0]) / (xs[1] - xs[0]) * width;
    const Y = (y) => top + (high + pad - y) / (high - low + 2 * pad) * (height - top);
    const whole = height + (axis ? 38 : 6), chart = svg("svg", { width: LEFT + width + RIGHT, height: whole, role: "img", "aria-label": panel.label });
    const inner = svg("svg", { x: LEFT, width, height, overflow: "hidden" });
    for (const y of ticksOf(low - pad, high + pad, height / 30)) {
      inner.append(svg("line", { class: "grid", x2: width, y1: Y(y), y2: Y(y) }));
      chart.append(svg("text", { x: LEFT - 5, y: Y(y) + 4, "text-anchor": "end" }, overTravel ? String(Number((10 ** y).toPrecision(2))) : String(y)));
    }
    for (const x of ticksOf(...xs, width / 80)) {
      inner.append(svg("line", { class: "grid", x1: X(x), x2: X(x), y2: height }));
      if (axis) chart.append(svg("text", { x: LEFT + X(x), y: height + ROW, "text-anchor": "middle" }, String(x)));
    }
    if (axis) chart.append(svg("text", { x: LEFT + width / 2, y: height + 32, "text-anchor": "middle" }, axis));
    chart.append(svg("text", { transform: `translate(12 ${height / 2}) rotate(-90)`, "text-anchor": "middle" }, panel.label));
    for (const curve of curves) inner.append(svg("path", { class: `curve ${curve.look}`, stroke: curve.colour, d: pathOf(curve, X, (y) => Y(scale(y)), xs) }));
    if (!overTravel) {
      if (this.spot) inner.append(svg("rect", { class: "spot", x: X(this.spot[0]), width: Math.max(2, X(this.spot[1]) - X(this.spot[0])), height }));
      this.cursors.forEach((at, k) => at !== null && inner.append(svg("line", { class: `cursor${k}`, x1: X(at), x2: X(at), y2: height })));
    }
    if (panel.name === "travel") this.addMarks(inner, X, Y, width);
    chart.append(inner);
    return chart;
  }

  addMarks(inner, X, Y, width) { // a name once for all poles, in a row where it has room
    const named = new Set(), ends = [-1, -1];
    for (const mark of [...this.marks].sort((a, b) => a.x[0] - b.x[0])) {
      if (this.hidden.has(mark.phase)) continue;
      const [x, y] = [X(mark.x[0]), Y(mark.y[0])];
      if (mark.x.length > 1) {
        inner.append(svg("line", { class: "zone", stroke: mark.colour, x1: x, y1: y, x2: X(mark.x[1]), y2: Y(mark.y[1]) }));
        continue;
      }
      const made = svg("circle", { cx: x, cy: y, r: 4, fill: mark.colour });
      made.append(svg("title", {}, `${mark.name} ${mark.phase}: ${mark.x[0].toFixed(2)} ms, ${mark.y[0].toFixed(2)} mm`));
      inner.append(made);
      if (named.has(mark.name) || x < 0 || x > width) continue;
      named.add(mark.name);
      const row = ends[0] < x ? 0 : 1, turned = x > width - 120;
      ends[row] = x + 7 * mark.name.length;
      inner.append(svg("line", { class: "mark", x1: x, x2: x, y1: ROW * row, y2: y }));
      inner.append(svg("text", { x: x + (turned ? -4 : 4), y: ROW * row + 10, "text-anchor": turned ? "end" : "start" }, mark.name));
    }
  }
}

function rangeOf(lists) {
  let low = Infinity, high = -Infinity;
  for (const list of lists) {
    for (const one of list) {
      if (one === null || !Number.isFinite(one)) continue;
      low = Math.min(low, one);
      high = Math.max(high, one);
    }
  }
  return low <= high ? [low, high] : [0, 1];
}

function pathOf({ x, y }, X, Y, [begin, end]) { // samples that are shown, and one beyond each end
  let path = "", pen = "M";
  for (let k = 0; k < x.length; k += 1) {
    if (x[k + 1] < begin || x[k - 1] > end || y[k] === null || x[k] === null) {
      pen = "M";
      continue;
    }
    path += `${pen}${X(x[k]).toFixed(1)} ${Y(y[k]).toFixed(1)}`;
    pen = "L";
  }
  return path;
}
