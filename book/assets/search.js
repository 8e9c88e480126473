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
