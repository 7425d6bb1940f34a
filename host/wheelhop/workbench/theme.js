// Light, dark, or as the system has it; this browser keeps what was chosen.

"use strict";
window.wheelhop = window.wheelhop || {};

wheelhop.theme = (chosen) => {
  localStorage.setItem("wheelhop-theme", chosen);
  wheelhop.showTheme();
};

wheelhop.showTheme = () => {
  const chosen = localStorage.getItem("wheelhop-theme") || "auto";
  if (chosen === "auto") delete document.documentElement.dataset.theme;
  else document.documentElement.dataset.theme = chosen;
  window.Quasar?.Dark.set(chosen === "auto" ? "auto" : chosen === "dark");
};

wheelhop.showTheme();
addEventListener("load", wheelhop.showTheme);
