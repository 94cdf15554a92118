"use strict";
// What a browser adds to pages that work without: curves, cursors, and changes without a new page.
// It computes nothing: readings, marks and differences come from the server.

const byId = (id) => document.getElementById(id);
const busy = (text) => { byId("busy").textContent = text; };
let plot = null; // of the curves: what cursors and a zoom change
let current = new AbortController(); // of the page that stands: what it still asks for ends with it

async function answer(address, options) {
  let got;
  try {
    got = await fetch(address, options);
  } catch (error) {
    if (error.name === "AbortError") throw error;
    throw new Error("breaker view does not answer: was it ended? Start it again in the terminal");
  }
  if (got.ok) return got;
  const page = new DOMParser().parseFromString(await got.text(), "text/html");
  throw new Error(page.getElementById("error")?.textContent ?? `error ${got.status}`);
}

// ---- a page in place of another ----

async function show(address, push) {
  busy("reading ...");
  const started = performance.now();
  const focused = document.activeElement?.id;
  current.abort();
  const own = current = new AbortController();
  let text;
  try {
    text = await (await answer(address, { signal: own.signal })).text();
  } catch (error) {
    if (own === current) busy(error.message);
    return;
  }
  if (own !== current) return; // another page was asked for since
  const found = new DOMParser().parseFromString(text, "text/html");
  if (push) history.pushState(null, "", address);
  document.title = found.title;
  const curves = byId("curves");
  byId("main").replaceWith(found.getElementById("main"));
  prepare();
  busy("");
  if (focused) byId(focused)?.focus({ preventScroll: true });
  await draw(curves);
  document.body.dataset.took = Math.round(performance.now() - started);
  await complete();
}

function prepare() {
  const form = byId("settings");
  if (form) {
    const again = () => show("/visit?" + new URLSearchParams(new FormData(form)), true);
    form.addEventListener("change", again);
    form.addEventListener("submit", (event) => { event.preventDefault(); again(); });
  }
  for (const each of document.querySelectorAll("form.save")) each.addEventListener("submit", save);
  for (const id of ["cursor1", "cursor2"]) byId(id)?.addEventListener("change", readCursors);
}

// ---- what takes longer: files of a list, values of a visit ----

async function complete() {
  const list = byId("list"), top = byId("top"), signal = current.signal;
  while (list?.isConnected && list.querySelector("tr[data-pending]")) {
    let page;
    try {
      page = await answer(`/?page=${list.dataset.page}&look=5`, { signal });
    } catch (error) {
      if (error.name === "AbortError") return;
      busy(error.message);
      return;
    }
    const found = new DOMParser().parseFromString(await page.text(), "text/html");
    const rows = new Map([...found.querySelectorAll("#list tbody tr")].map((row) => [row.querySelector("input").value, row]));
    let changed = false;
    for (const old of list.querySelectorAll("tr[data-pending]")) {
      const row = rows.get(old.querySelector("input").value);
      if (!row || row.hasAttribute("data-pending")) continue;
      // What can be clicked stays: a row may be in use.
      while (old.cells.length > 3) old.deleteCell(3);
      old.append(...[...row.cells].slice(3));
      old.removeAttribute("data-pending");
      changed = true;
    }
    const looked = found.getElementById("looked");
    if (looked) byId("looked")?.replaceChildren(...looked.childNodes);
    else byId("looked")?.remove();
    if (!changed) return;
  }
  if (!top) return;
  const query = top.dataset.address;
  let part, marks;
  try {
    part = await (await answer("/answer?" + query, { signal })).text();
    marks = await (await answer("/marks?" + query, { signal })).json();
  } catch (error) {
    if (error.name === "AbortError") return;
    if (top.isConnected) { top.textContent = error.message; top.className = "verdict bad"; }
    return;
  }
  if (!top.isConnected) return; // another page is shown by now
  const found = new DOMParser().parseFromString(part, "text/html");
  for (const each of found.querySelectorAll("[data-place]")) byId(each.dataset.place).replaceChildren(...each.childNodes);
  if (plot?.query === byId("curves").dataset.query) fillMarks(plot.marks, marks.marks);
}

async function save(event) {
  event.preventDefault();
  const form = event.target, said = byId("saved");
  said.textContent = "";
  try {
    const body = new URLSearchParams(new FormData(form));
    said.textContent = await (await answer("/save?" + form.dataset.query, { method: "POST", body })).text();
  } catch (error) {
    said.textContent = error.message;
  }
}

// ---- curves ----

