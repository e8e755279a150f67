"""Style sheet and script of a report page, embedded in the page so that it opens offline."""

from __future__ import annotations

import json

from flexros.report.colours import DARK
from flexros.report.theme import FONT

_NAMES = {
    "paper": "#ffffff",
    "ink": "#1b1f24",
    "muted": "#59636e",
    "grid": "#e7eaee",
    "frame": "#d5dae0",
    "shade": "#f6f8fa",
    "accent": "#0072b2",
    "warn": "#b35900",
}
"""Colours of the page by name, as on a light page."""
_LIGHT_COLOURS = " ".join(f"--{name}: {colour};" for name, colour in _NAMES.items())
_DARK_COLOURS = " ".join(f"--{name}: {DARK[colour]};" for name, colour in _NAMES.items())

STYLE = (
    f":root {{ color-scheme: light dark; {_LIGHT_COLOURS} }}\n"
    f"@media screen and (prefers-color-scheme: dark) {{ :root {{ {_DARK_COLOURS} }} }}\n"
    f"body {{ font: 16px/1.55 {FONT}; }}"
    """
* { box-sizing: border-box; }
html { scroll-behavior: smooth; }
body { margin: 0; background: var(--paper); color: var(--ink); }
main { max-width: 1080px; margin: 0 auto; padding: 32px 32px 72px; }
nav { max-width: 1080px; margin: 0 auto; padding: 16px 32px 0; font-size: 13.5px; line-height: 1.4; }
nav b { display: none; }
nav a { color: var(--accent); text-decoration: none; display: inline-block; padding: 3px 14px 3px 0; }
nav a:hover { text-decoration: underline; }
@media screen and (min-width: 1240px) {
  body { display: grid; grid-template-columns: 220px minmax(0, 1080px); justify-content: center; }
  body > main:first-child { grid-column: 1 / -1; width: 100%; }
  main { margin: 0; }
  nav { position: sticky; top: 0; align-self: start; max-height: 100vh; overflow-y: auto; margin: 0;
    padding: 46px 8px 24px 20px; }
  nav b { display: block; color: var(--muted); font-weight: 600; margin-bottom: 4px; }
  nav a { display: block; padding: 4px 0; }
}
header p { margin: 0; color: var(--muted); font-size: 14px; }
h1 { font-size: 30px; line-height: 1.2; font-weight: 650; margin: 4px 0 6px; letter-spacing: -0.01em;
  overflow-wrap: anywhere; }
h2 { font-size: 21px; font-weight: 650; margin: 40px 0 12px; padding-top: 18px; border-top: 1px solid var(--frame); }
h3 { font-size: 17px; font-weight: 650; margin: 30px 0 8px; }
p { max-width: 78ch; margin: 10px 0; overflow-wrap: break-word; }
p.lead { font-size: 20px; line-height: 1.45; max-width: 68ch; margin: 18px 0 22px; }
p.note { color: var(--muted); font-size: 14px; }
p.for::before { content: "+"; color: var(--accent); font-weight: 700; margin-right: 8px; }
p.against::before { content: "\\2212"; color: var(--warn); font-weight: 700; margin-right: 8px; }
p.for, p.against { margin: 4px 0; }
details { border: 1px solid var(--frame); border-radius: 6px; margin: 14px 0; padding: 0 14px; }
summary { cursor: pointer; padding: 9px 0; font-size: 15px; color: var(--accent); }
details[open] > summary { border-bottom: 1px solid var(--grid); }
.listing { position: relative; }
.listing pre { background: var(--shade); border-radius: 6px; padding: 14px 16px; overflow: auto; max-height: 420px;
  font-size: 13.5px; line-height: 1.5; margin: 0; }
.listing button { position: absolute; right: 8px; top: 8px; font: inherit; font-size: 13px; color: var(--ink);
  background: var(--paper); border: 1px solid var(--frame); border-radius: 4px; padding: 2px 10px; cursor: pointer; }
p.warning { border-left: 3px solid var(--warn); padding: 2px 0 2px 12px; }
.tiles { display: grid; grid-template-columns: repeat(auto-fit, minmax(210px, 1fr)); gap: 12px; margin: 22px 0 26px; }
.tile { border: 1px solid var(--frame); border-radius: 6px; padding: 12px 16px 10px; min-width: 0; }
.tile .name { color: var(--muted); font-size: 13px; }
.tile .value { font-size: 28px; font-weight: 600; line-height: 1.25; font-variant-numeric: tabular-nums;
  overflow-wrap: anywhere; }
.tile .value small { font-size: 15px; font-weight: 400; color: var(--muted); margin-left: 4px; }
.tile .below { color: var(--muted); font-size: 13px; font-variant-numeric: tabular-nums; overflow-wrap: anywhere; }
figure { margin: 18px 0 26px; }
figcaption { color: var(--muted); font-size: 14px; max-width: 90ch; margin: 6px 0; }
figcaption b { color: var(--ink); font-weight: 600; }
.scroll { overflow-x: auto; }
.table .scroll { background: linear-gradient(to left, var(--paper) 24px, transparent 48px) 100% 0 / 48px 100% no-repeat
  local, linear-gradient(to left, var(--frame), transparent) 100% 0 / 16px 100% no-repeat; }
table { border-collapse: collapse; font-size: 14px; font-variant-numeric: tabular-nums; min-width: 60%; }
th, td { padding: 5px 14px 5px 0; text-align: right; border-bottom: 1px solid var(--grid); vertical-align: top; }
th { font-weight: 600; border-bottom: 1.5px solid var(--ink); vertical-align: bottom; }
th.left, td.left { text-align: left; overflow-wrap: break-word; max-width: 58ch; }
th.left:first-child, td.left:first-child { min-width: 6.8em; }
td.long { min-width: 15em; }
td.group { text-align: left; font-weight: 600; padding-top: 14px; max-width: 0; overflow-wrap: anywhere; }
.picture { width: 100%; }
.modebar-container { top: auto !important; bottom: 26px; }
.magnifier { display: flex; flex-wrap: wrap; align-items: center; gap: 4px 10px; font-size: 14px; }
.magnifier input { width: 260px; max-width: 60vw; accent-color: var(--accent); }
.magnifier output { font-variant-numeric: tabular-nums; font-weight: 600; min-width: 5ch; }
.magnifier button { font: inherit; min-width: 5.2em; color: var(--ink); background: var(--shade); cursor: pointer;
  border: 1px solid var(--frame); border-radius: 4px; padding: 1px 10px; }
noscript p { border: 1px solid var(--warn); padding: 10px 14px; }
@media screen and (max-width: 600px) {
  main { padding: 18px 16px 48px; }
  nav { padding: 12px 16px 0; }
  h1 { font-size: 25px; }
  p.lead { font-size: 18px; }
  .tiles { grid-template-columns: 1fr 1fr; gap: 8px; }
  .tile { padding: 8px 10px; }
  .tile .value { font-size: 21px; }
  .tile .value small { font-size: 13px; }
  details { padding: 0 10px; }
  th, td { padding-right: 10px; }
  table { font-size: 13px; }
  td.value { overflow-wrap: anywhere; min-width: 11em; }
}
@media print {
  @page { size: A4; margin: 14mm; }
  body { font-size: 10.5pt; display: block; }
  main { max-width: none; padding: 0; }
  nav { display: none; }
  h2, h3 { break-after: avoid; }
  h2 { margin-top: 28px; }
  figure, .tile, tr { break-inside: avoid; }
  figure.table { break-inside: auto; }
  figure.table figcaption { break-after: avoid; }
  .scroll { overflow: visible; }
  table { font-size: 8.5pt; }
  th, td { padding: 3px 8px 3px 0; }
  .tiles { grid-template-columns: repeat(4, 1fr); }
  .magnifier, .modebar, .listing button { display: none !important; }
  .listing pre { max-height: none; white-space: pre-wrap; overflow: visible; }
}
"""
)

