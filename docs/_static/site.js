// Opened as a file, a page may not read the others, which excerpts in search results would need.
if (window.location.protocol === "file:" && typeof DOCUMENTATION_OPTIONS !== "undefined") {
  DOCUMENTATION_OPTIONS.SHOW_SEARCH_SUMMARY = false;
}

// The theme's arrows that unfold a part of the tree have no name for those who cannot see them.
document.addEventListener("DOMContentLoaded", () => {
  for (const summary of document.querySelectorAll(".toctree-toggle")) {
    summary.parentElement.setAttribute("aria-label", "Pages below this one");
  }
});

// A formula that is wider than its column scrolls, also by the keyboard.
window.addEventListener("load", () => {
  window.MathJax?.startup?.promise?.then(() => {
    for (const formula of document.querySelectorAll("mjx-container[display]")) {
      if (formula.scrollWidth > formula.clientWidth) formula.tabIndex = 0;
    }
  });
});
