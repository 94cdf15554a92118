"use strict";
// Lists, tabs and tables work with what the server sends; nothing is measured here.

const byId = (id) => document.getElementById(id);
const all = (selector, within = document) => [...within.querySelectorAll(selector)];
const say = (text) => { byId("busy").textContent = text; };
const parsed = (html) => new DOMParser().parseFromString(html, "text/html");

async function ask(address, options) {
  let answer;
  try {
    answer = await fetch(address, options);
  } catch {
    throw new Error("breaker view does not answer: was it ended? Start it again in the terminal");
  }
  if (answer.ok) return answer;
  const text = parsed(await answer.text()).getElementById("error")?.textContent;
  throw Object.assign(new Error(text ?? `error ${answer.status}`), { status: answer.status });
}

const json = async (address, options) => (await ask(address, options)).json();
const post = (address, body) => json(address, { method: "POST", body });

// ---- the list ----

let sorted = { column: null, sign: 1 };

async function fillList() {
  for (;;) {
    const list = byId("list"), { seen, count } = list.dataset;
    arrange();
    if (seen === count) break;
    byId("progress").textContent = `read the headers of ${seen} of ${count} files`;
    const focused = document.activeElement?.closest("tr")?.dataset.query;
    list.replaceWith(parsed(await (await ask("/?look=1")).text()).getElementById("list"));
    if (focused) all("tr").find((row) => row.dataset.query === focused)?.querySelector("a").focus();
  }
  const rows = all("#list tr[data-query]").filter((row) => !row.dataset.verdict);
  for (const [k, row] of rows.entries()) {
    byId("progress").textContent = `judged ${k} of ${rows.length} inspections`;
    const { verdict, text } = await json(`/verdict?${row.dataset.query}`);
    row.dataset.verdict = verdict;
    const cell = row.querySelector(".verdict");
    cell.textContent = text;
    cell.className = `verdict ${verdict}`;
    arrange();
  }
  byId("progress").textContent = "";
}

function arrange() {
  const words = byId("search").value.toLowerCase().split(/\s+/), only = byId("only").value;
  const key = (row) => row.cells[sorted.column]?.textContent.trim() ?? "";
  for (const group of all("#list tbody")) {
    const rows = all("tr[data-query]", group), head = group.querySelector(".breaker").textContent;
    if (sorted.column !== null) {
      rows.sort((a, b) => sorted.sign * key(a).localeCompare(key(b), "en", { numeric: true }));
      group.append(...rows);
    }
    for (const row of rows) {
      const text = `${head} ${row.textContent} ${row.dataset.verdict}`.toLowerCase();
      row.hidden = !words.every((word) => text.includes(word)) || (only && row.dataset.verdict !== only);
    }
    group.hidden = rows.every((row) => row.hidden);
  }
}

async function drop(files) {
  if (!files.length) return;
  const body = new FormData();
  for (const file of files) body.append("file", file);
  say("reading ...");
  try {
    await post("/drop", body);
    location.assign("/");
  } catch (error) {
    say(error.message);
  }
}

function prepareList() {
  byId("search").addEventListener("input", arrange);
  byId("only").addEventListener("change", arrange);
  document.addEventListener("click", (event) => {
    const column = event.target.dataset?.sort;
    if (column === undefined) return;
    sorted = { column, sign: sorted.column === column ? -sorted.sign : 1 };
    arrange();
  });
  byId("add").addEventListener("change", (event) => drop(event.target.files));
  fillList().catch((error) => say(error.message));
}

// ---- an inspection ----

const plots = new Map(); // by tab
let marks = [], tab = 0;

const query = () => byId("screen").dataset.query;

function openWithType(type) { // the same inspection, in its present state
  const now = new URLSearchParams(query());
  now.delete("state");
  now.set("type", type);
  location.replace(`/inspection?${now}`);
}

async function showTab(number) {
  tab = number;
  for (const button of all("[role=tab]")) button.setAttribute("aria-selected", String(Number(button.dataset.tab) === tab));
  for (const part of all(".values, .plot")) part.hidden = Number(part.dataset.tab) !== tab;
  if (!plots.has(tab)) {
    const place = document.createElement("div");
    Object.assign(place, { id: `plot${tab}`, className: "plot" });
    place.dataset.tab = tab;
    byId("curves").append(place);
    plots.set(tab, null); // it is on its way
    const data = await json(`/curves?${query()}&tab=${number}`);
    plots.set(number, new Plot(place, data, showReadings));
    byId("notes").textContent = data.notes.join(" ");
  }
  addMarks();
}

