"""Style sheet and script of a report page, embedded in the page so that it opens offline."""

from __future__ import annotations

from flexros.report.theme import FONT, GRID, INK, MUTED

STYLE = f"""
:root {{ color-scheme: light; }}
* {{ box-sizing: border-box; }}
body {{ margin: 0; background: #fff; color: {INK}; font: 16px/1.55 {FONT}; }}
main {{ max-width: 1080px; margin: 0 auto; padding: 40px 32px 72px; }}
header p {{ margin: 0; color: {MUTED}; font-size: 14px; }}
h1 {{ font-size: 32px; line-height: 1.2; font-weight: 650; margin: 4px 0 6px; letter-spacing: -0.01em; }}
h2 {{ font-size: 21px; font-weight: 650; margin: 52px 0 12px; padding-top: 20px; border-top: 1px solid #d5dae0; }}
h3 {{ font-size: 17px; font-weight: 650; margin: 34px 0 8px; }}
p {{ max-width: 78ch; margin: 10px 0; }}
p.lead {{ font-size: 20px; line-height: 1.45; max-width: 68ch; margin: 20px 0 24px; }}
p.note {{ color: {MUTED}; font-size: 14px; }}
p.for::before {{ content: "+"; color: #0072b2; font-weight: 700; margin-right: 8px; }}
p.against::before {{ content: "\\2212"; color: #b35900; font-weight: 700; margin-right: 8px; }}
p.for, p.against {{ margin: 4px 0; }}
.listing {{ position: relative; }}
.listing pre {{ background: #f6f8fa; border-radius: 6px; padding: 14px 16px; overflow-x: auto; font-size: 13.5px;
  line-height: 1.5; margin: 0; }}
.listing button {{ position: absolute; right: 8px; top: 8px; font: inherit; font-size: 13px; background: #fff;
  border: 1px solid #d5dae0; border-radius: 4px; padding: 2px 10px; cursor: pointer; }}
p.warning {{ border-left: 3px solid #b35900; padding: 2px 0 2px 12px; }}
.tiles {{ display: grid; grid-template-columns: repeat(auto-fit, minmax(210px, 1fr)); gap: 12px; margin: 24px 0 28px; }}
.tile {{ border: 1px solid #d5dae0; border-radius: 6px; padding: 14px 16px 12px; }}
.tile .name {{ color: {MUTED}; font-size: 13px; }}
.tile .value {{ font-size: 28px; font-weight: 600; line-height: 1.25; font-variant-numeric: tabular-nums; }}
.tile .value small {{ font-size: 15px; font-weight: 400; color: {MUTED}; margin-left: 4px; }}
.tile .below {{ color: {MUTED}; font-size: 13px; font-variant-numeric: tabular-nums; }}
figure {{ margin: 20px 0 28px; }}
figcaption {{ color: {MUTED}; font-size: 14px; max-width: 90ch; margin: 6px 0; }}
figcaption b {{ color: {INK}; font-weight: 600; }}
.scroll {{ overflow-x: auto; }}
table {{ border-collapse: collapse; font-size: 14px; font-variant-numeric: tabular-nums; min-width: 60%; }}
th, td {{ padding: 5px 14px 5px 0; text-align: right; border-bottom: 1px solid {GRID}; vertical-align: top; }}
th {{ font-weight: 600; border-bottom: 1.5px solid {INK}; vertical-align: bottom; }}
th.left, td.left {{ text-align: left; overflow-wrap: anywhere; min-width: 6.8em; }}
td.group {{ text-align: left; font-weight: 600; padding-top: 14px; }}
.picture {{ width: 100%; }}
.modebar-container {{ top: auto !important; bottom: 26px; }}
.magnifier {{ display: flex; align-items: center; gap: 10px; font-size: 14px; }}
.magnifier input {{ width: 260px; accent-color: #0072b2; }}
.magnifier output {{ font-variant-numeric: tabular-nums; font-weight: 600; min-width: 5ch; }}
noscript p {{ border: 1px solid #b35900; padding: 10px 14px; }}
@media print {{
  @page {{ size: A4; margin: 14mm; }}
  body {{ font-size: 10.5pt; }}
  main {{ max-width: none; padding: 0; }}
  h2, h3 {{ break-after: avoid; }}
  h2 {{ margin-top: 28px; }}
  figure, .tile, tr {{ break-inside: avoid; }}
  .tiles {{ grid-template-columns: repeat(4, 1fr); }}
  .magnifier, .modebar, .listing button {{ display: none !important; }}
}}
"""

SCRIPT = """
"use strict";
const data = JSON.parse(document.getElementById("pictures").textContent);
const tools = ["zoom2d", "pan2d", "resetScale2d", "toImage"];
const options = {responsive: true, displaylogo: false, modeBarButtons: [tools]};
for (const picture of data) {
  const element = document.getElementById(picture.id);
  Plotly.newPlot(element, picture.figure.data, picture.figure.layout, options);
  if (!picture.magnified.length) continue;
  const slider = document.getElementById(picture.id + "-slider");
  slider.addEventListener("input", () => {
    const factor = picture.factors[Number(slider.value)];
    const moved = (k) => picture.magnified.map((c) => c.base.map((p, i) => p[k] + factor * c.deviation[i][k]));
    Plotly.restyle(element, {x: moved(0), y: moved(1)}, picture.magnified.map((c) => c.trace));
    for (const text of document.querySelectorAll("." + picture.id + "-factor")) text.textContent = String(factor);
  });
}
const fit = () => { for (const picture of data) Plotly.Plots.resize(document.getElementById(picture.id)); };
window.addEventListener("beforeprint", () => { document.body.style.width = "180mm"; fit(); });
window.addEventListener("afterprint", () => { document.body.style.width = ""; fit(); });
"""

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
