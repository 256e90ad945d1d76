"use strict";
const data = JSON.parse(document.getElementById("data").textContent);
const words = data.words;
const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue("--" + name).trim();
const grade = (um) => um === null ? "todo" : um <= data.toleranceUm / 2 ? "good" : um <= data.toleranceUm ? "warn" : "bad";

/* A canvas that keeps its size in device pixels and redraws when it changes. */
function surface(id, draw) {
  const canvas = document.getElementById(id), context = canvas.getContext("2d");
  const redraw = () => {
    const ratio = window.devicePixelRatio || 1, width = canvas.clientWidth, height = canvas.clientHeight;
    canvas.width = width * ratio; canvas.height = height * ratio;
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.clearRect(0, 0, width, height);
    context.font = "12px system-ui, sans-serif";
    draw(context, width, height);
  };
  new ResizeObserver(redraw).observe(canvas);
  matchMedia("(prefers-color-scheme: dark)").addEventListener("change", redraw);
  return { canvas, redraw };
}

function ticks(low, high, count) {
  const raw = (high - low) / Math.max(1, count), power = Math.pow(10, Math.floor(Math.log10(raw)));
  const step = [1, 2, 5, 10].map((m) => m * power).find((s) => s >= raw) || raw, list = [];
  for (let v = Math.ceil(low / step) * step; v <= high + step * 1e-9; v += step) list.push(Math.abs(v) < step / 1e6 ? 0 : v);
  return list;
}
const short = (v) => Math.abs(v) >= 1e5 || (v !== 0 && Math.abs(v) < 1e-3) ? v.toExponential(1) : String(+v.toPrecision(6));

/* Bands of minimum and maximum over x, with dashed limits and a value under the pointer. */
function chart(id, { step, curves, limits = [], xLabel, yLabel }) {
  let pointer = null;
  const { canvas, redraw } = surface(id, (c, width, height) => {
    const box = { left: 62, right: width - 12, top: 12, bottom: height - 30 };
    const n = Math.max(1, ...curves.map((k) => k.band[1].length));
    let low = 0, high = 0;
    for (const k of curves) for (const side of k.band) for (const v of side) if (v !== null) { low = Math.min(low, v); high = Math.max(high, v); }
    for (const l of limits) if (l.value <= high * 3 && l.value >= low * 3) { low = Math.min(low, l.value); high = Math.max(high, l.value); }
    if (high === low) high = low + 1;
    const pad = (high - low) * 0.06; high += pad; if (low < 0) low -= pad;
    const x = (i) => box.left + (box.right - box.left) * i / n, y = (v) => box.bottom - (box.bottom - box.top) * (v - low) / (high - low);
    c.strokeStyle = colour("rule"); c.fillStyle = colour("soft"); c.lineWidth = 1; c.textAlign = "right"; c.textBaseline = "middle";
    for (const v of ticks(low, high, 5)) { c.beginPath(); c.moveTo(box.left, y(v)); c.lineTo(box.right, y(v)); c.stroke(); c.fillText(short(v), box.left - 6, y(v)); }
    c.textAlign = "center"; c.textBaseline = "top";
    for (const v of ticks(0, n * step, width / 110)) c.fillText(short(v), x(v / step), box.bottom + 4);
    c.textAlign = "right"; c.fillText(xLabel, box.right, box.bottom + 17); c.textAlign = "left"; c.fillText(yLabel, box.left + 4, 0);
    for (const l of limits) {
      if (l.value > high || l.value < low) continue;
      c.strokeStyle = colour("bad"); c.setLineDash([6, 4]); c.beginPath(); c.moveTo(box.left, y(l.value)); c.lineTo(box.right, y(l.value)); c.stroke(); c.setLineDash([]);
      c.fillStyle = colour("bad"); c.textAlign = "right"; c.textBaseline = "bottom"; c.fillText(l.text, box.right, y(l.value) - 2);
    }
    curves.forEach((k, index) => {
      c.strokeStyle = c.fillStyle = colour(k.colour); c.lineWidth = 1.2;
      const m = k.band[1].length;
      c.beginPath();
      for (let i = 0; i < m; i++) if (k.band[1][i] !== null) {
        const px = x((i + 0.5) * n / m); c.moveTo(px, y(k.band[0][i]) + 0.5); c.lineTo(px, y(k.band[1][i]) - 0.5);
        if (i + 1 < m && k.band[1][i + 1] !== null) { c.moveTo(px, y(k.band[1][i])); c.lineTo(x((i + 1.5) * n / m), y(k.band[1][i + 1])); }
      }
      c.stroke();
      c.textAlign = "right"; c.textBaseline = "top"; c.fillText(k.text, box.right - index * 110, 0);
    });
    if (pointer !== null && pointer >= box.left && pointer <= box.right) {
      const at = (pointer - box.left) / (box.right - box.left);
      c.strokeStyle = colour("soft"); c.beginPath(); c.moveTo(pointer, box.top); c.lineTo(pointer, box.bottom); c.stroke();
      const values = curves.map((k) => { const v = k.band[1][Math.min(k.band[1].length - 1, Math.floor(at * k.band[1].length))]; return k.text + " " + (v === null || v === undefined ? "-" : short(+v.toPrecision(4))); });
      const label = short(+(at * n * step).toPrecision(5)) + ":  " + values.join("   ");
      c.textAlign = pointer > width / 2 ? "right" : "left"; c.textBaseline = "top";
      const w = c.measureText(label).width, left = pointer > width / 2 ? pointer - 8 - w : pointer + 8;
      c.fillStyle = colour("bg"); c.fillRect(left - 4, box.top + 2, w + 8, 18); c.fillStyle = colour("fg"); c.textAlign = "left"; c.fillText(label, left, box.top + 5);
    }
  });
  canvas.addEventListener("pointermove", (e) => { pointer = e.offsetX; redraw(); });
  canvas.addEventListener("pointerleave", () => { pointer = null; redraw(); });
}

