"use strict";
// The list and an inspection are filled with what the server sends; nothing is measured here.

const byId = (id) => document.getElementById(id);
const all = (selector) => [...document.querySelectorAll(selector)];
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
  throw new Error(parsed(await answer.text()).getElementById("error")?.textContent ?? `error ${answer.status}`);
}

const json = async (address, options) => (await ask(address, options)).json();

// ---- the list ----

async function fillList() {
  for (;;) { // until all files are described
    const list = byId("list"), { seen, count } = list.dataset;
    if (seen === count) break;
    say(`read the headers of ${seen} of ${count} files`);
    list.replaceWith(parsed(await (await ask("/?look=1")).text()).getElementById("list"));
  }
  const rows = all("#list tr[data-query]:not([data-verdict])");
  for (const [k, row] of rows.entries()) {
    say(`judged ${k} of ${rows.length} inspections`);
    const { verdict, text } = await json(`/verdict?${row.dataset.query}`);
    row.dataset.verdict = verdict;
    Object.assign(row.querySelector(".verdict"), { textContent: text, className: `verdict ${verdict}` });
  }
  say("");
}

// ---- an inspection ----

const plots = new Map(); // by tab
const query = location.search.slice(1);
let marks = [], tab = 0;

function openWithType(type) {
  const now = new URLSearchParams(query);
  now.set("type", type);
  location.replace(`/inspection?${now}`);
}

function showTables() {
  for (const table of all(".values")) table.hidden = Number(table.dataset.tab) !== tab;
}

async function showTab(number) {
  tab = number;
  for (const button of all("[role=tab]")) button.setAttribute("aria-selected", String(Number(button.dataset.tab) === tab));
  for (const plot of all(".plot")) plot.hidden = Number(plot.dataset.tab) !== tab;
  showTables();
  if (!plots.has(tab)) {
    const place = document.createElement("div");
    Object.assign(place, { id: `plot${tab}`, className: "plot" });
    place.dataset.tab = tab;
    byId("curves").append(place);
    plots.set(tab, null); // it is on its way
    const data = await json(`/curves?${query}&tab=${number}`);
    plots.set(number, new Plot(place, data, (text) => { byId("readings").textContent = text; }));
    byId("notes").textContent = data.notes.join("; ");
  }
  addMarks();
}

function addMarks() {
  for (const [number, plot] of plots) if (plot && marks[number]) {
    plot.marks = marks[number];
    plot.draw();
  }
}

function put({ parts, remarks, marks: events }) {
  for (const [id, html] of Object.entries(parts)) {
    const place = byId(id); // a limit that is being typed stays
    if (!place.contains(document.activeElement)) place.replaceChildren(...parsed(html).body.childNodes);
  }
  byId("remarkcount").textContent = remarks;
  byId("remarkbox").hidden = !remarks;
  showTables();
  marks = events;
  addMarks();
}

async function saveLimit(event) {
  const fields = [...event.target.closest("tr, p").querySelectorAll("input")], type = byId("type").value.trim();
  const key = fields[0].dataset.key, ends = fields.map((field) => field.value.trim());
  if (event.target.matches(".zone") && ends.some((end) => !end) && ends.some(Boolean)) return; // until both are there
  try {
    await json("/set", { method: "POST", body: JSON.stringify({ type, key, ends }) });
    openWithType(type);
  } catch (error) {
    Object.assign(byId("said"), { textContent: error.message, className: "bad" });
    if (!type) byId("type").focus();
  }
}

async function saveSheet() {
  say("The sheet is being made ...");
  const link = document.createElement("a");
  link.href = URL.createObjectURL(await (await ask(`/sheet?${query}`)).blob());
  link.download = "sheet.html";
  link.click();
  say("");
}

async function fillInspection() {
  await showTab(0).catch((error) => { byId("curves").textContent = error.message; });
  document.body.dataset.drawn = Math.round(performance.now());
  if (byId("screen").hasAttribute("data-trouble")) return;
  put(await json(`/values?${query}`));
  document.body.dataset.measured = Math.round(performance.now());
  put(await json(`/model?${query}`));
  document.body.dataset.complete = Math.round(performance.now());
}

function prepareInspection() {
  document.addEventListener("change", (event) => { if (event.target.matches(".limit, .zone")) saveLimit(event); });
  for (const button of all("[role=tab]")) button.addEventListener("click", () => showTab(Number(button.dataset.tab)));
  byId("earlier")?.addEventListener("change", (event) => location.assign(`/inspection?${event.target.value}`));
  byId("settings").addEventListener("change", () => byId("settings").requestSubmit());
  byId("type").addEventListener("change", (event) => openWithType(event.target.value));
  byId("sheet")?.addEventListener("click", () => saveSheet().catch((error) => say(error.message)));
  fillInspection().catch((error) => say(error.message));
}

if (byId("list")) fillList().catch((error) => say(error.message));
if (byId("screen")) prepareInspection();
