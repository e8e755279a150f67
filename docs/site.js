// API pages list their modules with one line each; what a module holds is folded and opens where a link leads into it.
"use strict";

const foldModules = () => {
  for (const children of document.querySelectorAll(".doc-module .doc-module > .doc-contents > .doc-children")) {
    const names = [...children.querySelectorAll(":scope > .doc-object > .doc-heading .doc-object-name")];
    if (!names.length || children.parentElement.matches("details")) continue;
    const folded = document.createElement("details"), summary = document.createElement("summary");
    folded.className = "module";
    summary.textContent = names.map((name) => name.textContent.trim()).join(", ");
    children.replaceWith(folded);
    folded.append(summary, children);
  }
};

const openTarget = () => {
  const target = document.getElementById(decodeURIComponent(location.hash.slice(1)));
  const own = target && target.parentElement.querySelector(":scope > .doc-contents > details.module");
  if (own) own.open = true;
  for (let above = target; above; above = above.parentElement) if (above.tagName === "DETAILS") above.open = true;
  if (target && target.closest(".doc-module")) target.scrollIntoView();
};

const setUp = () => {
  foldModules();
  openTarget();
  window.addEventListener("hashchange", openTarget);
  window.addEventListener("beforeprint", () => {
    for (const folded of document.querySelectorAll("details.module")) folded.open = true;
  });
};
if (document.readyState === "loading") document.addEventListener("DOMContentLoaded", setUp);
else setUp();
