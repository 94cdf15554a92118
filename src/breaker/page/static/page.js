"use strict";
// Lists, tabs and tables work with what the server sends; nothing is measured here.

const byId = (id) => document.getElementById(id);
const all = (selector, within = document) => [...within.querySelectorAll(selector)];
const busy = (text) => { byId("busy").textContent = text; };
const dark = matchMedia("(prefers-color-scheme: dark)");

async function ask(address, options) {
  let got;
  try {
    got = await fetch(address, options);
  } catch {
    throw new Error("breaker view does not answer: was it ended? Start it again in the terminal");
  }
  if (got.ok) return got;
  const page = new DOMParser().parseFromString(await got.text(), "text/html");
  throw new Error(page.getElementById("error")?.textContent ?? `error ${got.status}`);
}

const post = async (address, body) => (await ask(address, { method: "POST", body })).json();

// ---- the list ----

let sorted = { column: null, sign: 1 };

async function fillList() {
  for (;;) {
    const list = byId("list");
    arrange();
    if (Number(list.dataset.seen) >= Number(list.dataset.count)) break;
    byId("progress").textContent = `read the headers of ${list.dataset.seen} of ${list.dataset.count} files`;
    const page = new DOMParser().parseFromString(await (await ask("/?look=1")).text(), "text/html");
    const before = document.activeElement?.closest("tr")?.dataset.query;
    list.replaceWith(page.getElementById("list"));
    if (before) all("tr").find((row) => row.dataset.query === before)?.querySelector("a").focus();
  }
  const rows = all("#list tr[data-query]").filter((row) => !row.dataset.verdict);
  for (const [k, row] of rows.entries()) {
    byId("progress").textContent = `judged ${k} of ${rows.length} inspections`;
    const found = await (await ask(`/verdict?${row.dataset.query}`)).json();
    row.dataset.verdict = found.verdict;
    const cell = row.querySelector(".verdict");
    const word = { fail: "FAIL: ", inconclusive: "inconclusive: ", pass: "pass: ", none: "no limits", unread: "not readable: " };
    cell.textContent = word[found.verdict] + found.text;
    cell.className = `verdict ${{ fail: "bad", pass: "good", inconclusive: "doubt" }[found.verdict] ?? "faint"}`;
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
  busy("reading ...");
  await post("/drop", body);
  location.assign("/");
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
  byId("add").addEventListener("change", (event) => drop(event.target.files).catch((error) => busy(error.message)));
  fillList().catch((error) => busy(error.message));
}

// ---- an inspection ----

const views = new Map(); // documents of Bokeh by tab
let marks = [], tab = 0;

const query = () => byId("screen").dataset.query;

function change(name, values) { // all models of a name
  for (const model of views.get(tab)?._all_models.values() ?? []) if (model.name === name) Object.assign(model, values);
}

async function showTab(number) {
  tab = number;
  for (const each of all("[role=tab]")) each.setAttribute("aria-selected", String(Number(each.dataset.tab) === tab));
  for (const each of all(".values")) each.hidden = Number(each.dataset.tab) !== tab;
  for (const each of all(".plot")) each.hidden = Number(each.dataset.tab) !== tab;
  if (!byId(`plot${tab}`)) {
    const place = document.createElement("div");
    Object.assign(place, { id: `plot${tab}`, className: "plot" });
    place.dataset.tab = tab;
    byId("curves").append(place);
    const item = await (await ask(`/curves?${query()}&tab=${tab}${dark.matches ? "&dark=1" : ""}`)).json();
    const manager = await Bokeh.embed.embed_item(item, place.id);
    const root = manager.roots[0].model;
    views.set(number, root.document);
    for (const model of root.document._all_models.values()) {
      if (model.name === "over time") model.on_event("tap", (event) => setCursor(event.x, event.modifiers?.shift));
    }
  }
  if (marks[tab]) for (const [name, data] of Object.entries(marks[tab])) change(name, { data });
}

const cursors = [null, null];

function setCursor(x, second) {
  cursors[second ? 1 : 0] = x;
  cursors.forEach((at, k) => change(`cursor${k + 1}`, { location: at, visible: at !== null }));
  const [one, two] = cursors, words = [];
  for (const [k, at] of cursors.entries()) if (at !== null) words.push(`${k + 1}: ${at.toFixed(2)} ms ${read(at)}`);
  if (one !== null && two !== null) words.push(`apart: ${(two - one).toFixed(2)} ms`);
  byId("readings").textContent = words.join("; ");
}

function read(at) { // travels at the sample nearest to a cursor
  const found = [];
  for (const model of views.get(tab)._all_models.values()) {
    const { x, y } = model.data instanceof Map ? Object.fromEntries(model.data) : model.data ?? {};
    if (!model.name?.endsWith(" travel") || !x?.length) continue;
    let best = 0;
    for (let k = 0; k < x.length; k++) if (Math.abs(x[k] - at) < Math.abs(x[best] - at)) best = k;
    found.push(`${model.name.replace(/ ?travel$/, "")} ${Number(y[best]).toFixed(2)} mm`.trim());
  }
  return found.join(", ");
}

function put(answer) {
  for (const [id, html] of Object.entries(answer.parts)) {
    if (id === "model" && !html) continue;
    byId(id).replaceChildren(...new DOMParser().parseFromString(html, "text/html").body.childNodes);
  }
  byId("remarkcount").textContent = answer.counts.remarks;
  byId("remarkbox").hidden = !answer.counts.remarks;
  marks = answer.marks;
  for (const each of all(".spot")) each.addEventListener("click", () => showSpot(each));
}

function showSpot(button) {
  for (const each of all(".spot")) each.setAttribute("aria-pressed", String(each === button));
  change("spot", { left: Number(button.dataset.from), right: Number(button.dataset.to), visible: true });
}

async function saveLimit(event) {
  const parts = all("input", event.target.closest("tr, p, span")), type = byId("type").value.trim();
  const key = parts[0].dataset.key, ends = parts.map((part) => part.value.trim());
  const zone = event.target.className === "zone";
  if (zone && ends.some((end) => !end) && ends.some(Boolean)) {
    byId("said").textContent = "Write both ends of the zone.";
    return;
  }
  try {
    const body = JSON.stringify({ type, key, ends });
    const said = (await post("/set", body)).text;
    const now = new URLSearchParams(query());
    now.delete("state");
    now.set("type", type);
    location.replace(`/inspection?${now}`);
    byId("said").textContent = said;
  } catch (error) {
    byId("said").textContent = error.message;
    byId("said").className = "bad";
    if (!type) byId("type").focus();
  }
}

async function fillInspection() {
  await showTab(0).catch((error) => { byId("curves").textContent = error.message; });
  document.body.dataset.drawn = Math.round(performance.now());
  if (byId("screen").hasAttribute("data-trouble")) return;
  put(await (await ask(`/values?${query()}`)).json());
  await showTab(tab);
  document.body.dataset.measured = Math.round(performance.now());
  put(await (await ask(`/model?${query()}&model=1`)).json());
  await showTab(tab);
  document.body.dataset.complete = Math.round(performance.now());
}

function prepareInspection() {
  document.addEventListener("change", (event) => { if (event.target.matches(".limit, .zone")) saveLimit(event); });
  for (const each of all("[role=tab]")) each.addEventListener("click", () => showTab(Number(each.dataset.tab)));
  byId("earlier")?.addEventListener("change", (event) => location.assign(`/inspection?${event.target.value}`));
  byId("settings").addEventListener("change", () => byId("settings").requestSubmit());
  byId("type").addEventListener("change", (event) => {
    const now = new URLSearchParams(query());
    now.delete("state");
    now.set("type", event.target.value);
    location.assign(`/inspection?${now}`);
  });
  byId("import").addEventListener("change", async (event) => {
    try {
      await post("/import", event.target.files[0]);
      location.reload();
    } catch (error) {
      byId("said").textContent = error.message;
    }
  });
  byId("save").addEventListener("submit", async (event) => {
    event.preventDefault();
    try {
      byId("saved").textContent = (await post(`/save?${query()}`, byId("settings-name").value)).text;
    } catch (error) {
      byId("saved").textContent = error.message;
    }
  });
  dark.addEventListener("change", () => location.reload());
  fillInspection().catch((error) => busy(error.message));
}

for (const name of ["dragenter", "dragover"]) {
  addEventListener(name, (event) => { event.preventDefault(); document.body.classList.add("drop"); });
}
addEventListener("dragleave", () => document.body.classList.remove("drop"));
addEventListener("drop", (event) => {
  event.preventDefault();
  drop(event.dataTransfer.files).catch((error) => busy(error.message));
});
if (byId("list")) prepareList();
if (byId("screen")) prepareInspection();
