// Pictures that answer: hover and arrow keys read values, dragging and + zoom, the legend hides.
(() => {
  "use strict";
  const FULL = 10000;
  const charts = [];

  const make = (name, look, words) => {
    const made = document.createElement(name);
    if (look) made.className = look;
    if (words !== undefined) made.textContent = words;
    return made;
  };
  const minus = (text) => text.replace(/-/g, "\u2212");
  const raised = (text) => [...text].map((c) => ({ "-": "\u207b" }[c] || "\u2070\u00b9\u00b2\u00b3\u2074\u2075\u2076\u2077\u2078\u2079"[+c])).join("");
  const told = (value, digits = 5) => {
    if (value === null || !Number.isFinite(value)) return "\u2013";
    const [mantissa, power] = value.toExponential(digits - 1).split("e");
    if (value === 0) return "0";
    if (Math.abs(+power) < 5 + (power < 0 ? -1 : 1)) return minus(String(+value.toPrecision(digits)));
    return `${minus(String(+mantissa))}\u00d710${raised(String(+power))}`;
  };

  const named = (label, value) => {
    const cut = label.lastIndexOf(", ");
    return cut < 0 ? `${label} ${value}` : `${label.slice(0, cut)} ${value} ${label.slice(cut + 2)}`;
  };

  // The axes: from units of the drawing to values, and the numbers beside them.
  const axis = (text) => {
    const [low, high, log] = text.split(" ").map(Number);
    return {
      log,
      value: (u) => (log ? low * (high / low) ** (u / FULL) : low + ((high - low) * u) / FULL),
      unit: (v) => (log ? (FULL * Math.log(v / low)) / Math.log(high / low) : (FULL * (v - low)) / (high - low)),
    };
  };
  const roundSteps = (low, high, most) => {
    const rough = (high - low) / most, power = 10 ** Math.floor(Math.log10(rough));
    const step = [1, 2, 5, 10].map((m) => m * power).find((s) => s >= rough * (1 - 1e-9));
    const first = Math.ceil(low / step - 1e-9), last = Math.floor(high / step + 1e-9);
    const numbers = [];
    for (let k = first; k <= last; k++) numbers.push(k * step);
    return { numbers, step };
  };
  const ticks = (along, from, to, most) => {
    const low = along.value(from), high = along.value(to);
    if (along.log && high / low > 100) {
      const ends = [Math.log10(low), Math.log10(high)], step = Math.max(1, Math.ceil((ends[1] - ends[0]) / most));
      const found = [];
      for (let p = Math.ceil(ends[0] / step - 1e-9) * step; p <= ends[1] + 1e-9; p += step) found.push([10 ** p, `10${raised(String(p))}`]);
      return found;
    }
    const { numbers, step } = roundSteps(low, high, most);
    const largest = Math.max(...numbers.map(Math.abs), 0), power = Math.floor(Math.log10(largest || 1));
    const scale = power > 5 || power < -3 ? 10 ** power : 1;
    const digits = Math.min(12, Math.max(0, -Math.floor(Math.log10(step / scale) + 1e-9)));
    return numbers.filter((v) => !along.log || v > 0).map((v) => {
      const text = (v / scale).toFixed(digits);
      return [v, +text === 0 ? "0" : minus(text) + (scale === 1 ? "" : `\u00d710${raised(String(power))}`)];
    });
  };

  // The points of a path, in units of the drawing.
  const pointsOf = (path) => {
    const numbers = (path.getAttribute("d").replace(/h\.1/g, " ").match(/-?\d+(\.\d+)?/g) || []).map(Number);
    const count = numbers.length / 2, x = new Float64Array(count), y = new Float64Array(count);
    for (let i = 0; i < count; i++) { x[i] = numbers[2 * i]; y[i] = numbers[2 * i + 1]; }
    return { x, y };
  };
  const nearest = (x, at, count) => {
    let best = 0, least = Infinity;
    for (let i = 0; i < count; i++) { const d = Math.abs(x[i] - at); if (d < least) { least = d; best = i; } }
    return best;
  };

  const chart = (figure) => {
    const area = figure.querySelector(".area"), svg = area.querySelector("svg");
    const x = axis(figure.dataset.x), y = axis(figure.dataset.y);
    const grid = svg.querySelector(".grid"), plot = figure.querySelector(".plot");
    const cells = figure.dataset.cells ? JSON.parse(figure.dataset.cells) : null;
    const first = { x: figure.querySelector(".xticks").innerHTML, y: figure.querySelector(".yticks").innerHTML, grid: grid.getAttribute("d") };
    const shapes = [...svg.querySelectorAll("path[data-label]")].map((path) => ({
      path, label: path.dataset.label, band: path.classList.contains("band"), limit: path.classList.contains("limit"), points: null,
    }));
    const pts = (shape) => (shape.points = shape.points || pointsOf(shape.path));
    let view = [0, FULL], at = null, from = null;
    figure.classList.add("live");

    const cross = make("div", "cross"), readout = make("div", "readout"), choice = make("div", "choice");
    const live = make("p", "hidden-words");
    live.setAttribute("aria-live", "polite");
    for (const each of [cross, readout, choice]) { each.hidden = true; area.append(each); }
    figure.append(live);

    const hide = () => { cross.hidden = readout.hidden = true; at = null; };
    const rows = (u, v) => {
      if (cells) {
        const i = nearest(cells.x, u, cells.x.length), j = nearest(cells.y, v, cells.y.length);
        return [[figure.dataset.xname, told(x.value(cells.x[i]))], [figure.dataset.yname, told(y.value(FULL - cells.y[j]))], [figure.dataset.zname, told(cells.z[i][j], 4)]];
      }
      const found = [];
      for (const shape of shapes) {
        if (shape.path.classList.contains("hidden") || shape.limit) continue;
        const { x: xs, y: ys } = pts(shape), count = shape.band ? xs.length / 2 : xs.length;
        if (!count) continue;
        const i = nearest(xs, u, count);
        const value = told(y.value(FULL - ys[i]));
        if (!shape.band) { if (Math.abs(xs[i] - u) < (view[1] - view[0]) / 12) found.push([shape.label, value]); }
        else found.push([shape.label, `${told(y.value(FULL - ys[xs.length - 1 - i]), 4)} to ${told(y.value(FULL - ys[i]), 4)}`]);
      }
      return found;
    };
    const show = (u, v, aloud) => {
      at = u;
      const share = (u - view[0]) / (view[1] - view[0]);
      cross.hidden = readout.hidden = false;
      cross.style.left = `${100 * share}%`;
      readout.style.left = share < 0.5 ? `calc(${100 * share}% + 14px)` : "auto";
      readout.style.right = share < 0.5 ? "auto" : `calc(${100 * (1 - share)}% + 14px)`;
      const lines = rows(u, v);
      readout.replaceChildren();
      if (!cells) readout.append(make("b", "", named(figure.dataset.xname, told(x.value(u)))));
      for (const [name, value] of lines) {
        const line = make("div");
        line.append(make("span", "", name), make("b", "", value));
        readout.append(line);
      }
      if (aloud) live.textContent = [cells ? "" : named(figure.dataset.xname, told(x.value(u))), ...lines.map((each) => each.join(" "))].join("; ");
    };

    const place = (box, side, numbers, along, span) => {
      box.replaceChildren();
      for (const [value, text] of numbers) {
        const span_ = make("span", "", text), u = along.unit(value);
        span_.style[side] = `${(100 * (u - span[0])) / (span[1] - span[0])}%`;
        box.append(span_);
      }
    };
    const zoom = (low, high) => {
      const whole = high - low >= FULL * 0.999;
      low = Math.max(0, low); high = Math.min(FULL, high);
      view = whole ? [0, FULL] : [low, high];
      figure.classList.toggle("zoomed", !whole);
      hide();
      let up = [0, FULL];
      if (!whole) {
        let least = Infinity, most = -Infinity;
        for (const shape of shapes) {
          if (shape.path.classList.contains("hidden") || shape.limit) continue;
          const { x: xs, y: ys } = pts(shape);
          for (let i = 0; i < xs.length; i++) if (xs[i] >= low && xs[i] <= high) { least = Math.min(least, ys[i]); most = Math.max(most, ys[i]); }
        }
        if (most > least) { const room = 0.06 * (most - least); up = [least - room, most + room]; }
      }
      svg.setAttribute("viewBox", `${view[0]} ${up[0]} ${view[1] - view[0]} ${up[1] - up[0]}`);
      const across = figure.querySelector(".xticks"), beside = figure.querySelector(".yticks");
      if (whole) { across.innerHTML = first.x; beside.innerHTML = first.y; grid.setAttribute("d", first.grid); return; }
      const xt = ticks(x, view[0], view[1], 6), yt = ticks(y, FULL - up[1], FULL - up[0], 5);
      place(across, "left", xt, x, view);
      place(beside, "bottom", yt, y, [FULL - up[1], FULL - up[0]]);
      plot.style.setProperty("--w", Math.max(3, ...yt.map(([, text]) => text.length)));
      grid.setAttribute("d", xt.map(([v]) => `M${x.unit(v)} ${up[0]}V${up[1]}`).join("") + yt.map(([v]) => `M${view[0]} ${FULL - y.unit(v)}H${view[1]}`).join(""));
    };
    const zoomAll = (low, high) => {
      const name = figure.dataset.joined;
      if (!name) return zoom(low, high);
      const ends = [x.value(low), x.value(high)], whole = high - low >= FULL * 0.999;
      for (const other of charts) if (other.figure.dataset.joined === name) whole ? other.zoom(0, FULL) : other.zoom(other.x.unit(ends[0]), other.x.unit(ends[1]));
    };
    const by = (factor) => {
      const center = at === null ? (view[0] + view[1]) / 2 : at, half = ((view[1] - view[0]) / 2) * factor;
      const low = Math.max(0, Math.min(center - half, FULL - 2 * half));
      zoomAll(low, Math.min(FULL, low + 2 * half));
    };

    const unitAt = (event) => {
      const box = area.getBoundingClientRect();
      const share = Math.min(1, Math.max(0, (event.clientX - box.left) / box.width));
      return [view[0] + share * (view[1] - view[0]), (FULL * (event.clientY - box.top)) / box.height];
    };
    area.addEventListener("pointermove", (event) => {
      if (event.target.closest(".tools")) return;
      const [u, v] = unitAt(event);
      show(u, v);
      if (from === null) return;
      choice.hidden = Math.abs(u - from) < (view[1] - view[0]) / 100;
      const ends = [Math.min(u, from), Math.max(u, from)].map((e) => (100 * (e - view[0])) / (view[1] - view[0]));
      choice.style.left = `${ends[0]}%`;
      choice.style.width = `${ends[1] - ends[0]}%`;
    });
    area.addEventListener("pointerleave", () => { if (from === null) hide(); });
    if (!cells) {
      area.addEventListener("pointerdown", (event) => {
        if (event.pointerType !== "mouse" || event.button || event.target.closest(".tools")) return;
        from = unitAt(event)[0];
        area.setPointerCapture(event.pointerId);
      });
      area.addEventListener("pointerup", (event) => {
        if (from === null) return;
        const to = unitAt(event)[0], wide = Math.abs(to - from) > (view[1] - view[0]) / 60;
        const ends = [Math.min(from, to), Math.max(from, to)];
        from = null; choice.hidden = true;
        if (wide) zoomAll(...ends);
      });
      area.addEventListener("dblclick", () => zoomAll(0, FULL));
      const tools = make("div", "tools");
      for (const [text, words, act] of [["+", "Zoom in", () => by(0.5)], ["\u2212", "Zoom out", () => by(2)], ["all", "Show all", () => zoomAll(0, FULL)]]) {
        const button = make("button", "", text);
        button.type = "button";
        button.setAttribute("aria-label", `${words}: ${figure.querySelector("h3").textContent}`);
        button.addEventListener("click", act);
        tools.append(button);
      }
      plot.append(tools);
    }
    area.addEventListener("keydown", (event) => {
      const step = (view[1] - view[0]) / 50, v = FULL / 2;
      const now = at === null ? (view[0] + view[1]) / 2 : at;
      const inside = (u) => Math.min(view[1], Math.max(view[0], u));
      const acts = {
        ArrowLeft: () => show(inside(now - step), v, true), ArrowRight: () => show(inside(now + step), v, true),
        Home: () => show(view[0], v, true), End: () => show(view[1], v, true),
        "+": () => by(0.5), "=": () => by(0.5), "-": () => by(2), 0: () => zoomAll(0, FULL),
        Escape: () => { hide(); zoomAll(0, FULL); },
      };
      if (!acts[event.key] || (cells && !event.key.startsWith("Arrow")) || event.ctrlKey || event.metaKey) return;
      event.preventDefault();
      acts[event.key]();
    });
    area.addEventListener("blur", hide);

    figure.querySelectorAll(".legend li").forEach((item, i) => {
      const shape = shapes[i], button = make("button");
      if (!shape || cells) return;
      button.type = "button";
      button.setAttribute("aria-pressed", "true");
      button.append(...item.childNodes);
      item.append(button);
      button.addEventListener("click", () => {
        const hidden = shape.path.classList.toggle("hidden");
        button.setAttribute("aria-pressed", String(!hidden));
        if (view[1] - view[0] < FULL) zoom(...view);
      });
    });
    return { figure, x, zoom };
  };
  addEventListener("beforeprint", () => document.querySelectorAll("details").forEach((each) => { each.open = true; }));
  document.querySelectorAll("figure.chart").forEach((figure) => charts.push(chart(figure)));
})();
