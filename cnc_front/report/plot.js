"use strict";
/* Canvases that redraw themselves, and charts of minimum and maximum bands over x. */
const data = JSON.parse(document.getElementById("data").textContent);
const words = data.words;
const colour = (name) => getComputedStyle(document.documentElement).getPropertyValue("--" + name).trim();
const grade = (um) => um === null ? "todo" : um <= data.toleranceUm / 2 ? "good" : um <= data.toleranceUm ? "warn" : "bad";
const short = (v) => Math.abs(v) >= 1e6 || (v !== 0 && Math.abs(v) < 1e-3) ? v.toExponential(1) : String(+v.toPrecision(6));
const surfaces = [];

/* A canvas in device pixels; it redraws when its size or the colours change. */
function surface(canvas, draw) {
  const context = canvas.getContext("2d");
  const redraw = () => {
    const ratio = window.devicePixelRatio || 1, width = canvas.clientWidth, height = canvas.clientHeight;
    canvas.width = width * ratio; canvas.height = height * ratio;
    context.setTransform(ratio, 0, 0, ratio, 0, 0);
    context.font = "12px system-ui, sans-serif";
    draw(context, width, height);
  };
  new ResizeObserver(redraw).observe(canvas);
  surfaces.push(redraw);
  return redraw;
}
const redrawAll = () => surfaces.forEach((redraw) => redraw());
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", redrawAll);
/* Paper is white, whatever the screen is. */
for (const [event, on] of [["beforeprint", true], ["afterprint", false]])
  window.addEventListener(event, () => { document.documentElement.classList.toggle("paper", on); redrawAll(); });

function ticks(low, high, count) {
  const raw = (high - low) / Math.max(1, count), power = Math.pow(10, Math.floor(Math.log10(raw)));
  const step = [1, 2, 5, 10].map((m) => m * power).find((s) => s >= raw) || raw, list = [];
  for (let v = Math.ceil(low / step) * step; v <= high + step * 1e-9 && list.length < 100; v += step) list.push(Math.abs(v) < step / 1e6 ? 0 : v);
  return list;
}

function line(c, x0, y0, x1, y1) { c.beginPath(); c.moveTo(x0, y0); c.lineTo(x1, y1); c.stroke(); }
function put(c, text, x, y, align, base) { c.textAlign = align; c.textBaseline = base; c.fillText(text, x, y); }

/* Lowest and highest value of the curves between two shares of their length, with zero, limits nearby and some air. */
function span(curves, limits, from, to, cap) {
  let low = 0, high = 0;
  for (const { band } of curves) {
    const n = band[1].length;
    for (let i = Math.floor(from * n); i < Math.min(n, Math.ceil(to * n)); i++) {
      if (band[1][i] === null) continue;
      low = Math.min(low, band[0][i]); high = Math.max(high, band[1][i]);
    }
  }
  if (cap) high = Math.min(high, cap);
  for (const { value } of limits) if (value <= high * 3) high = Math.max(high, value);
  if (high === low) high = low + 1;
  const air = (high - low) * 0.06;
  return [low < 0 ? low - air : low, high + air];
}

function frame(c, box, [low, high], [x0, x1], { xLabel, yLabel }, width) {
  const x = (v) => box.left + (box.right - box.left) * (v - x0) / (x1 - x0), y = (v) => box.bottom - (box.bottom - box.top) * (v - low) / (high - low);
  c.strokeStyle = colour("rule"); c.fillStyle = colour("soft"); c.lineWidth = 1;
  for (const v of ticks(low, high, Math.max(4, (box.bottom - box.top) / 34))) { line(c, box.left, y(v), box.right, y(v)); put(c, short(v), box.left - 6, y(v), "right", "middle"); }
  const unit = xLabel ? c.measureText(xLabel).width + 24 : 0;
  for (const v of ticks(x0, x1, width / 110)) if (x(v) < box.right - unit || !xLabel) put(c, short(v), x(v), box.bottom + 5, "center", "top");
  if (xLabel) put(c, xLabel, box.right, box.bottom + 5, "right", "top");
  put(c, yLabel, box.left, 3, "left", "top");
  return { x, y };
}

function drawLimits(c, box, y, limits, [, high]) {
  for (const { value, text } of limits) {
    const inside = value <= high;
    c.fillStyle = colour(inside ? "bad" : "soft"); c.strokeStyle = colour("bad"); c.lineWidth = 1;
    if (inside) { c.setLineDash([6, 4]); line(c, box.left, y(value), box.right, y(value)); c.setLineDash([]); put(c, text, box.left + 6, y(value) - 2, "left", "bottom"); }
    else if (box.right - box.left > 420) put(c, text + " ↑", box.left + c.measureText("mm/min").width + 20, 3, "left", "top");
  }
}

function drawBand(c, x, y, band, step, from, to) {
  const n = band[1].length;
  c.beginPath();
  for (let i = Math.max(0, Math.floor(from * n) - 1); i < Math.min(n, Math.ceil(to * n) + 1); i++) {
    if (band[1][i] === null) continue;
    const px = x((i + 0.5) * step);
    c.moveTo(px, y(band[0][i]) + 0.5); c.lineTo(px, y(band[1][i]) - 0.5);
    if (i + 1 < n && band[1][i + 1] !== null) { c.moveTo(px, y(band[1][i])); c.lineTo(x((i + 1.5) * step), y(band[1][i + 1])); }
  }
  c.stroke();
}

