// Order of search results: pages of text, then tables of reference, then classes and attributes.
var Scorer = {
  score: ([docname, title, anchor, description, score]) => {
    if (/^reference\/(api|bases)$/.test(docname)) return score;
    return score + (/^reference\/(constants|changelog|contributing)$/.test(docname) ? 100 : 200);
  },
  objNameMatch: 11,
  objPartialMatch: 6,
  objPrio: { 0: 15, 1: 5, 2: -5 },
  objPrioDefault: 0,
  title: 15,
  partialTitle: 7,
  term: 5,
  partialTerm: 2,
};
