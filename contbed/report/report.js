"use strict";
// Unpacks plotly and the charts, draws them, and lets the sliders choose the time.
async function unpacked(id) {
  const bytes = Uint8Array.from(atob(document.getElementById(id).textContent), (c) => c.charCodeAt(0));
  const stream = new Blob([bytes]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Response(stream).text();
}

// frames of a field: numbers of 16 bits between the lowest and the highest value, 65535 where there is none
function decoded(packed) {
  const bytes = Uint8Array.from(atob(packed.data), (c) => c.charCodeAt(0));
  const view = new DataView(bytes.buffer);
  const [times, ny, nx] = packed.shape;
  const scale = (packed.high - packed.low) / 65534;
  const frames = [];
  let k = 0;
  for (let t = 0; t < times; t++) {
    const rows = [];
    for (let j = 0; j < ny; j++) {
      const row = new Array(nx);
      for (let i = 0; i < nx; i++, k += 2) {
        const value = view.getUint16(k, true);
        row[i] = value === 65535 ? null : packed.low + value * scale;
      }
      rows.push(row);
    }
    frames.push(rows);
  }
  return frames;
}

function shown(chart, k) {
  const div = document.getElementById("chart" + chart.number);
  if (chart.kind === "field") return Plotly.restyle(div, { z: [chart.values[k]] });
  if (chart.kind === "cloud") {
    const [x, y, colour, size] = chart.points[k];
    return Plotly.restyle(div, { x: [x], y: [y], "marker.color": [colour], "marker.size": [size] });
  }
  return Plotly.restyle(div, { x: chart.lines[k].map((l) => l[0]), y: chart.lines[k].map((l) => l[1]) });
}

// whether a value lies in what is chosen on its axis: nothing, one interval or several
function inside(range, value) {
  if (!range || !range.length) return true;
  const intervals = Array.isArray(range[0]) ? range : [range];
  return intervals.some(([low, high]) => value >= low && value <= high);
}

// what is chosen on the parallel axes is marked in the panels, and the other way; the last choice counts
function linked(parallel, matrix) {
  const axes = document.getElementById("chart" + parallel.number);
  const panels = document.getElementById("chart" + matrix.number);
  const colours = [...parallel.data[0].line.color];
  const grey = parallel.data[0].line.cmin;
  const dimensions = () => axes.data[0].dimensions;
  const coloured = (values, open) => {
    const update = { "line.color": [values] };
    if (open) dimensions().forEach((_, k) => { update[`dimensions[${k}].constraintrange`] = null; });
    return Plotly.restyle(axes, update);
  };
  axes.on("plotly_restyle", ([update]) => {
    if ("line.color" in update || !Object.keys(update).some((key) => key.includes("constraintrange"))) return;
    const free = dimensions().every((d) => !d.constraintrange || !d.constraintrange.length);
    const rows = [...colours.keys()].filter((k) => dimensions().every((d) => inside(d.constraintrange, d.values[k])));
    Plotly.restyle(panels, { selectedpoints: [free ? null : rows] });
    Plotly.relayout(panels, { selections: [] });
    if (axes.data[0].line.color.some((value, k) => value !== colours[k])) coloured(colours, false);
  });
  panels.on("plotly_selected", (event) => {
    if (!event || !event.points) return;
    const rows = new Set(event.points.map((point) => point.pointNumber));
    coloured(colours.map((value, k) => (rows.has(k) ? value : grey)), true);
  });
  panels.on("plotly_deselect", () => coloured(colours, true));
}

const axis = { gridcolor: "#e4e8ec", zerolinecolor: "#c8ced4", exponentformat: "power", automargin: true };

async function drawn() {
  const text = await unpacked("charts");
  const charts = JSON.parse(text);
  if (charts.length) {
    const script = document.createElement("script");
    script.textContent = await unpacked("plotly");
    document.head.appendChild(script);
  }
  for (const [number, chart] of charts.entries()) {
    chart.number = number;
    if (chart.kind === "field") {
      chart.values = decoded(chart.frames);
      chart.data[0].z = chart.values[chart.values.length - 1];
      chart.data[0].zmin = chart.frames.low;
      chart.data[0].zmax = chart.frames.high;
    }
    const layout = {
      height: chart.height || 340, margin: { l: 70, r: 40, t: 40, b: 52 }, showlegend: chart.kind === "curves" && chart.data.length > 1,
      legend: { orientation: "h", y: 1.02, yanchor: "bottom", x: 0 }, paper_bgcolor: "#fff", plot_bgcolor: "#fff", font: { size: 12 },
      modebar: { orientation: "v" }, template: { layout: { xaxis: axis, yaxis: axis } }, ...chart.layout,
    };
    if (chart.kind === "field" || chart.kind === "cloud") layout.margin.t = 14;
    if (chart.wide) layout.margin = { l: 90, r: 60, t: 70, b: 70 };
    await Plotly.newPlot("chart" + number, chart.data, layout, { responsive: true, displaylogo: false });
  }
  for (const parallel of charts.filter((chart) => chart.kind === "parallel")) {
    const next = charts[parallel.number + 1];
    if (next && next.kind === "matrix") linked(parallel, next);
  }
  for (const slider of document.querySelectorAll("input[data-chart]")) {
    slider.addEventListener("input", () => {
      const chart = charts[Number(slider.dataset.chart)];
      const k = Number(slider.value);
      slider.parentElement.querySelector("output").textContent = chart.times[k].toPrecision(5).replace(/\.?0+$/, "") + " s";
      shown(chart, k);
    });
  }
  document.body.dataset.ready = String(charts.length);
}

drawn();