function addMarks() {
  for (const [number, plot] of plots) if (plot && marks[number]) {
    plot.marks = marks[number];
    plot.draw();
  }
}

function showReadings(cursors, travels) {
  const words = [];
  for (const [k, at] of cursors.entries()) if (at !== null) {
    const values = travels(at).map(([phase, travel]) => `${phase} ${travel?.toFixed(2) ?? "–"} mm`);
    words.push(`${k + 1}: ${at.toFixed(2)} ms ${values.join(", ")}`);
  }
  if (!cursors.includes(null)) words.push(`difference: ${(cursors[1] - cursors[0]).toFixed(2)} ms`);
  byId("readings").textContent = words.join("; ");
}

function showSpot(button) { // where a value was measured
  for (const other of all(".spot[aria-pressed]")) other.removeAttribute("aria-pressed");
  button.setAttribute("aria-pressed", "true");
  const plot = plots.get(tab);
  if (!plot) return;
  plot.spot = [Number(button.dataset.from), Number(button.dataset.to)];
  plot.draw();
}

function put({ parts, remarks, marks: found }) {
  const { ariaLabel, value } = document.activeElement; // of a limit that is being typed
  for (const [id, html] of Object.entries(parts)) byId(id).replaceChildren(...parsed(html).body.childNodes);
  byId("remarkcount").textContent = remarks;
  byId("remarkbox").hidden = !remarks;
  for (const table of all(".values")) table.hidden = Number(table.dataset.tab) !== tab;
  const typed = all(".values:not([hidden]) input").find((field) => field.ariaLabel === ariaLabel);
  if (typed) {
    typed.focus();
    typed.value = value;
  }
  marks = found;
  addMarks();
}

async function saveLimit(event) {
  const fields = all("input", event.target.closest("tr, p, span")), type = byId("type").value.trim();
  const key = fields[0].dataset.key, ends = fields.map((field) => field.value.trim());
  try {
    if (event.target.matches(".zone") && ends.some((end) => !end) && ends.some(Boolean)) throw new Error("Write both ends of the zone.");
    byId("said").textContent = (await post("/set", JSON.stringify({ type, key, ends }))).text;
    openWithType(type);
  } catch (error) {
    byId("said").textContent = error.message;
    byId("said").className = "bad";
    if (!type) byId("type").focus();
  }
}

async function saveSheet() {
  say("The sheet is being made ...");
  try {
    const link = document.createElement("a");
    link.href = URL.createObjectURL(await (await ask(`/sheet?${query()}`)).blob());
    link.download = "sheet.html";
    link.click();
    say("");
  } catch (error) {
    say(error.message);
  }
}

async function fillInspection() {
  await showTab(0).catch((error) => { byId("curves").textContent = error.message; });
  document.body.dataset.drawn = Math.round(performance.now());
  if (byId("screen").hasAttribute("data-trouble")) return;
  put(await json(`/values?${query()}`));
  document.body.dataset.measured = Math.round(performance.now());
  addEventListener("focus", renew);
  put(await json(`/model?${query()}`));
  document.body.dataset.complete = Math.round(performance.now());
}

async function renew() { // another window may have changed limits, and a program the files
  await ask(`/values?${query()}`).catch((error) => { if (error.status === 409) location.reload(); });
}

function prepareInspection() {
  document.addEventListener("change", (event) => { if (event.target.matches(".limit, .zone")) saveLimit(event); });
  document.addEventListener("click", (event) => { if (event.target.matches(".spot")) showSpot(event.target); });
  for (const button of all("[role=tab]")) button.addEventListener("click", () => showTab(Number(button.dataset.tab)));
  byId("earlier")?.addEventListener("change", (event) => location.assign(`/inspection?${event.target.value}`));
  byId("settings").addEventListener("change", () => byId("settings").requestSubmit());
  byId("type").addEventListener("change", (event) => openWithType(event.target.value));
  byId("sheet")?.addEventListener("click", saveSheet);
  byId("import").addEventListener("change", async (event) => {
    const answer = await post("/import", event.target.files[0]).catch((error) => ({ error }));
    byId("said").textContent = answer.error?.message ?? answer.text;
    if (!answer.error) location.reload();
  });
  fillInspection().catch((error) => say(error.message));
}

for (const name of ["dragenter", "dragover"]) {
  addEventListener(name, (event) => { event.preventDefault(); document.body.classList.add("drop"); });
}
addEventListener("dragleave", () => document.body.classList.remove("drop"));
addEventListener("drop", (event) => {
  event.preventDefault();
  drop(event.dataTransfer.files);
});
if (byId("list")) prepareList();
if (byId("screen")) prepareInspection();
