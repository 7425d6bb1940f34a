// Tables as they are written: sorted by the size of their numbers, copied as a spreadsheet takes them.

"use strict";
window.wheelhop = window.wheelhop || {};

// The number a text begins with, as the page writes it: 10 473 ± 12, −3.1, < 10⁻⁶; NaN of words.
wheelhop.sizeOf = (text) => {
  const plain = String(text).replace(/[\u202f\u00a0 ](?=\d)/g, "").replace(/\u2212/g, "-");
  if (plain.startsWith("<10⁻⁶") || plain.startsWith("< 10⁻⁶")) return 0;
  return parseFloat(plain);
};

wheelhop.order = (a, b) => {
  const [one, other] = [wheelhop.sizeOf(a), wheelhop.sizeOf(b)];
  if (isNaN(one) && isNaN(other)) return String(a).localeCompare(String(b));
  if (isNaN(one) || isNaN(other)) return isNaN(one) ? 1 : -1;
  return one - other;
};

// The table in an element as it is on the screen, tabs between its cells, to the clipboard.
wheelhop.copyTable = async (element) => {
  const rows = [...element.querySelectorAll("tr")].map((row) =>
    [...row.querySelectorAll("th, td")]
      .map((cell) => cell.textContent.replace(/[\u202f\u00a0]/g, "").replace(/\u2212/g, "-")
        .replace(/arrow_upward|arrow_downward/g, "").trim()).join("\t"));
  const text = rows.join("\n");
  if (navigator.clipboard) {
    await navigator.clipboard.writeText(text);
    return text;
  }
  const area = document.createElement("textarea");  // of a page that came over a network
  area.value = text;
  document.body.append(area);
  area.select();
  document.execCommand("copy");
  area.remove();
  return text;
};
