// Timeline: a row for each worker, a colour for what it does. No library.
"use strict";
(() => {
  const $ = id => document.getElementById(id);
  const { kinds, end, rows } = JSON.parse($("times-data").textContent);
  const COLOURS = { walk: "#9ecae1", expand: "#4292c6", fill: "#2a6f3c", setback: "#d62728",
    wait: "#fdae6b", poll: "#bcbddc", balance: "#8c6d31", idle: "#e4e4e4" };
  const canvas = $("times"), row = Math.max(3, Math.min(22, Math.floor(640 / rows.length)));
  const LEFT = 60, BELOW = 22, bins = rows[0].length;
  const seconds = ns => ns >= 1e9 ? `${+(ns / 1e9).toPrecision(4)} s`
    : ns >= 1e6 ? `${+(ns / 1e6).toPrecision(4)} ms` : `${+(ns / 1e3).toPrecision(4)} µs`;
  const shown = () => {
    const [a, b] = [Number($("from").value), Number($("to").value)];
    return [Math.min(a, b), Math.max(a, b, Math.min(a, b) + 0.002)];
  };
  const draw = () => {
    const scale = window.devicePixelRatio || 1, wide = canvas.clientWidth;
    const high = rows.length * row + BELOW;
    canvas.style.height = `${high}px`;
    canvas.width = Math.round(wide * scale);
    canvas.height = Math.round(high * scale);
    const pen = canvas.getContext("2d");
    pen.scale(scale, scale);
    pen.font = "12px sans-serif";
    pen.textBaseline = "middle";
    const [from, to] = shown();
    const x = bin => LEFT + (bin / bins - from) / (to - from) * (wide - LEFT);
    rows.forEach((line, w) => {
      for (let bin = 0; bin < bins;) {
        let last = bin + 1;
        while (last < bins && line[last] === line[bin]) last++;
        const a = Math.max(LEFT, x(bin)), b = Math.min(wide, x(last));
        if (b > a && line[bin] !== " ") {
          pen.fillStyle = COLOURS[kinds[line.charCodeAt(bin) - 97]] ?? "#000";
          pen.fillRect(a, w * row, b - a, row > 6 ? row - 1 : row);
        }
        bin = last;
      }
      pen.fillStyle = "#333";
      if (row >= 12 || w % 8 === 0) pen.fillText(`worker ${w}`, 0, w * row + row / 2);
    });
    for (let k = 0; k <= 4; k++) {
      const at = LEFT + k / 4 * (wide - LEFT);
      pen.textAlign = k === 4 ? "right" : k === 0 ? "left" : "center";
      pen.fillText(seconds((from + k / 4 * (to - from)) * end), at, high - BELOW / 2);
    }
    pen.textAlign = "left";
    document.body.dataset.times = rows.length;
  };
  canvas.addEventListener("pointermove", event => {
    const box = canvas.getBoundingClientRect(), [from, to] = shown();
    const part = from + (event.clientX - box.left - LEFT) / (box.width - LEFT) * (to - from);
    const w = Math.floor((event.clientY - box.top) / row), bin = Math.floor(part * bins);
    const kind = kinds[rows[w]?.charCodeAt(bin) - 97];
    $("moment").textContent = part < from || w >= rows.length ? ""
      : `worker ${w} at ${seconds(part * end)}: ${kind ?? "nothing recorded"}`;
  });
  $("kinds").replaceChildren(...kinds.map(kind => {
    const entry = document.createElement("span"), box = document.createElement("i");
    box.style.background = COLOURS[kind];
    entry.append(box, kind);
    return entry;
  }));
  $("moment").textContent = "Point at a row to read it.";
  for (const id of ["from", "to"]) $(id).addEventListener("input", draw);
  window.addEventListener("resize", draw);
  draw();
})();