/* The path in two axes, coloured by deviation. */
function pathView() {
  const { points, lines, rapid, um } = data.path, n = lines.length, hover = document.getElementById("path-hover"), help = hover.textContent;
  const magnify = document.getElementById("magnify"), pairs = [];
  for (let a = 0; a < Math.min(3, points.length); a++) for (let b = a + 1; b < Math.min(3, points.length); b++) pairs.push([a, b]);
  let view = pairs[0] || [0, 0], scale = null, centre = null, found = -1, touched = false;
  const fit = (width, height) => {
    const range = view.map((a) => points[a].reduce(([l, h], v) => [Math.min(l, v), Math.max(h, v)], [Infinity, -Infinity]));
    centre = range.map(([l, h]) => (l + h) / 2);
    scale = 0.92 * Math.min(width / Math.max(1e-6, range[0][1] - range[0][0]), height / Math.max(1e-6, range[1][1] - range[1][0]));
  };
  const screen = (i, width, height) => [width / 2 + (points[view[0]][i] - centre[0]) * scale, height / 2 - (points[view[1]][i] - centre[1]) * scale];
  const { canvas, redraw } = surface("path", (c, width, height) => {
    if (scale === null || !touched) fit(width, height);
    const factor = +magnify.value;
    for (const name of ["todo", "good", "warn", "bad"]) {
      c.strokeStyle = colour(name); c.lineWidth = name === "bad" ? 2.4 : 1.3; c.beginPath();
      for (let i = 1; i < n; i++) {
        if (grade(um[i]) !== name || (rapid[i] && name === "good")) continue;
        const [x0, y0] = screen(i - 1, width, height), [x1, y1] = screen(i, width, height);
        c.moveTo(x0, y0); c.lineTo(x1, y1);
        if (factor && um[i]) { const d = um[i] / 1000 * factor * scale, l = Math.hypot(x1 - x0, y1 - y0) || 1; c.moveTo(x1, y1); c.lineTo(x1 - (y1 - y0) / l * d, y1 + (x1 - x0) / l * d); }
      }
      c.stroke();
    }
    c.strokeStyle = colour("todo"); c.setLineDash([4, 5]); c.lineWidth = 1; c.beginPath();
    for (let i = 1; i < n; i++) if (rapid[i] && grade(um[i]) === "good") { c.moveTo(...screen(i - 1, width, height)); c.lineTo(...screen(i, width, height)); }
    c.stroke(); c.setLineDash([]);
    const bar = [1, 2, 5].flatMap((m) => [-3, -2, -1, 0, 1, 2, 3].map((p) => m * 10 ** p)).filter((mm) => mm * scale < width / 4).reduce((a, b) => Math.max(a, b), 0.001);
    c.strokeStyle = c.fillStyle = colour("fg"); c.lineWidth = 2; c.beginPath(); c.moveTo(14, height - 14); c.lineTo(14 + bar * scale, height - 14); c.stroke();
    c.textAlign = "left"; c.textBaseline = "bottom"; c.fillText(bar + " " + (data.units[view[0]] || ""), 14, height - 18);
    c.textAlign = "right"; c.fillText(data.axes[view[0]] + " →", width - 8, height - 8); c.textBaseline = "top"; c.textAlign = "left"; c.fillText((data.axes[view[1]] || "") + " ↑", 8, 8);
    if (found > 0) { const [x, y] = screen(found, width, height); c.beginPath(); c.arc(x, y, 5, 0, 7); c.stroke(); }
  });
  const again = () => { touched = false; redraw(); };
  for (const pair of pairs) {
    const button = document.createElement("button");
    button.textContent = pair.map((a) => data.axes[a]).join(""); button.setAttribute("aria-pressed", pair === view);
    button.onclick = () => { view = pair; for (const other of button.parentNode.children) other.setAttribute("aria-pressed", other === button); again(); };
    document.getElementById("views").append(button);
  }
  magnify.onchange = redraw;
  canvas.addEventListener("dblclick", again);
  canvas.addEventListener("wheel", (e) => {
    e.preventDefault();
    touched = true;
    const zoom = Math.exp(-e.deltaY / 400), dx = (e.offsetX - canvas.clientWidth / 2) / scale, dy = -(e.offsetY - canvas.clientHeight / 2) / scale;
    centre = [centre[0] + dx * (1 - 1 / zoom), centre[1] + dy * (1 - 1 / zoom)]; scale *= zoom; redraw();
  }, { passive: false });
  canvas.addEventListener("pointermove", (e) => {
    if (e.buttons) { touched = true; centre = [centre[0] - e.movementX / scale, centre[1] + e.movementY / scale]; return redraw(); }
    let best = 12 ** 2, at = -1;
    for (let i = 1; i < n; i++) { const [x, y] = screen(i, canvas.clientWidth, canvas.clientHeight), d = (x - e.offsetX) ** 2 + (y - e.offsetY) ** 2; if (d < best) { best = d; at = i; } }
    if (at === found) return;
    found = at; redraw();
    hover.textContent = at < 0 ? help : words.line + " " + lines[at] + ":  " + data.axes.map((a, k) => a + " " + points[k][at].toFixed(4)).join("  ") + "   " + words.deviation + " " + (um[at] === null ? "-" : um[at].toFixed(2) + " µm");
  });
}