const COLOURS = ["#2166ac", "#d6604d", "#1b9e77", "#8856a7", "#b8860b", "#1f9fb4", "#a6761d", "#7f7f7f"];
const DARK = ["#6baed6", "#fc8d62", "#66c2a5", "#b39ddb", "#e6c35c", "#66d9e8", "#d2a56d", "#bdbdbd"];
const PANELS = { // label and height by kind of channel, in their order
  travel: ["travel (mm)", 340], coil: ["coil", 150], contact: ["contact", 130], other: ["others, as in the file", 170],
};
const columns = (items) => Math.ceil(items.length / 17); // of a legend: so many rows are as high as the panel of travels
const numbers = (list) => list.map((each) => (each === null ? NaN : each));
// Bokeh takes these signs for formulas, which it would have to load from elsewhere.
const plainly = (text) => text.replace(/\$(?=\$)|\\(?=[[\]()])/g, "$&\u200b");
const points = (line) => Object.fromEntries(["x", "y", "low", "high"].filter((key) => key in line).map((key) => [key, numbers(line[key])]));

function tint() {
  return matchMedia("(prefers-color-scheme: dark)").matches
    ? { ink: "#e8e8e8", paper: "#17191c", line: "#454a50", colours: DARK }
    : { ink: "#1a1a1a", paper: "#ffffff", line: "#dddddd", colours: COLOURS };
}

function looks(figure, ink, paper, line) {
  figure.background_fill_color = figure.border_fill_color = paper;
  figure.outline_line_color = line;
  for (const axis of [...figure.xaxes, ...figure.yaxes]) {
    axis.axis_label_text_color = axis.major_label_text_color = ink;
    axis.axis_line_color = axis.major_tick_line_color = axis.minor_tick_line_color = line;
  }
  for (const grid of [...figure.xgrids, ...figure.ygrids]) grid.grid_line_color = line;
}

function panel(label, height, range) {
  return Bokeh.Plotting.figure({
    height, x_range: range, y_range: new Bokeh.DataRange1d({ only_visible: true }), sizing_mode: "stretch_width", y_axis_label: label,
    tools: "xpan,xwheel_zoom,box_zoom,undo,reset,save", active_drag: "xpan", active_scroll: "xwheel_zoom",
    output_backend: "canvas",
  });
}

async function toDraw(path, place) { // nothing where no curves are, or none can be drawn
  if (!place || !globalThis.Bokeh) return null;
  try {
    return await (await answer(`${path}?${place.dataset.query}`, { signal: current.signal })).json();
  } catch (error) {
    if (error.name !== "AbortError") place.textContent = error.message;
    return null;
  }
}

async function draw(before) {
  const place = byId("curves"), old = plot;
  plot = null;
  const data = await toDraw("/curves", place);
  if (!data) return;
  const names = JSON.stringify([data.clock, data.traces.map((trace) => [trace.kind, trace.name, trace.unit, trace.laid, "low" in trace])]);
  if (before && old?.names === names) { // the same channels, read otherwise: nothing is built anew
    redraw(before, place, old, data);
    return;
  }
  const { ink, paper, line, colours } = tint();
  const range = new Bokeh.Range1d({ start: data.from, end: data.to });
  const panels = new Map(), sources = [];
  for (const trace of data.traces) {
    if (!panels.has(trace.kind)) panels.set(trace.kind, panel(...PANELS[trace.kind], range));
    const figure = panels.get(trace.kind), items = figure.items ??= [];
    const source = new Bokeh.ColumnDataSource({ data: points(trace) });
    sources.push(source);
    const name = plainly(trace.unit && trace.kind !== "travel" ? `${trace.name} (${trace.unit})` : trace.name);
    const glyph = figure.line({ field: "x" }, { field: "y" }, {
      source, line_width: 1.5, line_color: trace.low ? ink : colours[items.length % colours.length],
      line_dash: trace.low ? "dashed" : trace.laid ? "dotted" : "solid",
    });
    if (trace.low) figure.varea({ field: "x" }, { field: "low" }, { field: "high" }, { source, fill_color: ink, fill_alpha: 0.12 });
    glyph.visible = trace.kind !== "other" || !items.length; // of a dozen, those that are asked for
    items.push(new Bokeh.LegendItem({ label: { value: name }, renderers: [glyph] }));
  }
  const shown = Object.keys(PANELS).filter((kind) => panels.has(kind)).map((kind) => panels.get(kind));
  const empty = (...names) => new Bokeh.ColumnDataSource({ data: Object.fromEntries(names.map((name) => [name, []])) });
  const cursors = [0, 1].map((k) => {
    const source = empty("x");
    for (const figure of shown) {
      figure.vspan({ field: "x" }, { source, line_color: ink, line_width: 2, line_dash: k ? "dotted" : "solid" });
    }
    return source;
  });
  const marks = { times: empty("x"), told: empty("x"), zones: empty("x0", "x1"), points: empty("x", "y", "name") };
  if (shown.length) addMarks(shown[0], marks, colours, ink);
  for (const figure of shown) {
    looks(figure, ink, paper, line);
    figure.height = Math.max(figure.height, 30 + 19 * Math.ceil(figure.items.length / columns(figure.items))); // of its legend
    figure.y_range.renderers = figure.items.flatMap((item) => item.renderers);
    figure.add_layout(legend(figure.items, ink, paper), "right");
    figure.on_event("tap", (event) => setCursor(event));
  }
  if (shown.length) shown.at(-1).xaxis.axis_label = `time (${data.clock})`;
  place.replaceChildren();
  await together(shown, place);
  plot = { cursors, marks, sources, range, names, from: data.from, to: data.to, query: place.dataset.query };
  let timer = null;
  for (const end of [range.properties.start, range.properties.end]) {
    end.change.connect(() => {
      clearTimeout(timer);
      timer = setTimeout(() => zoomed(range, sources, place), 150);
    });
  }
}

