/* The path in two axes, coloured by deviation; the deviation drawn beside it, magnified. */
function pathView(canvas, onPick) {
  const { points, lines, rapid, um, signedUm, gap } = data.path, n = lines.length;
  const hover = document.getElementById("path-hover"), help = hover.textContent + (data.path.gap.includes(1) ? " " + words.thinned : "");
  hover.textContent = help;
  const magnify = document.getElementById("magnify"), rapids = document.getElementById("rapids"), coloured = document.getElementById("coloured"), views = document.getElementById("views");
  const pairs = [];
  for (let a = 0; a < Math.min(3, points.length); a++) for (let b = a + 1; b < Math.min(3, points.length); b++) pairs.push([a, b]);
  let view = pairs[0] || [0, 0], scale = 1, centre = [0, 0], found = -1, moved = 0, own = false;  // own: the user chose the view

  const fit = (from, to) => {
    const range = view.map((a) => { let l = Infinity, h = -Infinity; for (let i = from; i < to; i++) { l = Math.min(l, points[a][i]); h = Math.max(h, points[a][i]); } return [l, h]; });
    centre = range.map(([l, h]) => (l + h) / 2);
    scale = 0.9 * Math.min(canvas.clientWidth / Math.max(1e-6, range[0][1] - range[0][0]), canvas.clientHeight / Math.max(1e-6, range[1][1] - range[1][0]));
  };
  const screen = (i) => [canvas.clientWidth / 2 + (points[view[0]][i] - centre[0]) * scale, canvas.clientHeight / 2 - (points[view[1]][i] - centre[1]) * scale];
  const shown = (i) => rapids.checked || !rapid[i];

  /* Pieces of one cause after the other, so that each colour is one stroke. */
  const strokeLimits = (c) => {
    const { names, vertices } = data.limits;
    for (let k = -1; k < names.length; k++) {
      c.strokeStyle = k < 0 ? colour("todo") : hueOf(names[k]); c.lineWidth = k < 0 || names[k] === "feed" ? 1.4 : 2.4;
      c.beginPath();
      for (let i = 1; i < n; i++) if (!gap[i] && shown(i) && vertices[i] === k) { c.moveTo(...screen(i - 1)); c.lineTo(...screen(i)); }
      c.stroke();
    }
  };
  const strokePath = (c) => {
    if (coloured.value === "limit") return strokeLimits(c);
    for (const name of ["todo", "good", "warn", "bad"]) {
      c.strokeStyle = colour(name); c.lineWidth = name === "bad" ? 2.6 : name === "warn" ? 2 : 1.4;
      for (const fast of [0, 1]) {
        c.setLineDash(fast ? [3, 5] : []);
        if (fast && name === "good") { c.strokeStyle = colour("todo"); c.lineWidth = 1; }
        c.beginPath();
        for (let i = 1; i < n; i++) if (!gap[i] && rapid[i] === fast && shown(i) && grade(um[i]) === name) { c.moveTo(...screen(i - 1)); c.lineTo(...screen(i)); }
        c.stroke();
      }
    }
    c.setLineDash([]);
  };
  /* Left is positive in the plane of the motion; XY is seen from +Z, so left on the screen too. */
  const strokeDeviation = (c, factor) => {
    c.strokeStyle = c.fillStyle = colour("fg"); c.lineWidth = 1; c.globalAlpha = 0.75; c.beginPath();
    let last = null;
    for (let i = 1; i < n; i++) {
      const off = signedUm[i];
      if (off === null || gap[i] || rapid[i] || view !== pairs[0]) { last = null; continue; }
      const [x0, y0] = screen(i - 1), [x1, y1] = screen(i), l = Math.hypot(x1 - x0, y1 - y0), d = off / 1000 * factor * scale;
      if (l < 1e-9) continue;
      const p = [x1 + (y1 - y0) / l * d, y1 - (x1 - x0) / l * d];
      if (Math.abs(d) < 0.8) { last = null; continue; }  // nothing to see: the colour of the path stays free
      c.moveTo(x1, y1); c.lineTo(...p);
      if (last) { c.moveTo(...last); c.lineTo(...p); }
      last = p;
    }
    c.stroke(); c.globalAlpha = 1;
    if (view === pairs[0]) put(c, words.magnify + " x" + factor, canvas.clientWidth - 10, 8, "right", "top");
  };
  const strokeScale = (c, width, height) => {
    const bar = [1, 2, 5].flatMap((m) => [-4, -3, -2, -1, 0, 1, 2, 3].map((p) => +(m * 10 ** p).toPrecision(1))).filter((mm) => mm * scale < width / 4).reduce((a, b) => Math.max(a, b), 0.0001);
    c.strokeStyle = c.fillStyle = colour("fg"); c.lineWidth = 2; line(c, 14, height - 14, 14 + bar * scale, height - 14);
    put(c, bar + " " + (data.units[view[0]] || ""), 14, height - 18, "left", "bottom");
    put(c, data.axes[view[0]] + " →", width - 10, height - 8, "right", "bottom"); put(c, (data.axes[view[1]] || "") + " ↑", 10, 8, "left", "top");
  };
  const redraw = surface(canvas, (c, width, height) => {
    c.clearRect(0, 0, width, height);
    if (!n) return;
    if (!own) fit(0, n);
    strokePath(c);
    if (+magnify.value) strokeDeviation(c, +magnify.value);
    strokeScale(c, width, height);
    if (found > 0) { const [x, y] = screen(found); c.lineWidth = 2; c.beginPath(); c.arc(x, y, 6, 0, 7); c.stroke(); }
  });
  const say = (i) => {
    found = i;
    hover.textContent = i < 0 ? help : words.line + " " + lines[i] + ":  " + data.axes.map((a, k) => a + " " + points[k][i].toFixed(4)).join("  ") + "   " + words.deviation + " " + (um[i] === null ? "-" : um[i].toFixed(2) + " µm") + (data.limits.vertices[i] < 0 ? "" : "   " + limitText(data.limits.names[data.limits.vertices[i]]));
  };
  const nearest = (px, py) => {
    let best = 14 ** 2, at = -1;
    for (let i = 1; i < n; i++) { if (!shown(i)) continue; const [x, y] = screen(i), d = (x - px) ** 2 + (y - py) ** 2; if (d < best) { best = d; at = i; } }
    return at;
  };
  const again = () => { own = false; redraw(); };
  for (const pair of pairs) {
    const button = document.createElement("button");
    button.textContent = pair.map((a) => data.axes[a]).join(""); button.setAttribute("aria-pressed", pair === view);
    button.onclick = () => { view = pair; for (const other of views.children) other.setAttribute("aria-pressed", other === button); again(); };
    views.append(button);
  }
  const worst = signedUm.reduce((most, v) => Math.max(most, Math.abs(v ?? 0)), 1e-6), size = Math.hypot(...[0, 1].map((a) => points[a] && n ? data.extents[a][1] - data.extents[a][0] : 0));
  // where the path is dense, magnified deviations would cover it: the reader switches them on after zooming in
  const proper = n > 20000 ? 0 : [1, 10, 100, 1000, 10000].reduce((a, b) => worst / 1000 * b < size / 25 ? b : a, 1);
  for (const factor of [0, 10, 100, 1000, 10000]) { const o = document.createElement("option"); o.value = factor; o.textContent = factor ? "x" + factor : words.off; o.selected = factor === proper; magnify.append(o); }
  const legends = [document.getElementById("path-legend"), document.createElement("span")];
  legends[1].className = "legend"; legends[1].hidden = true; limitLegend(legends[1]); legends[0].after(legends[1]);
  coloured.onchange = () => { legends.forEach((legend, k) => { legend.hidden = (k === 1) !== (coloured.value === "limit"); }); redraw(); };
  magnify.onchange = rapids.onchange = redraw;
  canvas.addEventListener("dblclick", again);
  canvas.addEventListener("wheel", (e) => {
    if (!n) return;
    e.preventDefault();
    const zoom = Math.exp(-e.deltaY / 400), dx = (e.offsetX - canvas.clientWidth / 2) / scale, dy = -(e.offsetY - canvas.clientHeight / 2) / scale;
    centre = [centre[0] + dx * (1 - 1 / zoom), centre[1] + dy * (1 - 1 / zoom)]; scale *= zoom; own = true; redraw();
  }, { passive: false });
  canvas.addEventListener("pointerdown", () => { moved = 0; });
  canvas.addEventListener("pointermove", (e) => {
    if (!n) return;
    if (e.buttons) { moved += Math.abs(e.movementX) + Math.abs(e.movementY); own = true; centre = [centre[0] - e.movementX / scale, centre[1] + e.movementY / scale]; return redraw(); }
    const at = nearest(e.offsetX, e.offsetY);
    if (at !== found) { say(at); redraw(); onPick(at, false); }
  });
  canvas.addEventListener("click", () => { if (found > 0 && moved < 4) onPick(found, true); });
  return {
    point: (i) => { say(i); redraw(); },
    /* Shows a piece of the path around a vertex, large enough to see its block. */
    visit: (i) => {
      if (i < 0 || i >= n) return;
      let from = i, to = i + 1;
      while (from > 0 && lines[from - 1] === lines[i] && i - from < 2000) from--;
      while (to < n && lines[to] === lines[i] && to - i < 2000) to++;
      fit(Math.max(0, from - 1), to); own = true; scale = Math.min(scale * 0.6, canvas.clientWidth * 2); say(i); redraw(); canvas.scrollIntoView({ block: "center", behavior: "smooth" });
    },
  };
}
