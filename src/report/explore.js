// Makes the figures of a page zoom and tell their values (uPlot), and its tables sort. Without scripts the drawings stay.
"use strict";
(() => {
  const GAP = 65535, ABSENT = 65534;

  const view = text => {
    const raw = atob(text), bytes = new Uint8Array(raw.length);
    for (let k = 0; k < raw.length; k++) bytes[k] = raw.charCodeAt(k);
    return new DataView(bytes.buffer);
  };
  const times = text => {
    const data = view(text);
    return Array.from({ length: data.byteLength / 4 }, (_, k) => data.getFloat32(4 * k, true));
  };
  const values = series => {
    const data = view(series.v);
    return Array.from({ length: data.byteLength / 2 }, (_, k) => {
      const q = data.getUint16(2 * k, true);
      return q === GAP ? null : q === ABSENT ? undefined : series.lo + q * series.step;
    });
  };
  // The decimals that are kept of a value (below 0: tens, hundreds), and five digits of what is no whole number.
  const said = (value, decimals = 100) => {
    if (value == null) return "\u2013";
    const unit = 10 ** -Math.min(0, decimals);
    const kept = unit > 1 ? unit * Math.round(value / unit) : Number(value.toFixed(decimals));
    return String(Number.isInteger(kept) ? kept : Number(kept.toPrecision(5))).replace("-", "\u2212");
  };
  const faded = (colour, share) => {
    const hex = colour.slice(1), full = hex.length === 3 ? [...hex].map(c => c + c).join("") : hex;
    return "#" + full + Math.round(255 * share).toString(16).padStart(2, "0");
  };

  const series = (one, colour) => {
    const stroke = colour("--c" + one.c);
    const out = { label: one.n, class: one.n ? undefined : "nameless", stroke, width: 1.6, value: (u, v) => said(v, one.decimals), points: { show: false } };
    if (one.k === "dash") out.dash = [6, 4];
    if (one.k === "lower" || one.k === "upper") Object.assign(out, { stroke: "transparent", width: 0 });
    if (one.k === "faint") Object.assign(out, { stroke: faded(stroke, 0.3) });
    if (one.k.startsWith("broad")) Object.assign(out, { stroke: faded(stroke, 0.5), width: 5 });
    if (one.k.endsWith("step") || one.k === "faint") out.paths = uPlot.paths.stepped({ align: 1 });
    if (one.k === "dots") Object.assign(out, { paths: () => null, points: { show: true, size: 5, fill: stroke, width: 0 } });
    return out;
  };

  // Room for the numbers of a y axis: a digit is 7 pixels wide.
  const beside = (u, texts) => Math.max(64, 20 + 7 * Math.max(0, ...(texts ?? []).map(text => text.length)));

  // Numbers of the shaded intervals, over the curves; one that would run into a stronger one's is left out, as in the drawing.
  const labels = (u, bands, ink, paper) => {
    u.ctx.save();
    Object.assign(u.ctx, { fillStyle: ink, strokeStyle: paper, lineWidth: 3 * devicePixelRatio, textAlign: "center" });
    const taken = [];
    for (const [from, to, , label] of [...bands].sort((a, b) => b[2] - a[2])) {
      const left = Math.max(u.valToPos(from, "x", true), u.bbox.left);
      const right = Math.min(Math.max(u.valToPos(to, "x", true), left + 2), u.bbox.left + u.bbox.width);
      const half = u.ctx.measureText(label).width / 2 + 2, middle = (left + right) / 2;
      if (right <= left || taken.some(([at, wide]) => Math.abs(at - middle) < wide + half)) continue;
      u.ctx.strokeText(label, middle, u.bbox.top + 12 * devicePixelRatio);
      u.ctx.fillText(label, middle, u.bbox.top + 12 * devicePixelRatio);
      taken.push([middle, half]);
    }
    u.ctx.restore();
  };

  // One panel; `all` are the panels of its figure, which share their time axis, cursor and names.
  const panel = (box, spec, part, x, key, all, isLast) => {
    const colour = name => getComputedStyle(box).getPropertyValue(name).trim();
    const ink = colour("--ink"), grid = { stroke: colour("--grid"), width: 1 };
    // The ends that are drawn; the scale of x itself is set after the range of y is asked for.
    const isWhole = u => u.series[0].min == null || u.series[0].min <= x[0] && u.series[0].max >= x[x.length - 1];
    const plot = new uPlot({
      width: box.clientWidth,
      height: part.h,
      scales: {
        x: { time: false },
        y: { range: (u, lo, hi) => (lo == null || isWhole(u) ? part.range : uPlot.rangeNum(lo, hi, 0.1, true)) },
      },
      axes: [
        { stroke: ink, grid, ticks: grid, size: 30, ...(isLast && { label: spec.x, labelSize: 18, labelGap: 0, labelFont: "12px system-ui" }) },
        { stroke: ink, grid, ticks: grid, label: part.y, labelSize: 18, labelGap: 0, labelFont: "12px system-ui", size: beside, space: (u, side, lo, hi, height) => (height < 110 ? 14 : 18) },
      ],
      cursor: { sync: { key, setSeries: false }, drag: { x: true, y: false, dist: 4 } },
      series: [{ label: spec.x, value: (u, v) => said(v) }, ...part.s.map(one => series(one, colour))],
      bands: part.s.flatMap((one, k) => one.k === "upper" ? [{ series: [k + 1, k], fill: faded(colour("--c" + one.c), 0.2) }] : []),
      hooks: {
        drawClear: [u => {
          u.ctx.save();
          Object.assign(u.ctx, { strokeStyle: ink, globalAlpha: 0.45 });
          u.ctx.setLineDash([2, 4]);
          u.ctx.beginPath();
          for (const start of part.starts) {
            const at = Math.round(u.valToPos(start, "x", true));
            if (at < u.bbox.left || at > u.bbox.left + u.bbox.width) continue;
            u.ctx.moveTo(at, u.bbox.top);
            u.ctx.lineTo(at, u.bbox.top + u.bbox.height);
          }
          u.ctx.stroke();
          u.ctx.restore();
        }, u => part.bands.forEach(([from, to, strength]) => {
          const [a, b] = [u.valToPos(from, "x", true), u.valToPos(to, "x", true)];
          const left = Math.max(a, u.bbox.left), right = Math.min(Math.max(b, a + 2), u.bbox.left + u.bbox.width);
          if (right <= left) return;
          u.ctx.save();
          u.ctx.fillStyle = faded(colour("--c1"), strength);
          u.ctx.fillRect(left, u.bbox.top, right - left, u.bbox.height);
          u.ctx.restore();
        })],
        draw: [u => labels(u, part.bands, ink, colour("--paper")), u => part.marks.forEach(([y]) => {
          const at = u.valToPos(y, "y", true);
          if (at < u.bbox.top || at > u.bbox.top + u.bbox.height) return;
          u.ctx.save();
          u.ctx.strokeStyle = ink;
          u.ctx.globalAlpha = 0.5;
          u.ctx.setLineDash([4, 6]);
          u.ctx.beginPath();
          u.ctx.moveTo(u.bbox.left, at);
          u.ctx.lineTo(u.bbox.left + u.bbox.width, at);
          u.ctx.stroke();
          u.ctx.restore();
        })],
        setSeries: [(u, index, change) => {
          if (index == null || change.show == null || !u.series[index].label) return;
          const label = u.series[index].label;
          for (const other of all) {
            const at = other.series.findIndex((s, k) => k > 0 && s.label === label);
            if (at > 0 && other.series[at].show !== change.show) other.setSeries(at, { show: change.show });
          }
        }],
      },
    }, [x, ...part.s.map(values)], box);
    for (const name of box.querySelectorAll(".u-legend .u-series:not(:first-child) th")) {
      name.tabIndex = 0;
      name.setAttribute("role", "button");
      name.addEventListener("keydown", event => event.key === "Enter" && name.click());
    }
    return plot;
  };

  // Buttons for those without a mouse.
  const buttons = (box, all, xs, isFirst) => {
    const bar = document.createElement("div");
    bar.className = "bar";
    const add = (name, title, change) => {
      const button = document.createElement("button");
      button.type = "button";
      button.textContent = name;
      button.title = title;
      button.addEventListener("click", () => {
        const [from, to] = [Math.min(...xs.map(x => x[0])), Math.max(...xs.map(x => x[x.length - 1]))];
        const { min, max } = all[0].scales.x;
        let [lo, hi] = change(min, max, from, to);
        [lo, hi] = [Math.max(lo, from), Math.min(hi, to)];
        if (hi > lo) for (const plot of all) plot.setScale("x", { min: lo, max: hi });
      });
      bar.append(button);
    };
    add("+", "zoom in", (lo, hi) => [lo + (hi - lo) / 4, hi - (hi - lo) / 4]);
    add("\u2212", "zoom out", (lo, hi) => [lo - (hi - lo) / 2, hi + (hi - lo) / 2]);
    add("\u2190", "back", (lo, hi, from) => { const by = Math.min((hi - lo) / 2, lo - from); return [lo - by, hi - by]; });
    add("\u2192", "on", (lo, hi, from, to) => { const by = Math.min((hi - lo) / 2, to - hi); return [lo + by, hi + by]; });
    add("whole", "the whole axis", (lo, hi, from, to) => [from, to]);
    if (isFirst) {
      const hint = document.createElement("span");
      hint.textContent = "Drag to zoom, double-click for the whole. A click on a name hides its curve.";
      bar.append(hint);
    }
    box.append(bar);
  };

  let figures = 0;
  const show = figure => {
    const spec = JSON.parse(figure.dataset.plot), key = "figure" + figures++;
    const box = document.createElement("div");
    let all = [];
    const draw = () => {
      all.forEach(plot => plot.destroy());
      all = [];
      box.replaceChildren();
      const title = document.createElement("p");
      title.className = "title";
      title.textContent = spec.title;
      if (spec.title) box.append(title);
      const xs = [];
      for (const part of spec.panels) {
        xs.push(typeof part.t === "number" ? xs[part.t] : times(part.t));
        const name = document.createElement("p"), place = document.createElement("div");
        name.className = "axis";
        name.textContent = part.said ?? "";
        box.append(name, place);
        const isLast = part === spec.panels[spec.panels.length - 1];
        if (xs[xs.length - 1].length > 0) all.push(panel(place, spec, part, xs[xs.length - 1], key, all, isLast));
      }
      if (all.length > 0) buttons(box, all, xs.filter(x => x.length > 0), key === "figure0");
    };
    box.className = "plot live";
    figure.prepend(box);
    figure.classList.add("explored");
    try {
      draw();
    } catch (error) {
      box.remove();
      figure.classList.remove("explored");
      throw error;
    }
    let width = box.clientWidth;
    new ResizeObserver(() => {
      if (box.clientWidth !== width && box.clientWidth > 0) {
        width = box.clientWidth;
        all.forEach(plot => plot.setSize({ width, height: plot.height }));
      }
    }).observe(box);
    matchMedia("(prefers-color-scheme: dark)").addEventListener("change", draw);
  };

  const number = text => {
    const raised = "\u2070\u00b9\u00b2\u00b3\u2074\u2075\u2076\u2077\u2078\u2079";
    const found = text.replaceAll("\u2212", "-").match(/-?\d+(\.\d+)?/);
    if (!found) return null;
    const power = text.match(/\u00d710(\u207b?)([\u2070-\u2079\u00b9\u00b2\u00b3]+)/);
    const digits = power ? Number([...power[2]].map(c => raised.indexOf(c)).join("")) : 0;
    const beyond = text.startsWith("<") ? -1e-9 : text.startsWith(">") ? 1e-9 : 0;
    return Number(found[0]) * 10 ** (power && power[1] ? -digits : digits) + beyond;
  };
  const sortable = table => {
    const heads = [...table.tHead.rows[0].cells], body = table.tBodies[0];
    heads.forEach((head, column) => {
      head.tabIndex = 0;
      const sort = () => {
        const rows = [...body.rows], cell = row => row.cells[column].textContent.trim();
        const isNumeric = rows.every(row => number(cell(row)) !== null || cell(row) === "\u2013");
        // Numbers begin with the largest, words with the first letter.
        const first = isNumeric ? "descending" : "ascending", second = isNumeric ? "ascending" : "descending";
        const order = head.getAttribute("aria-sort") === first ? second : first;
        const sign = order === "ascending" ? 1 : -1;
        rows.sort((a, b) => sign * (isNumeric
          ? (number(cell(a)) ?? -Infinity) - (number(cell(b)) ?? -Infinity) || 0
          : cell(a).localeCompare(cell(b))));
        heads.forEach(other => other.removeAttribute("aria-sort"));
        head.setAttribute("aria-sort", order);
        body.append(...rows);
      };
      head.addEventListener("click", sort);
      head.addEventListener("keydown", event => event.key === "Enter" && sort());
    });
  };

  // Says where a table has more columns than are seen.
  const hint = box => box.classList.toggle("scrolls", box.scrollWidth > box.clientWidth + 1);
  const tables = new ResizeObserver(boxes => boxes.forEach(one => hint(one.target)));
  document.querySelectorAll(".wide").forEach(box => {
    box.tabIndex = 0;
    tables.observe(box);
  });

  document.querySelectorAll("figure[data-plot]").forEach(show);
  document.querySelectorAll("table.sortable").forEach(sortable);
})();
