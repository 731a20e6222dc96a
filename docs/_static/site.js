// A line does not end between a formula and the punctuation after it.
for (const formula of document.querySelectorAll("article math:not([display=block])")) {
  const next = formula.nextSibling;
  const mark = next && next.nodeType === Node.TEXT_NODE && next.data.match(/^[,.;:)]+/);
  if (!mark) continue;
  const together = document.createElement("span");
  together.style.whiteSpace = "nowrap";
  formula.replaceWith(together);
  together.append(formula, mark[0]);
  next.data = next.data.slice(mark[0].length);
}

// Long names in tables may break after their parts, so that columns fit the page.
for (const code of document.querySelectorAll("td code")) {
  const walker = document.createTreeWalker(code, NodeFilter.SHOW_TEXT);
  const texts = [];
  while (walker.nextNode()) texts.push(walker.currentNode);
  for (const text of texts) {
    const parts = text.data.split(/(?<=[._/=:,])(?=\w)/);
    text.replaceWith(...parts.flatMap((part, k) => (k ? [document.createElement("wbr"), part] : [part])));
  }
}

// A button on every block of code copies it, where the browser lets a page write to the clipboard.
if (navigator.clipboard) {
  for (const block of document.querySelectorAll("div.highlight")) {
    const button = document.createElement("button");
    button.type = "button";
    button.className = "copy";
    button.textContent = "copy";
    button.addEventListener("click", async () => {
      await navigator.clipboard.writeText(block.querySelector("pre").textContent.trimEnd() + "\n");
      button.textContent = "copied";
      setTimeout(() => { button.textContent = "copy"; }, 2000);
    });
    block.append(button);
  }
}