/* A table that sorts by a click on its head. */
function table(id, columns, rows, note) {
  const element = document.getElementById(id);
  let sorted = rows.slice(), key = null, down = true, needle = "";
  const draw = () => {
    const head = document.createElement("thead"), line = head.insertRow();
    for (const [name, label, kind] of columns) {
      const cell = document.createElement("th"); cell.textContent = label + (key === name ? (down ? " ▼" : " ▲") : ""); cell.className = kind || "";
      cell.onclick = () => { down = key === name ? !down : true; key = name; sorted.sort((a, b) => { const x = a[name], y = b[name]; const d = typeof x === "number" || typeof y === "number" ? (x ?? -Infinity) - (y ?? -Infinity) : String(x).localeCompare(String(y)); return down ? -d : d; }); draw(); };
      line.append(cell);
    }
    const body = document.createElement("tbody");
    for (const row of sorted) {
      if (needle && !columns.some(([name]) => String(row[name]).toLowerCase().includes(needle))) continue;
      const tr = body.insertRow(); if (row.max_um > data.toleranceUm) tr.className = "over";
      for (const [name, , kind] of columns) { const td = tr.insertCell(), v = row[name]; td.className = kind || ""; td.textContent = v === null || v === undefined ? "-" : typeof v === "number" ? +v.toPrecision(5) : v; }
      if (body.rows.length >= 1000) break;
    }
    element.replaceChildren(head, body);
  };
  draw();
  return (text) => { needle = text.toLowerCase(); draw(); };
}

