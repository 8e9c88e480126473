// What the book adds to its theme: tables that scroll by keyboard, figures to enlarge, filters of the scorecards.
"use strict";
document.addEventListener("DOMContentLoaded", () => {
  scrollers();
  enlargeFigures();
  document.querySelectorAll(".filterable").forEach(addFilter);
  // docutils calls the sources a list, and none of them an item.
  document.querySelectorAll(".citation-list > *").forEach(source => source.setAttribute("role", "listitem"));
  openTarget();
  addEventListener("hashchange", openTarget);
});

// A table wider than the page can be focused, so that the arrow keys scroll it; the style sheet shades its edge.
function scrollers() {
  const mark = frame => {
    const wide = frame.scrollWidth > frame.clientWidth + 1;
    frame.classList.toggle("wide", wide);
    frame.classList.toggle("at-end", frame.scrollLeft + frame.clientWidth >= frame.scrollWidth - 1);
    if (wide) frame.tabIndex = 0;
    else frame.removeAttribute("tabindex");
  };
  const watched = new ResizeObserver(entries => entries.forEach(entry => mark(entry.target)));
  document.querySelectorAll(".table-scroll, .bd-article div.math, .cell_input .highlight > pre").forEach(frame => {
    watched.observe(frame);
    frame.addEventListener("scroll", () => mark(frame), { passive: true });
  });
}

// A tap on a figure shows it as large as the window; Escape or another tap closes it.
function enlargeFigures() {
  const dialog = document.createElement("dialog");
  dialog.className = "enlarged";
  dialog.addEventListener("click", () => dialog.close());
  document.body.append(dialog);
  document.querySelectorAll(".bd-article .cell_output img").forEach(image => {
    const button = document.createElement("button");
    button.className = "enlarge";
    button.type = "button";
    button.setAttribute("aria-label", "Enlarge: " + image.alt);
    image.replaceWith(button);
    button.append(image);
    button.addEventListener("click", () => {
      dialog.replaceChildren(image.cloneNode());
      dialog.showModal();
    });
  });
}

// Buttons for each verdict and for headline claims; the numbers say how many rows each would show.
function addFilter(frame) {
  const rows = [...frame.querySelectorAll("tbody")];
  const verdict = row => row.querySelector(".verdict").textContent;
  const groups = new Map([["all", () => true], ["headline", row => row.querySelector(".headline") !== null]]);
  for (const word of new Set(rows.map(verdict))) groups.set(word, row => verdict(row) === word);
  const bar = document.createElement("div");
  bar.className = "filter";
  bar.setAttribute("role", "group");
  bar.setAttribute("aria-label", "Show claims");
  for (const [name, shown] of groups) {
    const button = document.createElement("button");
    button.type = "button";
    button.textContent = `${name} (${rows.filter(shown).length})`;
    button.setAttribute("aria-pressed", name === "all");
    button.addEventListener("click", () => {
      for (const row of rows) row.hidden = !shown(row);
      for (const other of bar.children) other.setAttribute("aria-pressed", other === button);
    });
    bar.append(button);
  }
  frame.prepend(bar);
}

// A link to a row that is folded away opens what folds it.
function openTarget() {
  const target = location.hash && document.getElementById(decodeURIComponent(location.hash.slice(1)));
  const fold = target && target.closest("details");
  if (!fold || fold.open) return;
  fold.open = true;
  target.scrollIntoView();
}