async function together(figures, place) { // one below another, with one bar of tools: half the time
  const grid = Bokeh.Plotting.gridplot(figures.map((each) => [each]), { toolbar_location: "right", merge_tools: true, sizing_mode: "stretch_width" });
  grid.toolbar.logo = null;
  await Bokeh.Plotting.show(grid, place);
}

function legend(items, ink, paper) {
  return new Bokeh.Legend({ items, ncols: columns(items), click_policy: "hide", background_fill_color: paper,
    border_line_color: null, label_text_color: ink, label_text_font_size: "11px", spacing: 0, padding: 2,
    inactive_fill_color: paper, inactive_fill_alpha: 0.7 });
}

function redraw(before, place, old, data) {
  before.dataset.query = place.dataset.query;
  place.replaceWith(before);
  data.traces.forEach((trace, k) => { old.sources[k].data = points(trace); });
  const zoom = old.range.start !== old.from || old.range.end !== old.to;
  if (data.from !== old.from || data.to !== old.to) Object.assign(old.range, { start: data.from, end: data.to });
  else if (zoom) zoomed(old.range, old.sources, before);
  for (const each of old.cursors) each.data = { x: [] };
  plot = { ...old, from: data.from, to: data.to, query: before.dataset.query };
  fillMarks(plot.marks, []);
}

function addMarks(figure, marks, colours, ink) {
  figure.vstrip({ field: "x0" }, { field: "x1" }, { source: marks.zones, fill_color: colours[3], fill_alpha: 0.05, line_color: null });
  for (const [source, dash] of [[marks.times, "dashed"], [marks.told, "dotted"]]) {
    figure.vspan({ field: "x" }, { source, line_color: colours[1], line_alpha: 0.6, line_dash: dash });
  }
  const glyph = figure.scatter({ field: "x" }, { field: "y" }, { source: marks.points, size: 8, marker: "diamond", color: ink });
  figure.add_tools(new Bokeh.HoverTool({ renderers: [glyph], tooltips: [["", "@name"], ["ms", "@x{0.00}"], ["mm", "@y{0.00}"]] }));
}

function fillMarks(sources, marks) {
  const times = marks.filter((mark) => mark.x[0] === mark.x[1]), zones = marks.filter((mark) => mark.x[0] !== mark.x[1]);
  const at = (list) => ({ x: list.map((mark) => mark.x[0]) });
  sources.times.data = at(times.filter((mark) => !mark.inferred));
  sources.told.data = at(times.filter((mark) => mark.inferred));
  sources.zones.data = { x0: zones.map((mark) => mark.x[0]), x1: zones.map((mark) => mark.x[1]) };
  const points = [...times.map((mark) => [mark, 0]), ...zones.flatMap((mark) => [[mark, 0], [mark, 1]])]
    .filter(([mark, k]) => mark.y[k] !== null);
  sources.points.data = {
    x: points.map(([mark, k]) => mark.x[k]), y: points.map(([mark, k]) => mark.y[k]), name: points.map(([mark]) => mark.name),
  };
}

async function zoomed(range, sources, place) {
  const part = `&from=${range.start}&to=${range.end}`;
  try {
    const data = await (await answer("/curves?" + place.dataset.query + part)).json();
    data.traces.forEach((trace, k) => { sources[k].data = points(trace); });
  } catch (error) {
    busy(error.message);
  }
}

function setCursor(event) {
  const field = byId(event.modifiers?.shift ? "cursor2" : "cursor1");
  field.value = event.x.toFixed(3);
  readCursors();
}

async function readCursors() {
  if (!plot) return;
  const fields = [byId("cursor1"), byId("cursor2")];
  plot.cursors.forEach((source, k) => { source.data = { x: fields[k].value === "" ? [] : [Number(fields[k].value)] }; });
  if (fields.some((field) => field.value === "")) return;
  try {
    const found = await answer(`/cursors?${plot.query}&first=${fields[0].value}&second=${fields[1].value}`);
    const page = new DOMParser().parseFromString(await found.text(), "text/html");
    byId("readings").replaceChildren(...page.body.children);
  } catch (error) {
    busy(error.message);
  }
}

addEventListener("popstate", () => show(location.href, false));
prepare();
draw().then(() => { document.body.dataset.took = Math.round(performance.now()); }).then(complete);