SCRIPT = (
    f'"use strict";\nconst darker = {json.dumps(DARK)};\n'
    """const data = JSON.parse(document.getElementById("pictures").textContent);
const tools = ["zoom2d", "pan2d", "resetScale2d", "toImage"];
const night = window.matchMedia("(prefers-color-scheme: dark)");
let printing = false;

const lined = (text, letters) => {
  const lines = [""];
  for (const word of text.split(" ")) {
    if ((lines[lines.length - 1] + " " + word).length > letters && lines[lines.length - 1]) lines.push(word);
    else lines[lines.length - 1] = (lines[lines.length - 1] + " " + word).trim();
  }
  return lines;
};

// On a narrow screen panels stand below each other, and their titles and names of bars are divided into lines.
const narrow = ({data, layout}, width) => {
  const axes = Object.keys(layout).filter((name) => /^xaxis\\d*$/.test(name));
  const domain = (name) => (layout[name] && layout[name].domain) || [0, 1];
  const columns = new Set(axes.map((name) => domain(name)[0])).size;
  const margin = layout.margin;
  margin.l = Math.min(margin.l, Math.max(56, 0.32 * width));
  margin.r = Math.min(margin.r, 10);
  if (layout.scene) for (const axis of "xyz") layout.scene.camera.eye[axis] *= 1.6;
  if (layout.updatemenus && layout.legend) {  // the menus take the whole width
    Object.assign(layout.legend, {y: -60 / (layout.height - margin.t - margin.b), yanchor: "top"});
    margin.b += 90;
    layout.height += 90;
  }
  const notes = (layout.annotations || []).filter((note) => note.xref === "paper" && note.yref === "paper");
  if (columns === 2) {
    const across = (name) => "yaxis" + name.slice(5);
    const below = (a, b) => domain(across(b))[0] - domain(across(a))[0];
    const order = axes.slice().sort((a, b) => below(a, b) || domain(a)[0] - domain(b)[0]);
    const inner = layout.height - margin.t - margin.b;
    const row = Math.max(110, inner * (domain(across(axes[0]))[1] - domain(across(axes[0]))[0]));
    const gap = 64, total = order.length * (row + gap) - gap;
    order.forEach((name, place) => {
      const y = across(name), top = 1 - place * (row + gap) / total;
      for (const note of notes) {
        const above = Math.abs(note.y - domain(y)[1]) < 1e-6;
        const beside = note.x >= domain(name)[0] - 0.01 && note.x < domain(name)[1];
        if (above && beside && !note.moved) { note.x = 0; note.y = top; note.moved = true; }
      }
      layout[name].domain = [0, 1];
      layout[name].showticklabels = true;
      layout[y].domain = [Math.max(0, top - row / total), top];
    });
    for (const note of notes) delete note.moved;
    layout.height = total + margin.t + margin.b;
  }
  for (const trace of data) {  // names below narrow cells are turned: the lines of two neighbours would meet
    const axis = trace.type === "heatmap" && layout["xaxis" + (trace.xaxis || "x").slice(1)];
    if (!axis || typeof trace.x[0] !== "string" || (width - margin.l - margin.r) / trace.x.length > 48) continue;
    const font = Object.assign({}, axis.tickfont, {size: 10});
    const ticktext = trace.x.map((name) => name.replaceAll("<br>", " "));
    Object.assign(axis, {tickmode: "array", tickvals: trace.x, ticktext, tickfont: font, tickangle: 90});
    const room = 6 * Math.max(...ticktext.map((name) => name.length)) + 30 - margin.b;
    if (room > 0) { margin.b += room; layout.height += room; }
  }
  const [across, up] = ["xaxis", "yaxis"].map((name) => layout[name] && layout[name].range);
  if (layout.yaxis && layout.yaxis.scaleanchor) {  // equal scales: no higher than its shape asks
    const stated = (layout.meta && layout.meta.shape) || 1;
    const shape = across && up ? (up[1] - up[0]) / (across[1] - across[0]) : Math.min(1, Math.max(0.35, stated));
    const legend = 19 * data.filter((trace) => trace.showlegend !== false).length;
    layout.height = Math.min(layout.height, (width - margin.l - margin.r) * shape + margin.b + margin.t + legend);
  }
  const letters = Math.floor((width - margin.l - margin.r) / 7);
  for (const note of notes) {
    if (note.xanchor !== "left" || !note.text || note.text.includes("<")) continue;
    const lines = lined(note.text, letters);
    note.text = lines.join("<br>");
    if (lines.length > 1) note.font = Object.assign({}, note.font, {size: 11});
  }
  for (const trace of data) {
    const axis = layout["yaxis" + (trace.yaxis || "y").slice(1)];
    if (!axis) continue;
    const font = Object.assign({}, axis.tickfont, {size: 11});
    if (axis.ticktext && trace.orientation === "h") axis.tickfont = font;
    const beside = Math.floor((margin.l - 12) / 6);
    const split = (name) => lined(name.replaceAll("<br>", " "), beside).join("<br>");
    if (axis.ticktext && trace.type === "heatmap") {
      Object.assign(axis, {ticktext: axis.ticktext.map(split), tickfont: font});
    }
    if (axis.tickvals || !Array.isArray(trace.y) || typeof trace.y[0] !== "string") continue;
    const own = data.filter((other) => (other.yaxis || "y") === (trace.yaxis || "y"));
    const names = [...new Set(own.flatMap((other) => Array.isArray(other.y) ? other.y : []))];
    Object.assign(axis, {tickmode: "array", tickvals: names, ticktext: names.map(split), tickfont: font});
  }
};

// On a narrow screen and on paper texts beside bars need more of the axis.
const widened = ({data, layout}, width) => {
  const margin = layout.margin;
  for (const trace of data) {
    const axis = layout["xaxis" + (trace.xaxis || "x").slice(1)];
    const beside = trace.type === "bar" && trace.textposition === "outside" || trace.mode === "text";
    if (!beside || !axis || !axis.range || axis.type === "log" || !Array.isArray(trace.x)) continue;
    const letters = Math.max(...[].concat(trace.text).map((text) => String(text).length));
    const inner = width - margin.l - margin.r, part = Math.min(0.5, (8 * letters + 8) / inner);
    const longest = Math.max(...trace.x.filter((x) => typeof x === "number"));
    axis.range[1] = Math.max(axis.range[1], axis.range[0] + (longest - axis.range[0]) / (1 - part));
  }
};

// On paper two pictures share a page; one of many rows keeps 100 px for each, bars and cells keep their height.
const paperHeight = ({data, layout}) => {
  if (data.some((trace) => trace.type === "bar" || trace.type === "heatmap")) return layout.height;
  const axes = Object.keys(layout).filter((name) => /^yaxis\\d*$/.test(name));
  const rows = new Set(axes.map((name) => ((layout[name] && layout[name].domain) || [0])[0].toFixed(3))).size;
  const titled = (name) => /^xaxis/.test(name) && layout[name].title && layout[name].title.text;
  if (Object.keys(layout).filter(titled).length * rows > axes.length) return layout.height;  // titles between the rows
  return Math.min(layout.height, Math.max(420, 116 + 100 * rows));
};

// On paper the right one of two columns leaves room for the names of its axes; texts are smaller.
const apart = ({layout}, width) => {
  const axes = Object.keys(layout).filter((name) => /^xaxis\\d*$/.test(name) && layout[name].domain);
  const starts = [...new Set(axes.map((name) => layout[name].domain[0]))];
  if (starts.length !== 2) return;
  const right = Math.max(...starts), letters = Math.floor((width - layout.margin.l - layout.margin.r) * 0.42 / 7);
  for (const name of axes) {
    if (layout[name].domain[0] === right) layout[name].domain = [right + 0.04, 1];
    if (!layout[name].tickvals && layout[name].type !== "log") layout[name].nticks = 4;
    layout[name].tickfont = Object.assign({}, layout[name].tickfont, {size: 10});
  }
  for (const note of layout.annotations || []) {
    if (Math.abs(note.x - right) < 1e-6) note.x += 0.04;
    const long = note.xanchor === "left" && note.yref === "paper" && note.text.length > letters;
    if (long) note.font = Object.assign({}, note.font, {size: 10});
  }
};

const paint = (picture, plot) => {
  const element = document.getElementById(picture.id);
  if (!element.clientWidth || element.closest("details:not([open])")) return;
  let text = JSON.stringify(picture.figure);
  if (night.matches && !printing) text = text.replace(/#[0-9a-f]{6}/g, (colour) => darker[colour] || colour);
  const figure = JSON.parse(text), small = element.clientWidth < 560;
  if (small) narrow(figure, element.clientWidth);
  if (small || printing) widened(figure, element.clientWidth);
  if (printing) {
    figure.layout.height = paperHeight(figure);
    apart(figure, element.clientWidth);
  }
  element.style.height = figure.layout.height + "px";
  const options = {responsive: true, displaylogo: false, displayModeBar: small ? false : undefined};
  options.modeBarButtons = figure.layout.scene ? undefined : [tools];
  element.drawn = plot(element, figure.data, figure.layout, options).then(() => picture.set && picture.set());
};
const draw = (plot) => {
  for (const picture of data) {
    try {
      paint(picture, plot);
    } catch (fault) {  // the other pictures are drawn
      document.getElementById(picture.id).textContent = "This picture cannot be drawn: " + fault;
      setTimeout(() => { throw fault; });
    }
  }
};

const magnifier = (picture) => {
  const element = document.getElementById(picture.id), slider = document.getElementById(picture.id + "-slider");
  picture.set = () => {
    const factor = picture.factors[Number(slider.value)];
    const moved = (k) => picture.magnified.map((c) => c.base.map((p, i) => p[k] + factor * c.deviation[i][k]));
    for (const text of document.querySelectorAll("." + picture.id + "-factor")) text.textContent = String(factor);
    return Plotly.restyle(element, {x: moved(0), y: moved(1)}, picture.magnified.map((c) => c.trace));
  };
  slider.addEventListener("input", picture.set);
};

// An arm is played at a speed at which its motion takes 8 s, or as fast as it is.
const player = (picture) => {
  const part = (end) => document.getElementById(picture.id + end), line = picture.moving, last = line.time.length - 1;
  const span = Math.max(8, line.time[last] - line.time[0]);
  let ahead = null;
  picture.set = () => {
    const row = Number(part("-time").value), factor = picture.factors[Number(part("-slider").value)];
    const moved = (k) => line.base[row].map((point, i) => point[k] + factor * line.deviation[row][i][k]);
    part("-now").textContent = line.time[row].toFixed(3) + " s";
    for (const text of document.querySelectorAll("." + picture.id + "-factor")) text.textContent = String(factor);
    return Plotly.restyle(part(""), {x: [moved(0)], y: [moved(1)], z: [moved(2)]}, [line.trace]);
  };
  const step = (from, begun) => {
    const row = (from + Math.floor((performance.now() - begun) / 1000 / span * (last + 1))) % (last + 1);
    part("-time").value = row;
    picture.set().then(() => { if (ahead) ahead = setTimeout(() => step(from, begun), 30); });
  };
  part("-play").addEventListener("click", () => {
    const playing = ahead !== null;
    clearTimeout(ahead);
    ahead = playing ? null : 1;
    if (!playing) step(Number(part("-time").value), performance.now());
    part("-play").textContent = playing ? "Play" : "Pause";
  });
  for (const end of ["-time", "-slider"]) part(end).addEventListener("input", picture.set);
};

for (const picture of data) if (picture.magnified.length) magnifier(picture);
for (const picture of data) if (picture.moving) player(picture);
draw(Plotly.newPlot);
for (const folded of document.querySelectorAll("details")) {
  folded.addEventListener("toggle", () => {
    if (!folded.open) return;
    for (const picture of data) {
      const element = document.getElementById(picture.id);
      if (folded.contains(element)) paint(picture, Plotly.react);
    }
  });
}
let wide = window.innerWidth;
const again = () => draw(Plotly.react);
night.addEventListener("change", again);
window.addEventListener("resize", () => {
  if ((wide < 620) !== (window.innerWidth < 620)) again();
  wide = window.innerWidth;
});
window.addEventListener("beforeprint", () => { printing = true; document.body.style.width = "180mm"; again(); });
window.addEventListener("afterprint", () => { printing = false; document.body.style.width = ""; again(); });
"""
)

UNPACK = (
    "const draw = () => {"
    + SCRIPT
    + """};
const unpack = async () => {
  const text = atob(document.getElementById("library").textContent);
  const packed = new Blob([Uint8Array.from(text, (one) => one.charCodeAt(0))]);
  const code = await new Response(packed.stream().pipeThrough(new DecompressionStream("gzip"))).text();
  (0, eval)(code);
  draw();
};
unpack().catch((fault) => {
  const note = document.createElement("p");
  note.className = "warning";
  note.textContent = "The pictures of this report need a browser of 2023 or later (" + fault + "); the tables do not.";
  document.querySelector("header").append(note);
});
"""
)
"""Script that unpacks the plotting library first; if that fails, the page still shows its tables and the reason."""
