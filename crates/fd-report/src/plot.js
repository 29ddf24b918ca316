// What the pictures of a report do beyond being looked at: the values under the pointer (or at the arrow keys), and zoom
// by dragging, back by a double click or Escape. Without it they are the same pictures, standing still.
"use strict";
for (const plot of document.querySelectorAll("[data-plot]")) lively(plot, JSON.parse(plot.dataset.plot));

function lively(plot, data) {
  const svg = plot.querySelector("svg");
  const [left, top, right, bottom] = data.box;
  let view = { x: data.x, y: data.y };
  const live = add(svg, "g", { class: "live" });
  const over = add(svg, "g", { class: "live" });
  const values = document.createElement("div");
  values.className = "values";
  values.setAttribute("role", "status");
  values.hidden = true;
  plot.append(values);
  const back = document.createElement("button");
  back.textContent = "whole picture";
  back.hidden = true;
  plot.append(back);

  // Places in the drawing, and back to values.
  const up = ([low, high, log], v) => log ? Math.log(v / low) / Math.log(high / low) : (v - low) / (high - low);
  const down = ([low, high, log], t) => log ? low * Math.pow(high / low, t) : low + t * (high - low);
  const px = x => left + up(view.x, x) * (right - left);
  const py = y => bottom - up(view.y, y) * (bottom - top);
  const at = event => {
    const point = new DOMPoint(event.clientX, event.clientY).matrixTransform(svg.getScreenCTM().inverse());
    return Math.min(Math.max(point.x, left), right);
  };
  const value = x => down(view.x, (x - left) / (right - left));

  function read(x) {
    const wanted = value(x);
    over.replaceChildren();
    add(over, "line", { x1: x, x2: x, y1: top, y2: bottom, stroke: "var(--muted)", "stroke-width": 3 });
    const rows = [];
    let shown = wanted;
    for (const line of data.lines) {
      let best = null;
      for (const point of line.points)
        if (point[1] !== null && (!best || Math.abs(point[0] - wanted) < Math.abs(best[0] - wanted))) best = point;
      if (!best || up(view.x, best[0]) < -0.01 || up(view.x, best[0]) > 1.01) continue;
      add(over, "circle", { cx: px(best[0]), cy: py(best[1]), r: 14, fill: line.colour });
      rows.push([line, best]);
      shown = best[0];
    }
    values.replaceChildren(text(`${data.names[0]}: ${figure(shown)}`));
    for (const [line, best] of rows) {
      const row = document.createElement("div"), swatch = document.createElement("i");
      swatch.style.background = line.colour;
      row.append(swatch, `${line.name || data.names[1]}: ${figure(best[1])}`);
      values.append(row);
    }
    values.hidden = false;
    const share = (x - left) / (right - left);
    values.style.left = share < 0.5 ? `${100 * x / svg.viewBox.baseVal.width + 1}%` : "";
    values.style.right = share < 0.5 ? "" : `${100 - 100 * x / svg.viewBox.baseVal.width + 1}%`;
  }
  const hide = () => { over.replaceChildren(); values.hidden = true; };

  // The part between two values of the horizontal axis, as high as what is in it.
  function zoom(low, high) {
    const inside = data.lines.flatMap(l => l.points).filter(p => p[1] !== null && low <= p[0] && p[0] <= high).map(p => p[1]);
    if (inside.length < 2) return;
    const [least, most] = [inside.reduce((a, b) => Math.min(a, b)), inside.reduce((a, b) => Math.max(a, b))];
    const pad = 0.05 * (most - least) || 0.5 * Math.abs(most) || 1;
    const y = data.y[2] ? [least / 1.1, most * 1.1, true] : [least - pad, most + pad, false];
    view = { x: [low, high, data.x[2]], y };
    svg.classList.add("zoomed");
    back.hidden = false;
    draw();
  }
  function whole() {
    view = { x: data.x, y: data.y };
    svg.classList.remove("zoomed");
    back.hidden = true;
    live.replaceChildren();
    hide();
  }
  function draw() {
    live.replaceChildren();
    const size = 48;
    const label = (x, y, anchor, words) =>
      add(live, "text", { x, y, "text-anchor": anchor, "font-size": size, "font-family": "sans-serif", fill: "var(--ink)" }, words);
    add(live, "rect", { x: left, y: top, width: right - left, height: bottom - top, fill: "none", stroke: "var(--muted)", "stroke-width": 3 });
    for (const x of ticks(view.x)) {
      add(live, "line", { x1: px(x), x2: px(x), y1: top, y2: bottom, stroke: "var(--rule)", "stroke-width": 3 });
      label(px(x), bottom + 1.3 * size, "middle", figure(x));
    }
    for (const y of ticks(view.y)) {
      add(live, "line", { x1: left, x2: right, y1: py(y), y2: py(y), stroke: "var(--rule)", "stroke-width": 3 });
      label(left - 0.4 * size, py(y) + 0.35 * size, "end", figure(y));
    }
    label((left + right) / 2, bottom + 2.7 * size, "middle", data.names[0]);
    label(left, top - 0.5 * size, "start", data.names[1]);
    const name = `clip-${Math.random().toString(36).slice(2)}`;
    add(add(live, "clipPath", { id: name }), "rect", { x: left, y: top, width: right - left, height: bottom - top });
    const drawn = add(live, "g", { "clip-path": `url(#${name})` });
    for (const [level] of data.levels) dash(drawn, left, py(level), right, py(level), "var(--level)");
    for (const [mark] of data.marks) dash(drawn, px(mark), top, px(mark), bottom, "var(--mark)");
    for (const line of data.lines) {
      if (line.dots) {
        for (const [x, y] of line.points) if (y !== null) add(drawn, "circle", { cx: px(x), cy: py(y), r: 12, fill: line.colour });
        continue;
      }
      let path = "", pen = "M";
      for (const [x, y] of line.points) {
        if (y === null) { pen = "M"; continue; }
        path += `${pen}${px(x).toFixed(1)} ${py(y).toFixed(1)}`;
        pen = "L";
      }
      add(drawn, "path", { d: path, fill: "none", stroke: line.colour, "stroke-width": 8 });
    }
  }

  let from = null;
  svg.addEventListener("pointerdown", event => { if (event.pointerType !== "touch" && event.button === 0) from = at(event); });
  svg.addEventListener("pointermove", event => {
    const x = at(event);
    read(x);
    if (from !== null) add(over, "rect", { x: Math.min(from, x), y: top, width: Math.abs(x - from), height: bottom - top, fill: "var(--muted)", opacity: 0.25 });
  });
  svg.addEventListener("pointerup", event => {
    const to = at(event);
    // A movement of less than a hundredth is a click.
    if (from !== null && Math.abs(to - from) > (right - left) / 100) zoom(value(Math.min(from, to)), value(Math.max(from, to)));
    from = null;
  });
  svg.addEventListener("pointerleave", () => { from = null; hide(); });
  svg.addEventListener("dblclick", whole);
  back.addEventListener("click", whole);
  let cursor = left;
  svg.addEventListener("keydown", event => {
    const step = { ArrowLeft: -1, ArrowRight: 1 }[event.key];
    if (event.key === "Escape") whole();
    if (step === undefined) return;
    event.preventDefault();
    cursor = Math.min(Math.max(cursor + step * (right - left) / 50, left), right);
    read(cursor);
  });
  svg.addEventListener("blur", hide);
}

