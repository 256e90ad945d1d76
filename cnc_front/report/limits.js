/* What limited the path velocity: colours, a legend, and shares over time as stacked columns. */
const hues = { feed: "good", rapid: "rapid", mdvel: "bad", arc_maxacc: "arc", maxvel: "axis", maxacc: "axis", ramp: "warn", short_block: "short", starved: "starved", lookahead_depth: "starved", override: "override", hold: "hold", stop: "stop", end_of_spool: "stop" };
const hueOf = (name) => colour(hues[name.split(" ")[0]] || "todo");
const limitText = (name) => data.limitWords[name] || name;

function limitLegend(element) {
  const seen = new Set();
  for (const name of data.limits.names) {
    const span = document.createElement("span"), bar = document.createElement("i"), cause = name.split(" ")[0];
    if (seen.has(cause)) continue;
    seen.add(cause);
    bar.style.background = `var(--${hues[cause] || "todo"})`; span.append(bar, limitText(name).split(", ")[0]); element.append(span, " ");
  }
}

/* Dragging zooms in, double-click shows all, the pointer names the causes of the moment. */
function limitStrip(canvas) {
  const { names, step, counts } = data.limits, n = counts.length ? counts[0].length : 0, full = Math.max(step, n * step);
  let range = [0, full], pointer = null, dragged = null, box = null;
  const at = (px) => range[0] + (range[1] - range[0]) * Math.min(1, Math.max(0, (px - box.left) / (box.right - box.left)));
  const between = (from, to) => {
    const a = Math.max(0, Math.min(n - 1, Math.floor(from / step))), b = Math.max(a + 1, Math.min(n, Math.ceil(to / step)));
    return counts.map((row) => { let sum = 0; for (let i = a; i < b; i++) sum += row[i]; return sum; });
  };
  const redraw = surface(canvas, (c, width, height) => {
    box = { left: 62, right: width - 10, top: 8, bottom: height - 24 };
    c.clearRect(0, 0, width, height);
    if (!n) return;
    for (let px = box.left; px < box.right; px++) {
      const shares = between(at(px), at(px + 1)), total = shares.reduce((a, b) => a + b, 0) || 1;
      let y = box.bottom;
      shares.forEach((share, k) => { const h = (box.bottom - box.top) * share / total; if (h > 0) { c.fillStyle = hueOf(names[k]); c.fillRect(px, y - h, 1.2, h); } y -= h; });
    }
    c.fillStyle = colour("soft");
    const room = c.measureText(words.machine_time).width + 24, px = (v) => box.left + (box.right - box.left) * (v - range[0]) / (range[1] - range[0]);
    for (const v of ticks(range[0], range[1], width / 110)) if (px(v) < box.right - room) put(c, short(v), box.left + (box.right - box.left) * (v - range[0]) / (range[1] - range[0]), box.bottom + 5, "center", "top");
    put(c, words.machine_time, box.right, box.bottom + 5, "right", "top");
    if (dragged !== null && pointer !== null) { c.fillStyle = colour("bg"); c.globalAlpha = 0.5; c.fillRect(dragged, box.top, pointer - dragged, box.bottom - box.top); c.globalAlpha = 1; }
    if (pointer !== null) readout(c, width);
  });
  const readout = (c, width) => {
    const shares = between(at(pointer), at(pointer + 1)), total = shares.reduce((a, b) => a + b, 0) || 1;
    const texts = shares.map((share, k) => [share, k]).filter(([share]) => share).sort((a, b) => b[0] - a[0]).slice(0, 3);
    const label = short(+at(pointer).toPrecision(5)) + ":  " + texts.map(([share, k]) => limitText(names[k]) + (share < total ? " " + (100 * share / total).toFixed(0) + " %" : "")).join("   ");
    const w = c.measureText(label).width, left = pointer > width / 2 ? pointer - 8 - w : pointer + 8;
    c.strokeStyle = colour("fg"); c.lineWidth = 1; line(c, pointer, box.top, pointer, box.bottom);
    c.fillStyle = colour("bg"); c.fillRect(left - 4, box.top + 1, w + 8, 18); c.fillStyle = colour("fg"); put(c, label, left, box.top + 4, "left", "top");
  };
  canvas.addEventListener("pointerdown", (e) => { dragged = e.offsetX; });
  canvas.addEventListener("pointermove", (e) => { pointer = Math.max(62, e.offsetX); redraw(); });
  canvas.addEventListener("pointerup", (e) => {
    if (dragged !== null && Math.abs(e.offsetX - dragged) > 8) range = [at(Math.min(dragged, e.offsetX)), at(Math.max(dragged, e.offsetX))];
    dragged = null; redraw();
  });
  canvas.addEventListener("pointerleave", () => { pointer = dragged = null; redraw(); });
  canvas.addEventListener("dblclick", () => { range = [0, full]; redraw(); });
}
