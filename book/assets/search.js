// How the search ranks: titles and prose before names of Python objects.
"use strict";
var Scorer = {
  score: ([page, title, anchor, description, score]) => (page.startsWith("reference/api") ? score - 100 : score),
  objNameMatch: 2,
  objPartialMatch: 1,
  objPrio: { 0: 1, 1: 0, 2: -1 },
  objPrioDefault: 0,
  title: 30,
  partialTitle: 14,
  term: 5,
  partialTerm: 2,
};

// Under each result, how its page begins.
document.addEventListener("DOMContentLoaded", () => {
  const results = document.getElementById("search-results");
  if (!results || !window.leads) return;
  const root = new URL(document.documentElement.dataset.content_root || "./", location.href).href;
  new MutationObserver(() => {
    for (const item of results.querySelectorAll("li:not(:has(.lead))")) {
      const link = item.querySelector("a");
      const text = link && window.leads[link.href.slice(root.length).replace(/\.html.*$/, "")];
      if (!text) continue;
      const shown = document.createElement("p");
      shown.className = "lead";
      shown.textContent = text.length > 240 ? text.slice(0, 240) + "…" : text;
      item.append(shown);
    }
  }).observe(results, { childList: true, subtree: true });
});