function add(parent, tag, attributes, words) {
  const element = document.createElementNS("http://www.w3.org/2000/svg", tag);
  for (const [name, value] of Object.entries(attributes)) {
    // Colours of the page are known to styles only.
    if (String(value).startsWith("var(")) element.style[name] = value;
    else element.setAttribute(name, value);
  }
  if (words !== undefined) element.textContent = words;
  parent.append(element);
  return element;
}

function dash(parent, x1, y1, x2, y2, stroke) {
  add(parent, "line", { x1, y1, x2, y2, stroke, "stroke-width": 4, "stroke-dasharray": "24 16" });
}

function text(words) {
  const element = document.createElement("div");
  element.textContent = words;
  return element;
}

// Four digits, as the tables have them.
function figure(value) {
  const size = Math.abs(value);
  return size !== 0 && (size < 1e-3 || size >= 1e5) ? value.toExponential(3) : String(Number(value.toPrecision(4)));
}

// Some five round values within a range.
function ticks([low, high, log]) {
  if (log && high / low > 5) {
    const found = [];
    for (let e = Math.floor(Math.log10(low)); e <= Math.log10(high); e++)
      for (const m of high / low > 1e3 ? [1] : [1, 2, 5]) found.push(m * Math.pow(10, e));
    return found.filter(v => low <= v && v <= high);
  }
  const rough = (high - low) / 5, power = Math.pow(10, Math.floor(Math.log10(rough)));
  const step = [1, 2, 5, 10].map(m => m * power).find(s => rough <= s);
  const found = [];
  for (let k = Math.ceil(low / step); k * step <= high; k++) found.push(k * step);
  return found;
}
