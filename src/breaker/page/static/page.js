"use strict";
// The list asks for its verdicts one by one; an inspection draws its curves and switches its tabs.

const byId = (id) => document.getElementById(id);
const all = (selector) => [...document.querySelectorAll(selector)];

async function judgeList() {
  for (const row of all("tr[data-query]")) {
    const cell = row.querySelector(".verdict");
    if (cell.textContent) continue; // the file cannot be read
    const answer = await fetch(`/verdict?${row.dataset.query}`);
    const { verdict, text } = answer.ok ? await answer.json() : { verdict: "unread", text: "not readable" };
    Object.assign(cell, { textContent: text, className: `verdict ${verdict}` });
  }
  document.body.dataset.complete = "";
}

function prepareInspection() {
  const say = (text) => { byId("reading").textContent = text; };
  const plots = JSON.parse(byId("data")?.textContent ?? "[]").map((data, k) => new Plot(byId(`plot${k}`), data, say));
  for (const tab of all("[role=tab]")) tab.addEventListener("click", () => {
    for (const other of all("[role=tab]")) {
      other.setAttribute("aria-selected", String(other === tab));
      byId(other.getAttribute("aria-controls")).hidden = other !== tab;
    }
  });
  byId("earlier")?.addEventListener("change", (event) => location.assign(`/inspection?${event.target.value}`));
  byId("settings").addEventListener("change", () => byId("settings").requestSubmit());
  document.body.dataset.complete = plots.length;
}

if (byId("list")) judgeList();
if (byId("screen")) prepareInspection();