/* A chart: `curves` are bands [minimum, maximum]; dragging zooms in x, double-click shows all. `onPoint` gets x or null. */
function chart(canvas, { step, curves, limits = [], xLabel, yLabel, cap = () => 0, onPoint = () => {} }) {
  const full = Math.max(1, ...curves.map((k) => k.band[1].length)) * step;
  let range = [0, full], pointer = null, dragged = null, mark = null, box = null;
  const at = (px) => range[0] + (range[1] - range[0]) * Math.min(1, Math.max(0, (px - box.left) / (box.right - box.left)));
  const redraw = surface(canvas, (c, width, height) => {
    box = { left: 62, right: width - 10, top: 22, bottom: height - (xLabel ? 24 : 22) };
    const shares = range.map((v) => v / full), high = span(curves, limits, ...shares, cap());
    c.clearRect(0, 0, width, height);
    const { x, y } = frame(c, box, high, range, { xLabel, yLabel }, width);
    c.save(); c.beginPath(); c.rect(box.left, box.top - 1, box.right - box.left, box.bottom - box.top + 2); c.clip();
    for (const k of curves) { c.strokeStyle = colour(k.colour); c.lineWidth = 1.2; drawBand(c, x, y, k.band, full / k.band[1].length, ...shares); }
    c.restore();
    drawLimits(c, box, y, limits, high);
    let right = box.right;
    for (const k of [...curves].reverse()) if (k.text) { c.fillStyle = colour(k.colour); put(c, "— " + k.text, right, 3, "right", "top"); right -= c.measureText("— " + k.text).width + 18; }
    if (mark !== null && mark >= range[0] && mark <= range[1]) { c.strokeStyle = colour("fg"); line(c, x(mark), box.top, x(mark), box.bottom); }
    if (dragged !== null && pointer !== null) { c.fillStyle = colour("todo"); c.globalAlpha = 0.3; c.fillRect(dragged, box.top, pointer - dragged, box.bottom - box.top); c.globalAlpha = 1; }
    if (pointer !== null) readout(c, width);
  });
  const readout = (c, width) => {
    const v = at(pointer), px = Math.min(box.right, Math.max(box.left, pointer));
    c.strokeStyle = colour("soft"); c.lineWidth = 1; line(c, px, box.top, px, box.bottom);
    const texts = curves.map(({ band, text }) => {
      const i = Math.min(band[1].length - 1, Math.floor(v / full * band[1].length)), [a, b] = [band[0][i], band[1][i]];
      return text + " " + (b === null || b === undefined ? "-" : Math.abs(b) >= Math.abs(a) ? short(+b.toPrecision(4)) : short(+a.toPrecision(4)));
    });
    const label = short(+v.toPrecision(5)) + ":  " + texts.join("   "), w = c.measureText(label).width, left = px > width / 2 ? px - 8 - w : px + 8;
    c.fillStyle = colour("bg"); c.fillRect(left - 4, box.top + 1, w + 8, 18); c.fillStyle = colour("fg"); put(c, label, left, box.top + 4, "left", "top");
  };
  canvas.addEventListener("pointerdown", (e) => { dragged = e.offsetX; });
  canvas.addEventListener("pointermove", (e) => { pointer = e.offsetX; redraw(); onPoint(at(pointer)); });
  canvas.addEventListener("pointerup", (e) => {
    if (dragged !== null && Math.abs(e.offsetX - dragged) > 8) range = [at(Math.min(dragged, e.offsetX)), at(Math.max(dragged, e.offsetX))];
    dragged = null; redraw();
  });
  canvas.addEventListener("pointerleave", () => { pointer = dragged = null; redraw(); onPoint(null); });
  canvas.addEventListener("dblclick", () => { range = [0, full]; redraw(); });
  return { redraw, mark: (v) => { mark = v; redraw(); } };
}

/* Shares of samples per class of deviation, and the share up to it. */
function histogram(canvas, { upTo, counts }) {
  surface(canvas, (c, width, height) => {
    const total = counts.reduce((a, b) => a + b, 0) || 1, w = (width - 24) / counts.length, room = height - 62;
    let sum = 0;
    c.clearRect(0, 0, width, height);
    counts.forEach((count, i) => {
      const h = count ? Math.max(2, room * count / total) : 0, x = 12 + i * w, base = height - 40;
      sum += count;
      c.fillStyle = colour(grade(upTo[i] === null ? Infinity : upTo[i])); c.fillRect(x + 2, base - h, w - 4, h);
      c.fillStyle = colour("soft"); if (w > 32 || i % 3 === 0) put(c, upTo[i] === null ? ">500" : "≤" + upTo[i], x + w / 2, base + 5, "center", "top");
      if (w > 32 && (count || (i && sum < total))) put(c, sum === total ? "100" : (Math.floor(1000 * sum / total) / 10).toFixed(1), x + w / 2, base + 21, "center", "top");
      if (count && w > 32) { c.fillStyle = colour("fg"); put(c, (100 * count / total).toPrecision(2), x + w / 2, base - h - 3, "center", "bottom"); }
    });
    c.fillStyle = colour("soft"); put(c, words.histogram_help, width - 12, 4, "right", "top");
  });
}
