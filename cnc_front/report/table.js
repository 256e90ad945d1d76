/* A table that sorts by its head and filters; columns: {name, label, digits, text, extra (left out on a phone)}. */
function table(element, columns, rows, { over = () => false, pick = null } = {}) {
  let sorted = rows.slice(), key = null, down = true, needle = "";
  const MOST = 1000;
  const show = (v, digits) => v === null || v === undefined ? "-" : typeof v !== "number" ? v : digits === undefined ? v : v.toFixed(digits);
  const order = (name) => {
    down = key === name ? !down : true; key = name;
    sorted.sort((a, b) => { const x = a[name], y = b[name], d = typeof x === "number" || typeof y === "number" ? (x ?? -Infinity) - (y ?? -Infinity) : String(x).localeCompare(String(y)); return down ? -d : d; });
    draw();
  };
  const kind = (column) => [column.text && "text", column.extra && "extra"].filter(Boolean).join(" ");
  const head = () => {
    const thead = document.createElement("thead"), tr = thead.insertRow();
    for (const column of columns) {
      const cell = document.createElement("th"), button = document.createElement("button");
      cell.className = kind(column); cell.setAttribute("aria-sort", key !== column.name ? "none" : down ? "descending" : "ascending");
      button.textContent = column.label + (key === column.name ? (down ? " ▼" : " ▲") : ""); button.onclick = () => order(column.name);
      cell.append(button); tr.append(cell);
    }
    return thead;
  };
  const draw = () => {
    const body = document.createElement("tbody");
    for (const row of sorted) {
      if (needle && !columns.some(({ name }) => String(row[name]).toLowerCase().includes(needle))) continue;
      const tr = body.insertRow();
      if (over(row)) tr.className = "over";
      if (pick) tr.onclick = () => pick(row);
      for (const column of columns) { const td = tr.insertCell(); if (column.text || column.extra) td.className = kind(column); td.textContent = show(row[column.name], column.digits); }
      if (body.rows.length >= MOST) break;
    }
    element.replaceChildren(head(), body);
  };
  draw();
  return (text) => { needle = text.toLowerCase(); draw(); };
}