pathView();
chart("length", { step: data.length.step, xLabel: words.path_mm, yLabel: "µm", limits: [{ value: data.toleranceUm, text: words.limit + " " + data.toleranceUm + " µm" }],
  curves: [{ band: data.length.actualUm, colour: "good", text: words.actual }, { band: data.length.setpointUm, colour: "set", text: words.set }] });
chart("speed", { step: data.time.step, xLabel: words.machine_time, yLabel: "mm/min",
  curves: [{ band: data.time.programmed, colour: "set", text: words.programmed }, { band: data.time.speed, colour: "good", text: words.reached }] });
const mpe = Math.min(...data.mpe.filter((v) => v > 0));
chart("following", { step: data.time.step, xLabel: words.machine_time, yLabel: data.units[0], limits: Number.isFinite(mpe) ? [{ value: mpe, text: "mpe" }] : [],
  curves: data.time.following.map((band, k) => ({ band, colour: ["good", "warn", "bad", "set", "todo"][k % 5], text: data.axes[k] })) });
chart("override", { step: data.time.step, xLabel: words.machine_time, yLabel: "%", curves: [{ band: data.time.factor, colour: "good", text: words.override.split(" ")[0] }] });
surface("histogram", (c, width, height) => {
  const { upTo, counts } = data.histogram, total = counts.reduce((a, b) => a + b, 0) || 1, w = (width - 24) / counts.length;
  counts.forEach((count, i) => {
    const h = (height - 46) * Math.sqrt(count / total), x = 12 + i * w;
    c.fillStyle = colour(grade(upTo[i] === null ? Infinity : upTo[i])); c.fillRect(x + 1, height - 24 - h, w - 2, h);
    c.fillStyle = colour("soft"); c.textAlign = "center"; c.textBaseline = "top"; if (w > 34 || i % 3 === 0) c.fillText(upTo[i] === null ? ">" : "≤" + upTo[i], x + w / 2, height - 20);
    if (count && w > 34) { c.textBaseline = "bottom"; c.fillText((100 * count / total).toPrecision(2) + "%", x + w / 2, height - 25 - h); }
  });
});
const filter = table("blocks", [["line", "N"], ["text", words.text, "text"], ["length_mm", words.length], ["time_s", words.block_time], ["programmed_mm_min", words.f_prog], ["mean_mm_min", words.f_mean], ["max_mm_min", words.f_max], ["max_um", words.max_um], ["rms_um", words.rms_um]], data.blocks);
document.getElementById("filter").addEventListener("input", (e) => filter(e.target.value));
if (data.blocks.length < data.blockCount) document.getElementById("block-note").textContent = words.worst_of.replace("{shown}", data.blocks.length).replace("{all}", data.blockCount);
table("events", [["t_s", "s"], ["line", "N"], ["kind", words.kind, "text"], ["axis", words.axis, "text"], ["name", words.name, "text"], ["text", "", "text"]], data.events);
