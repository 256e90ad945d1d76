/* Puts the page together: path, charts and tables point at each other. */
const canvas = (id) => document.getElementById(id);
const { sMm } = data.path;

/* First vertex at or behind a path length. */
function vertexAt(s) {
  let low = 0, high = sMm.length - 1;
  while (low < high) { const middle = (low + high) >> 1; if (sMm[middle] < s) low = middle + 1; else high = middle; }
  return high;
}

const filter = table(canvas("blocks"), [
  { name: "line", label: words.line }, { name: "text", label: words.text, text: true }, { name: "max_um", label: words.max_um, digits: 2 },
  { name: "rms_um", label: words.rms_um, digits: 2, extra: true }, { name: "verdict", label: words.verdict }, { name: "length_mm", label: words.length, digits: 3, extra: true },
  { name: "time_s", label: words.block_time, digits: 3 }, { name: "programmed_mm_min", label: words.f_prog, digits: 0, extra: true },
  { name: "mean_mm_min", label: words.f_mean, digits: 0, extra: true }, { name: "max_mm_min", label: words.f_max, digits: 0, extra: true },
  { name: "limited", label: words.limited_by, text: true, extra: true },
], data.blocks.map((row) => ({ ...row, limited: row.limit ? limitText(row.limit) + (row.limit_pct < 99.5 ? " " + row.limit_pct.toFixed(0) + " %" : "") : "" })), { over: (row) => row.max_um > data.toleranceUm, pick: (row) => visit(row.vertex) });

const path = pathView(canvas("path"), (i, clicked) => {
  overLength.mark(i < 0 ? null : sMm[i]);
  if (clicked) { canvas("filter").value = String(data.path.lines[i]); filter(String(data.path.lines[i])); }
});
const overLength = chart(canvas("length"), {
  step: data.length.step, xLabel: words.path_mm, yLabel: "µm", limits: [{ value: data.toleranceUm, text: words.limit + " " + short(data.toleranceUm) + " µm" }],
  curves: [{ band: data.length.actualUm, colour: "good", text: words.actual }, { band: data.length.setpointUm, colour: "set", text: words.set }],
  onPoint: (s) => path.point(s === null ? -1 : vertexAt(s)),
});
function visit(i) { path.visit(i); overLength.mark(sMm[i]); }
for (const row of document.querySelectorAll("#findings tr[data-vertex]")) {
  row.onclick = () => visit(+row.dataset.vertex);
  row.onkeydown = (e) => { if (e.key === "Enter") visit(+row.dataset.vertex); };
}

for (const row of document.querySelectorAll("#sections tr[data-line]")) row.onclick = () => { canvas("filter").value = row.dataset.line; filter(row.dataset.line); visit(data.path.lines.indexOf(+row.dataset.line)); };
const fast = canvas("fast");
const speed = chart(canvas("speed"), {
  step: data.time.step, xLabel: words.machine_time, yLabel: "mm/min", cap: () => fast.checked ? 0 : data.feedMax * 1.15,
  curves: [{ band: data.time.programmed, colour: "set", text: words.programmed }, { band: data.time.speed, colour: "good", text: words.reached }],
});
fast.onchange = speed.redraw;
data.time.following.forEach((band, k) => {
  const own = document.createElement("canvas"), last = k === data.axes.length - 1;
  own.className = "axis"; own.setAttribute("role", "img"); own.setAttribute("aria-label", words.following + " " + data.axes[k]); canvas("following").append(own);
  chart(own, { step: data.time.step, xLabel: last ? words.machine_time : "", yLabel: data.axes[k] + "  " + data.units[k], curves: [{ band, colour: "good", text: "" }],
    limits: data.mpe[k] > 0 ? [{ value: data.mpe[k], text: "mpe " + short(data.mpe[k]) }] : [] });
});
chart(canvas("override"), { step: data.time.step, xLabel: words.machine_time, yLabel: "%", curves: [{ band: data.time.factor, colour: "good", text: "" }] });
histogram(canvas("histogram"), data.histogram);
limitLegend(canvas("limit-legend"));
limitStrip(canvas("limits"));

canvas("filter").addEventListener("input", (e) => filter(e.target.value));
if (data.blocks.length < data.blockCount) canvas("block-note").textContent = words.worst_of.replace("{shown}", data.blocks.length).replace("{all}", data.blockCount);
if (data.events.length < data.eventCount) canvas("event-note").textContent = words.first_of.replace("{shown}", data.events.length).replace("{all}", data.eventCount);
const alarms = new Set(data.alarms.map((a) => [a.t_s, a.axis, a.name].join("|")));
const what = (e) => e.name + (e.on ? "" : " " + words.off) + (e.text ? " " + e.text : e.kind === "outputs" ? " = " + e.value : "");
table(canvas("events"), [
  { name: "t_s", label: "s", digits: 3 }, { name: "line", label: words.line }, { name: "kind", label: words.kind, text: true }, { name: "axis", label: words.axis, text: true }, { name: "what", label: words.name, text: true },
], data.events.map((e) => ({ ...e, line: e.line || null, alarm: alarms.has([e.t_s, e.axis, e.name].join("|")), what: what(e), kind: words["kind_" + e.kind] || e.kind })), { over: (row) => row.alarm });
