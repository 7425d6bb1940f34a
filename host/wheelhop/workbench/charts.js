// What a chart says where it is pointed at, what its cursors are dragged to, and the page's address.

"use strict";
window.wheelhop = window.wheelhop || {};

// The x value once, then every panel's curves; `panels` are title, unit of x and unit of y of each.
wheelhop.tooltip = (values, panels) => {
  const few = (number) => Number(number).toPrecision(4).replace(/(\.\d*?)0+$/, "$1").replace(/\.$/, "");
  const safe = (text) => String(text).replace(/[&<>"]/g, (sign) => `&#${sign.charCodeAt(0)};`);
  const shown = values.filter((one) => one.value[1] !== null && one.value[1] !== undefined);
  if (!shown.length) return "";
  const lines = [`${few(shown[0].value[0])} ${panels[shown[0].axisIndex][1]}`];
  let last = -1;
  for (const one of shown) {
    const [title, , unit] = panels[one.axisIndex];
    if (one.axisIndex !== last && title && panels.length > 1) lines.push(`<strong>${safe(title)}</strong>`);
    last = one.axisIndex;
    lines.push(`${one.marker}${safe(one.seriesName)} <strong>${few(one.value[1])}</strong> ${safe(unit)}`);
  }
  return lines.join("<br>");
};

// A cell of a spectrogram: when, at which frequency, how strong.
wheelhop.cell = (one, axes) => {
  const [time, frequency, level] = one.value;
  const [times, frequencies] = axes[one.seriesIndex];
  return `${times[time]} s, ${frequencies[frequency]} Hz<br><strong>${level} dB</strong>`;
};

// While the cursors are set, a drag across the chart sets them instead of moving it.
wheelhop.setCursors = (id, on) => {
  const brushOption = { brushType: on ? "lineX" : false, brushMode: "single" };
  getElement(id)?.chart?.dispatchAction({ type: "takeGlobalCursor", key: "brush", brushOption });
};

// From when to when was dragged, if it was; the cursors drawn take the place of the brush.
wheelhop.dragged = (id, event) => {
  const range = event.areas && event.areas.length && event.areas[0].coordRange;
  if (!range) return null;
  getElement(id).chart.dispatchAction({ type: "brush", areas: [] });
  return [Math.min(...range), Math.max(...range)];
};

// The page's address tells what is looked at; a step is one that Back goes back over.
wheelhop.place = (place, step) => {
  if (location.hash === `#${place}`) return;
  history[step ? "pushState" : "replaceState"](null, "", `#${place}`);
};

// The page of another campaign begins where every campaign does.
wheelhop.anew = () => {
  history.replaceState(null, "", location.pathname + location.search);
  location.reload();
};

addEventListener("popstate", () => emitEvent("place", location.hash.slice(1)));
