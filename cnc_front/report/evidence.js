/* Polar plots of full circles (ISO 230-4) and histograms of acceleration and jerk. */
const checkWords = data.checkWords;
const roundDown = (v) => { const p = Math.pow(10, Math.floor(Math.log10(v))); return [5, 2, 1].map((m) => m * p).find((s) => s <= v * (1 + 1e-12)) || p; };

/* The nominal circle is drawn as a ring; the deviation stands out from it, magnified by a factor that is printed. */
function polar(canvas, { angle, low, high, title, axes }) {
  const most = Math.max(1e-6, ...high.map(Math.abs), ...low.map(Math.abs));
  surface(canvas, (c, width, height) => {
    const radius = Math.min(width, height - 40) * 0.33, cx = width / 2, cy = 26 + (height - 40) / 2, room = radius * 0.42, step = roundDown(most);
    const scale = room / most, at = (a, um) => [cx + (radius + um * scale) * Math.cos(a), cy - (radius + um * scale) * Math.sin(a)];
    c.clearRect(0, 0, width, height);
    c.lineWidth = 1; c.strokeStyle = colour("rule");
    line(c, cx - radius - room, cy, cx + radius + room, cy); line(c, cx, cy - radius - room, cx, cy + radius + room);
    for (const um of [-step, 0, step]) {
      c.strokeStyle = colour(um ? "rule" : "soft"); c.setLineDash(um ? [3, 4] : []);
      c.beginPath(); c.arc(cx, cy, radius + um * scale, 0, 2 * Math.PI); c.stroke();
    }
    c.setLineDash([]); c.strokeStyle = colour("good"); c.lineWidth = 1.4;
    for (const band of [low, high]) {
      c.beginPath();
      band.forEach((um, k) => { const [x, y] = at(angle[k], um); if (k && angle[k] - angle[k - 1] < 0.05) c.lineTo(x, y); else c.moveTo(x, y); });
      c.stroke();
    }
    c.fillStyle = colour("fg"); put(c, title, 8, 6, "left", "top");
    c.fillStyle = colour("soft"); put(c, axes[0], cx + radius + room + 4, cy, "left", "middle"); put(c, axes[1], cx, cy - radius - room - 3, "center", "bottom");
    // how many times larger than the drawing of the circle itself
    const factor = scale / (radius / (canvas.dataset.radius * 1000));
    put(c, "± " + short(step) + " µm   " + checkWords.magnified + " × " + short(+factor.toPrecision(3)), 8, height - 6, "left", "bottom");
  });
}

/* Samples by magnitude; classes of a quarter octave, counts drawn by their logarithm. */
function magnitudes(canvas, bins, title, limit) {
  const most = Math.max(1, ...bins.map((b) => b[1])), x0 = bins.length ? Math.log2(bins[0][0]) - 0.5 : 0, x1 = Math.max(x0 + 1, bins.length ? Math.log2(bins[bins.length - 1][0]) : 1, limit ? Math.log2(limit) + 0.3 : 0);
  surface(canvas, (c, width, height) => {
    const box = { left: 12, right: width - 12, top: 22, bottom: height - 22 }, x = (v) => box.left + (box.right - box.left) * (Math.log2(v) - x0) / (x1 - x0);
    c.clearRect(0, 0, width, height);
    for (const [edge, count] of bins) {
      const h = (box.bottom - box.top) * (0.06 + 0.94 * Math.log(count) / Math.max(1, Math.log(most))), left = x(edge / 1.25);
      c.fillStyle = colour(limit && edge > limit * 1.25 ? "warn" : "good"); c.fillRect(left, box.bottom - h, Math.max(1, x(edge) - left - 1), h);
    }
    c.fillStyle = colour("soft");
    for (let p = Math.ceil(x0 * Math.log10(2)); p <= x1 * Math.log10(2); p++) put(c, "1e" + p, x(Math.pow(10, p)), box.bottom + 4, "center", "top");
    if (limit) { c.strokeStyle = colour("bad"); c.setLineDash([6, 4]); line(c, x(limit), box.top, x(limit), box.bottom); c.setLineDash([]); }
    c.fillStyle = colour("fg"); put(c, title, box.left, 4, "left", "top");
  });
}

document.querySelectorAll("canvas.polar").forEach((element, k) => { element.dataset.radius = data.circles[k].radiusMm; polar(element, data.circles[k]); });
const dynamics = document.getElementById("dynamics");
for (const [name, axis] of Object.entries(data.checks)) if (dynamics) for (const [kind, bins, limit, unit] of [["acceleration", axis.acceleration, axis.accelerationLimit, "/s²"], ["jerk", axis.jerk, 0, "/s³"]]) {
  const own = document.createElement("canvas");
  own.className = "magnitude"; own.setAttribute("role", "img"); own.setAttribute("aria-label", checkWords[kind] + " " + name); dynamics.append(own);
  magnitudes(own, bins, name + " " + checkWords[kind].split(" ")[0] + " " + data.units[data.axes.indexOf(name)] + unit, limit);
}
