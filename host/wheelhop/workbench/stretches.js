// Stretches on the level of a recording: their ends are dragged, or moved with the arrow keys.
// When one was moved, its element says so with an event "stretch": {piece, from_s, to_s}.
(() => {
  const STEP_S = 0.1;
  let held = null;

  const number = (element, name) => Number(element.dataset[name]);
  const move = (edge, time) => {
    const band = edge.closest("[data-piece]"), box = edge.closest(".stretches");
    const first = number(box, "from"), last = number(box, "to");
    let from = number(band, "from"), to = number(band, "to");
    if (edge.dataset.edge === "from") from = Math.min(Math.max(time, first), to - 1);
    else to = Math.max(Math.min(time, last), from + 1);
    Object.assign(band.dataset, { from, to });
    band.style.left = `${(100 * (from - first)) / (last - first)}%`;
    band.style.width = `${(100 * (to - from)) / (last - first)}%`;
    edge.setAttribute("aria-valuenow", (edge.dataset.edge === "from" ? from : to).toFixed(2));
  };
  const tell = (edge) => {
    const band = edge.closest("[data-piece]");
    const detail = { piece: band.dataset.piece };
    for (const name of ["from", "to"]) detail[`${name}_s`] = Number(number(band, name).toFixed(2));
    band.dispatchEvent(new CustomEvent("stretch", { bubbles: true, detail }));
  };

  document.addEventListener("pointerdown", (event) => {
    held = event.target.closest?.(".stretches [data-edge]") ?? null;
    if (held) held.focus();
    if (held) event.preventDefault();
  });
  document.addEventListener("pointermove", (event) => {
    if (!held) return;
    const box = held.closest(".stretches"), place = box.getBoundingClientRect();
    const first = number(box, "from"), last = number(box, "to");
    move(held, first + ((event.clientX - place.left) / place.width) * (last - first));
  });
  document.addEventListener("pointerup", () => {
    if (held) tell(held);
    held = null;
  });
  document.addEventListener("keydown", (event) => {
    const edge = event.target.closest?.(".stretches [data-edge]");
    const sign = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    if (!edge || !sign) return;
    event.preventDefault();
    const now = number(edge.closest("[data-piece]"), edge.dataset.edge);
    move(edge, now + sign * STEP_S * (event.shiftKey ? 10 : 1));
    tell(edge);
  });
})();
