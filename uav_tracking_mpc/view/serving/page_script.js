// Copyright 2026 uav_tracking_mpc maintainers
//
// Licensed under the Apache License, Version 2.0 (the "License");
// you may not use this file except in compliance with the License.
// You may obtain a copy of the License at
//
//     http://www.apache.org/licenses/LICENSE-2.0
//
// Unless required by applicable law or agreed to in writing, software
// distributed under the License is distributed on an "AS IS" BASIS,
// WITHOUT WARRANTIES OR CONDITIONS OF ANY KIND, either express or implied.
// See the License for the specific language governing permissions and
// limitations under the License.

// What the page shows beside viser's scene and panel: title, banner, time strip, head-up display.
// A live page asks its server (view/visitors.py); the scene of a report carries its record with it.
(() => {
  "use strict";
  const record = window.__FLIGHT_RECORD__; // null on a live page
  const OLD = 2.0; // s after which the picture counts as old
  const EPOCH = 1e8; // s from which on a clock counts from 1970
  const PATIENCE = 10000; // ms that an answer may take
  const TICK = 250; // ms between looks at how old the picture is
  const QUICK = 50, SLOW = 200, HIDDEN = 1000, ROWS = 1000; // ms between questions; for new rows
  const MOST = 8000; // rows that are kept
  // Pixels. A strip begins folded below NARROW or LOW, the panel below PHONE; below SHORT, one lane.
  const NARROW = 700, PHONE = 500, LOW = 500, SHORT = 900;
  const LANE = 38, BAND = 10, AXIS = 16, LEFT = 132, RIGHT = 20; // pixels
  const FONT = '11px system-ui, "DejaVu Sans", sans-serif';
  const COCKPIT = "from the cockpit"; // as view/cameras.py calls it
  const HALF_VIEW = (25 * Math.PI) / 180; // of the cockpit's camera, upright
  // Of the errors' weights: Okabe and Ito's, told apart by everybody.
  const TERM_COLOURS = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00"];
  const TERMS = ["range", "bearing", "altitude", "path angle", "speed"];
  const LANES = {
    "range error": { words: (value) => `${shown(value)} m`, zero: true, least: 1 },
    altitude: { words: (value) => `${shown(value)} m`, least: 2 },
    bank: { words: (value) => tilted(value), zero: true, least: 10 },
    airspeed: { words: (value) => `${shown(value)} m/s`, least: 1 },
    wind: { words: (value) => `${shown(value)} m/s`, zero: true, least: 1 },
    cost: { words: (value) => value.toExponential(1), log: true, least: 1 },
    "weighted errors": { shares: true },
  };
  // ---- what is known ---------------------------------------------------------------------------
  let now = null; // newest answer of the server
  let heard = performance.now(); // when it came [ms]
  let silence = 0; // since then, while this page was awake [ms]: a busy browser is no lost server
  let server = null; // which one answered first
  let restarted = false;
  let asked = null; // time that this page looks at [s]; null for now
  let playing = false; // whether that goes on
  let drawn = { name: null, generation: null, rows: [], events: [], columns: [], modes: [] };
  let stood = { time: null, since: 0 }; // how long the flight's clock has stood still
  let hudByHand = null; // whether a hand switched the head-up display; null leaves it to the camera
  let lanes = ["range error", "bank", "cost"].slice(0, record || innerHeight >= SHORT ? 3 : 1);
  let begun = false; // whether the panel stands as it is to begin
  let dirty = true;

  const make = (tag, parent, attributes = {}, text = "") => {
    const made = document.createElement(tag);
    for (const [name, value] of Object.entries(attributes)) made.setAttribute(name, value);
    made.textContent = text;
    parent.append(made);
    return made;
  };
  const clock = (seconds) => {
    if (seconds === null || !Number.isFinite(seconds)) return "-";
    if (seconds > EPOCH) return new Date(1000 * seconds).toISOString().slice(11, 21); // UTC
    const tenths = Math.round(Math.abs(seconds) * 10);
    const [h, m, s] = [Math.floor(tenths / 36000), Math.floor(tenths / 600) % 60, tenths % 600];
    const rest = (s / 10).toFixed(1).padStart(4, "0");
    return (seconds < 0 ? "-" : "") + (h ? `${h}:${String(m).padStart(2, "0")}` : m) + `:${rest}`;
  };
  // Without "-0.0"; what is not known is a dash.
  const shown = (value, digits = 1) =>
    (value ?? null) === null ? "-" : (Number(value.toFixed(digits)) || 0).toFixed(digits);
  const tilted = (bank) =>
    `${Math.abs(bank).toFixed(1)}°` + (Math.abs(bank) < 0.05 ? "" : bank > 0 ? " right" : " left");
  const column = (name) => drawn.columns.indexOf(name);
  const dark = matchMedia("(prefers-color-scheme: dark)");
  // ---- elements --------------------------------------------------------------------------------
  let strip, canvas, timeLabel, words, play, live, hudButton, fold, banner, card, hud;
  function build() {
    banner = make("div", document.body, { id: "flight-banner", role: "alert", hidden: "" });
    card = make("div", document.body, { id: "flight-card", hidden: "" });
    hud = document.createElementNS("http://www.w3.org/2000/svg", "svg");
    hud.id = "flight-hud";
    hud.setAttribute("hidden", "");
    document.body.append(hud);
    strip = make("section", document.body, { id: "flight-strip", "aria-label": "Time strip" });
    const header = make("header", strip);
    play = button(header, "pause", togglePlay, "Pause this page; the flight goes on");
    live = button(header, record ? "begin" : "live", goLive,
      record ? "Back to the begin" : "Back to what all pages show (L)");
    timeLabel = make("span", header, { id: "flight-time" }, "-");
    words = make("span", header, { id: "flight-words" });
    const chips = make("span", header, { id: "flight-lanes" });
    for (const name of Object.keys(LANES)) {
      const chip = button(chips, name, () => {
        lanes = Object.keys(LANES).filter((each) => lanes.includes(each) !== (each === name));
        chip.setAttribute("aria-pressed", lanes.includes(name));
        resize();
      });
      chip.setAttribute("aria-pressed", lanes.includes(name));
    }
    hudButton = button(header, "HUD", toggleHud, "Head-up display (H)");
    hudButton.hidden = record !== null;
    fold = button(header, "", () => setFolded(!isFolded()), "Fold or unfold the strip");
    canvas = make("canvas", strip, {
      tabindex: 0, role: "slider", "aria-label": "Time of the flight [s]",
    });
    canvas.addEventListener("pointerdown", (event) => {
      canvas.setPointerCapture(event.pointerId);
      seek(timeAt(event.offsetX));
    });
    canvas.addEventListener("pointermove", (event) => {
      if (event.buttons && canvas.hasPointerCapture(event.pointerId)) seek(timeAt(event.offsetX));
      canvas.title = markAt(event.offsetX);
    });
    canvas.addEventListener("keydown", (event) => {
      const step = { ArrowLeft: -1, ArrowRight: 1, PageDown: -10, PageUp: 10,
        Home: -Infinity, End: Infinity }[event.key];
      if (step === undefined) return;
      event.preventDefault();
      event.stopPropagation(); // viser moves its camera by them
      seek((asked ?? shownTime()) + step);
    });
    window.addEventListener("keydown", (event) => {
      const typing = event.target.closest?.("input, textarea, select, [contenteditable]");
      if (typing || record || event.ctrlKey || event.metaKey || event.altKey) return;
      const key = event.key?.toLowerCase();
      if (key === "h") toggleHud();
      if (key === "l") goLive();
    });
    window.addEventListener("resize", resize);
    document.addEventListener("click", (event) => {
      // A list keeps the keys after a choice: H would be written into it.
      const chosen = event.target.closest?.('[role="option"]');
      if (chosen) setTimeout(() => document.activeElement?.blur()); // when it has closed
    });
    new MutationObserver(() => (dirty = true)).observe(document.documentElement, {
      attributes: true, attributeFilter: ["data-mantine-color-scheme"],
    });
    setFolded(innerWidth < NARROW || innerHeight < LOW);
  }
  function button(parent, text, click, title = "") {
    const made = make("button", parent, { type: "button", title }, text);
    made.addEventListener("click", (event) => {
      click();
      if (event.detail) made.blur(); // of the mouse: keys belong to the scene again
    });
    return made;
  }
  const isFolded = () => strip.classList.contains("folded");
  function setFolded(folded) {
    strip.classList.toggle("folded", folded);
    fold.textContent = folded ? "▴" : "▾";
    fold.setAttribute("aria-expanded", String(!folded));
    resize();
  }
  function resize() {
    const height = BAND + 4 + lanes.length * LANE + AXIS, scale = devicePixelRatio || 1;
    canvas.style.height = `${height}px`;
    canvas.width = Math.round(innerWidth * scale);
    canvas.height = Math.round(height * scale);
    canvas.getContext("2d").setTransform(scale, 0, 0, scale, 0, 0);
    document.documentElement.style.setProperty("--f-strip", `${strip.offsetHeight}px`);
    dirty = true;
  }
  // ---- time ------------------------------------------------------------------------------------
  function span() {
    if (now?.record) return now.record;
    const rows = drawn.rows, begin = rows.length ? rows[0][0] : 0;
    return [begin, Math.max(begin + 1, now?.live ?? 0, rows.length ? rows.at(-1)[0] : 0)];
  }
  function shownTime() {
    if (record) return record.begin + record.pace * Number(player()?.value ?? 0);
    return now?.sight?.time ?? 0; // not what is asked for: that is seen once it is drawn
  }
  const player = () => document.querySelector("input[inputmode=decimal]"); // of viser's replay
  function seek(time) {
    const [begin, end] = span(), to = Math.min(Math.max(time, begin), end);
    dirty = true;
    if (record) {
      const field = player();
      if (!field) return;
      // React hears a field only where its own setter is passed by.
      const set = Object.getOwnPropertyDescriptor(HTMLInputElement.prototype, "value").set;
      set.call(field, ((to - record.begin) / record.pace).toFixed(2));
      field.dispatchEvent(new Event("input", { bubbles: true }));
      return;
    }
    [asked, playing] = [to, false];
    tell();
  }
  function goLive() {
    if (record) return seek(record.begin);
    [asked, playing, dirty] = [null, false, true];
    tell();
  }
  function togglePlay() {
    if (asked === null) return now?.sight && seek(now.sight.time);
    playing = !playing;
    tell();
  }
  // ---- the server ------------------------------------------------------------------------------
  let polled = performance.now(), ticked = polled;
  function tick() {
    silence += Math.min(performance.now() - ticked, 2 * TICK);
    ticked = performance.now();
    if (silence > 1000 * OLD) tell();
  }
  async function ask(path, query) {
    const options = { cache: "no-store", signal: AbortSignal.timeout(PATIENCE) };
    const answer = await fetch(`${path}?${new URLSearchParams(query)}`, options);
    // Each server has a token of its own: who knows another one comes from an earlier server.
    restarted = answer.status === 403;
    if (!answer.ok) throw new Error(`status ${answer.status}`);
    return answer.json();
  }
  const isLost = () => restarted || silence > 1000 * OLD;
  /** It names this page to its server. */
  const pageTag = () => [...document.querySelectorAll("[data-flight-page]")].at(-1);
  async function poll() {
    if (playing && (asked += (performance.now() - polled) / 1000) >= span()[1]) goLive();
    polled = performance.now();
    const query = { dark: Number(dark.matches) }, tag = pageTag();
    if (tag) query.page = tag.dataset.flightPage;
    if (tag && !begun) foldPanel(tag);
    if (asked !== null) query.time = asked.toFixed(3);
    const scene = document.querySelector("canvas[data-engine]");
    if (scene && begun) query.wide = scene.clientWidth;
    try {
      const answer = await ask("flight/now", query);
      server ??= answer.server;
      if (server !== answer.server) return location.reload(); // this page is an earlier server's
      [now, heard, silence] = [answer, performance.now(), 0];
      if (stood.time !== now.live) stood = { time: now.live, since: performance.now() };
      if (!drawn.modes.length) [drawn.modes, drawn.columns] = [now.modes, now.columns];
    } catch {} // the banner says how old the picture is
    tell();
    const quick = !hud.hasAttribute("hidden") || asked !== null;
    setTimeout(poll, document.hidden ? HIDDEN : quick ? QUICK : SLOW);
  }
  /** On a phone viser opens its panel upon the scene; a click on the panel's head folds it. */
  function foldPanel(tag) {
    begun = true;
    if (innerWidth < PHONE)
      tag.closest(".mantine-Paper-root")?.querySelector('[style*="cursor: pointer"]')?.click();
  }
  async function pollRows() {
    if (now?.name && !document.hidden) {
      if (drawn.name !== now.name) forget(now.name);
      const since = drawn.rows.length ? { since: drawn.rows.at(-1)[0] } : {};
      await ask("flight/flown", { name: drawn.name, ...since }).then(take, () => {}); // as above
    }
    setTimeout(pollRows, ROWS);
  }
  const forget = (name) => (drawn = { ...drawn, name, generation: null, rows: [], events: [] });
  function take(answer) {
    if (answer.generation === undefined) return;
    if (drawn.generation !== null && drawn.generation !== answer.generation) {
      forget(drawn.name);
      return goLive(); // the time that was looked at is gone
    }
    const rows = drawn.rows.concat(answer.rows), known = new Set(drawn.events.map(String));
    const events = drawn.events.concat(answer.events.filter((each) => !known.has(String(each))));
    drawn = { ...drawn, ...answer, events };
    drawn.rows = rows.length > MOST ? rows.filter((_, k) => k % 2 === 0) : rows;
    dirty = true;
  }
  // ---- words -----------------------------------------------------------------------------------
  function alarm() {
    if (restarted)
      return [2, "The server was started anew. Open the address that it prints: its token is new."];
    const age = (performance.now() - heard) / 1000 + (now?.age ?? 0);
    const old = `the picture is ${age.toFixed(0)} s old`;
    if (silence > 1000 * OLD)
      return [2, `Connection lost: ${old}. It comes back by itself if the server still runs.`];
    if (now && now.age > OLD) return [2, `The server draws no more: ${old}.`];
    return now?.alert ?? null;
  }
  function tell() {
    const wrong = alarm();
    banner.hidden = wrong === null || wrong[1] === "";
    if (wrong) {
      if (banner.textContent !== wrong[1]) banner.textContent = wrong[1];
      banner.className = ["know", "attend", "wrong"][wrong[0]];
    }
    const sight = now?.sight, past = Boolean(now?.past);
    const lost = isLost(), still = !past && !lost && performance.now() - stood.since > 1000;
    const why = sight?.reason ? `: ${sight.reason}` : "";
    const mode = sight ? now.modes[sight.mode][0] : "waiting";
    const warning = wrong?.[0] === 2 ? "⚠ " : "";
    const title = lost ? "⚠ no connection" : past ? "past"
      : warning + mode + (still && !warning ? ", still" : "");
    document.title = `${title} · ${now?.name || "no flight"} · uav_tracking`;
    document.body.classList.toggle("flight-past", past);
    timeLabel.textContent = clock(sight?.time ?? null);
    const behind = past && now.live !== null ? now.live - sight.time : 0;
    words.textContent = lost ? "no connection: this is the last picture"
      : past
        ? now.record ? `The picture is of another time than the replay: ${clock(sight.time)}`
          : `The picture is of the past: ${behind.toFixed(1)} s before now`
        : sight ? (still ? "time stands still: " : now.record ? "replay: " : "now: ") + mode + why
          : "nothing is seen yet";
    play.textContent = asked !== null && !playing ? "play" : "pause";
    live.textContent = now?.record ? "replay" : "live";
    live.setAttribute("aria-pressed", asked === null);
    if (sight) tellTime(sight.time);
    showCard(past ? sight : null, mode);
    showHud(sight);
    dirty = true;
  }
  /** To who hears the page. */
  function tellTime(time) {
    canvas.setAttribute("aria-valuenow", shown(time));
    canvas.setAttribute("aria-valuetext", clock(time));
  }
  function showCard(sight, mode) {
    card.hidden = sight === null;
    if (!sight) return;
    card.textContent = "";
    make("b", card, {}, `${clock(sight.time)} ${mode}`);
    if (sight.reason) make("div", card, {}, sight.reason);
    const table = make("table", card);
    for (const [name, [unit, value, error]] of Object.entries(sight.readings)) {
      const row = make("tr", table);
      make("td", row, {}, name);
      make("td", row, {}, name === "Bank" && value !== null ? tilted(value) : `${shown(value)} ${unit}`);
      make("td", row, {}, error === null ? "" : `error ${shown(error)}`);
    }
  }
  // ---- strip -----------------------------------------------------------------------------------
  const across = () => Math.max(innerWidth - left() - RIGHT, 10);
  const left = () => (innerWidth < NARROW ? 84 : LEFT);
  function timeAt(x) {
    const [begin, end] = span();
    return begin + ((x - left()) / across()) * (end - begin);
  }
  function placeOf(time) {
    const [begin, end] = span();
    return left() + ((time - begin) / (end - begin)) * across();
  }
  function markAt(x) {
    const near = drawn.events.filter(([time]) => Math.abs(placeOf(time) - x) < 5);
    return near.slice(-6).map(([time, , text]) => `${clock(time)} ${text}`).join("\n");
  }
  /** Index of the last row at a time. */
  const rowAt = (time) => Math.max(drawn.rows.findLastIndex((row) => row[0] <= time + 1e-6), 0);
  function drawStrip() {
    requestAnimationFrame(drawStrip);
    if (record && shownTime() !== stood.time) {
      [stood.time, dirty] = [shownTime(), true];
      timeLabel.textContent = clock(stood.time);
    }
    if (!dirty || isFolded()) return;
    dirty = false;
    const pen = canvas.getContext("2d"), style = getComputedStyle(document.documentElement);
    const [ink, quiet, line, blue, pastInk] =
      ["ink", "quiet", "line", "blue", "past"].map((name) => style.getPropertyValue(`--f-${name}`));
    pen.clearRect(0, 0, innerWidth, canvas.height);
    pen.font = FONT;
    pen.textBaseline = "middle";
    const rows = drawn.rows, time = shownTime(), foot = canvas.clientHeight - AXIS;
    drawModes(pen, rows);
    const current = now?.sight?.row ?? rows[rowAt(time)]; // while time stands no row is added
    lanes.forEach((name, k) => {
      const top = BAND + 4 + k * LANE;
      pen.fillStyle = line;
      pen.fillRect(0, top, innerWidth, 1);
      if (rows.length) drawLane(pen, name, top, rows, current, { ink, quiet, line, blue });
    });
    drawAxis(pen, quiet);
    for (const [when, level] of drawn.events) {
      if (!level) continue;
      pen.fillStyle = level > 1 ? "#d53e00" : "#e69f00";
      const x = placeOf(when);
      pen.fillRect(x - 0.5, 0, 1, foot);
      pen.fill(new Path2D(`M${x - 4} 0h8l-4 7z`));
    }
    pen.fillStyle = now?.past ? pastInk : ink;
    pen.fillRect(placeOf(time) - 1, 0, 2, foot);
    if (asked !== null && Math.abs(asked - time) > 1) {
      pen.fillStyle = pastInk; // on its way there
      for (let y = 0; y < foot; y += 6) pen.fillRect(placeOf(asked) - 0.5, y, 1, 3);
    }
    canvas.setAttribute("aria-valuemin", span()[0].toFixed(1));
    canvas.setAttribute("aria-valuemax", span()[1].toFixed(1));
    if (record) tellTime(time);
    canvas.dataset.rows = rows.length;
  }
  function drawModes(pen, rows) {
    const mode = column("mode");
    for (let k = 0; k < rows.length; ) {
      let last = k;
      while (last < rows.length && rows[last][mode] === rows[k][mode]) last++;
      const end = last < rows.length ? rows[last][0] : Math.max(rows.at(-1)[0], now?.live ?? 0);
      pen.fillStyle = `rgb(${drawn.modes[rows[k][mode]][1]})`;
      const x = placeOf(rows[k][0]);
      pen.fillRect(x, 0, Math.max(placeOf(Math.min(end, span()[1])) - x, 1), BAND);
      k = last;
    }
  }
  function drawLane(pen, name, top, rows, current, colours) {
    const { words, zero, log, least, shares } = LANES[name];
    pen.fillStyle = colours.quiet;
    pen.fillText(name, 8, top + 11);
    if (shares) return drawShares(pen, top, rows, current, colours);
    const at = column(name), value = current[at];
    [pen.fillStyle, pen.font] = [colours.ink, `600 ${FONT}`];
    pen.fillText(value === null ? "not known" : words(value), 8, top + 27);
    pen.font = FONT;
    const scaled = (number) => (log ? Math.log10(Math.max(number, 1e-6)) : number);
    const known = rows.filter((row) => row[at] !== null).map((row) => scaled(row[at]));
    if (!known.length) return;
    if (zero) known.push(0);
    let [low, high] = [Math.min(...known), Math.max(...known)];
    const more = Math.max(least - (high - low), 0) / 2; // what hardly changes is drawn quietly
    [low, high] = [low - more, high + more];
    const y = (number) => top + LANE - 5 - ((number - low) / (high - low)) * (LANE - 10);
    if (zero) {
      pen.fillStyle = colours.line;
      pen.fillRect(left(), y(0), across(), 1);
    }
    pen.strokeStyle = colours.blue;
    pen.lineWidth = 1.5;
    pen.beginPath();
    let on = false; // what is not known is a gap
    for (const row of rows) {
      if (row[at] !== null) pen[on ? "lineTo" : "moveTo"](placeOf(row[0]), y(scaled(row[at])));
      on = row[at] !== null;
    }
    pen.stroke();
    if (innerWidth < NARROW) return;
    pen.fillStyle = colours.quiet;
    pen.textAlign = "right";
    const mark = (number) => (log ? `1e${number.toFixed(0)}` : Number(number.toPrecision(2)));
    pen.fillText(mark(high), left() - 6, top + 9);
    pen.fillText(mark(low), left() - 6, top + LANE - 7);
    pen.textAlign = "left";
  }
  /** The share of each weighted error in their sum, one above the other. */
  function drawShares(pen, top, rows, current, colours) {
    const first = drawn.columns.length - TERMS.length, height = LANE - 6;
    for (let x = 0, k = 0; x < across(); x += 1) {
      const time = timeAt(left() + x);
      if (time > rows.at(-1)[0]) break;
      while (rows[k + 1]?.[0] <= time) k++;
      const terms = rows[k].slice(first);
      const sum = terms.reduce((total, each) => total + (each ?? 0), 0);
      if (!(sum > 0)) continue;
      let y = top + 3;
      terms.forEach((term, k) => {
        pen.fillStyle = TERM_COLOURS[k];
        pen.fillRect(left() + x, y, 1.5, (height * term) / sum);
        y += (height * term) / sum;
      });
    }
    const terms = current.slice(first);
    const most = terms.indexOf(Math.max(...terms.map((each) => each ?? -1)));
    pen.fillStyle = colours.ink;
    pen.fillText(terms[most] === null ? "not known" : `most: ${TERMS[most]}`, 8, top + 27);
    let x = left() + 4;
    TERMS.forEach((name, k) => {
      const size = pen.measureText(name).width + 10;
      pen.fillStyle = TERM_COLOURS[k];
      pen.fillRect(x, top + 4, size - 2, 14);
      pen.fillStyle = k ? "#000" : "#fff"; // the first one alone is dark
      pen.fillText(name, x + 4, top + 11);
      x += size;
    });
  }
  function drawAxis(pen, colour) {
    const [begin, end] = span();
    const steps = [1, 2, 5, 10, 20, 30, 60, 120, 300, 600, 1200, 1800, 3600, 7200, 14400, 43200];
    const step = steps.find((each) => ((end - begin) / each) * 70 < across()) ?? 86400;
    pen.fillStyle = colour;
    pen.textAlign = "center";
    const y = canvas.clientHeight - AXIS / 2;
    for (let t = Math.ceil(begin / step) * step; t <= end; t += step)
      pen.fillText(clock(t).replace(/\.0$/, ""), placeOf(t), y);
    pen.textAlign = "left";
  }
  // ---- head-up display -------------------------------------------------------------------------
  function toggleHud() {
    hudByHand = hud.hasAttribute("hidden");
    tell();
  }
  let inCockpit = false;
  function showHud(sight) {
    if (now && (now.view === COCKPIT) !== inCockpit) [inCockpit, hudByHand] = [!inCockpit, null];
    const wanted = hudByHand ?? inCockpit;
    hudButton.setAttribute("aria-pressed", wanted);
    const scene = document.querySelector("canvas[data-engine]");
    if (hud.toggleAttribute("hidden", !(wanted && sight && scene))) return;
    const box = scene.getBoundingClientRect();
    // On a phone the panel covers the lower part of the scene.
    const panel = document.querySelector("[data-flight-panel]")?.getBoundingClientRect();
    const below = innerWidth < NARROW && panel?.width ? panel.top - 105 - box.top : Infinity;
    const [w, h] = [box.width, Math.max(Math.min(box.height, below), 160)];
    const beside = panel?.width && panel.left > 0.55 * w ? panel.left - w / 2 - 100 : 0.5 * w - 92;
    const off = Math.max(Math.min(0.3 * w, 300, beside), 60); // of the tapes
    const place = { left: box.left, top: box.top, width: w, height: h };
    for (const [name, pixels] of Object.entries(place)) hud.style[name] = `${pixels}px`;
    hud.innerHTML = horizon(sight, w, h) + bankScale(sight, w, h, off) + tapes(sight, w, h, off);
  }
  const line = (x1, y1, x2, y2, kind = "") =>
    `<line class="ink ${kind}" x1="${x1.toFixed(1)}" y1="${y1.toFixed(1)}" x2="${x2.toFixed(1)}" ` +
    `y2="${y2.toFixed(1)}"/>`;
  const escaped = (text) => String(text).replace(/[&<>"]/g, (each) => `&#${each.charCodeAt(0)};`);
  const label = (x, y, text, anchor = "middle", more = "") =>
    `<text x="${x.toFixed(1)}" y="${y.toFixed(1)}" text-anchor="${anchor}" ` +
    `dominant-baseline="central" ${more}>${escaped(text)}</text>`;
  /** The horizon stands where the camera of the cockpit sees it: right wing down turns it left. */
  function horizon(sight, w, h) {
    const bank = sight.readings.Bank[1], path = sight.readings["Path angle"][1];
    if (bank === null || path === null) return label(w / 2, h / 2, "attitude not known");
    const focal = (0.5 * h) / Math.tan(HALF_VIEW), half = Math.min(0.16 * w, 0.25 * h, 150);
    let rungs = "";
    for (let angle = -30; angle <= 30; angle += 5) {
      const y = focal * Math.tan(((path - angle) * Math.PI) / 180);
      if (Math.abs(y) > Math.min(0.28 * h, 150, 0.3 * w)) continue; // else upon the bank
      const reach = angle === 0 ? half * 1.5 : half * 0.45;
      rungs += line(-reach, y, -0.3 * half, y) + line(0.3 * half, y, reach, y);
      if (angle) rungs += label(reach + 16, y, angle) + label(-reach - 16, y, angle);
    }
    return (
      `<g transform="translate(${w / 2},${h / 2})">` +
      `<g data-hud="horizon" transform="rotate(${-bank})">${rungs}</g><circle class="ink" r="5"/>` +
      line(-22, 0, -7, 0) + line(7, 0, 22, 0) + line(0, -14, 0, -5) + "</g>"
    );
  }
  function bankScale(sight, w, h, off) {
    const [, bank, , least, most] = sight.readings.Bank, radius = Math.min(0.34 * h, 190, off);
    const spoke = (angle, from, to, kind) =>
      `<g transform="rotate(${angle})">${line(0, -from, 0, -to, kind)}</g>`;
    let marks = "";
    for (const angle of [-60, -45, -30, -20, -10, 0, 10, 20, 30, 45, 60])
      marks += spoke(angle, radius, radius + (angle % 30 ? 6 : 11));
    for (const limit of [least, most].filter((each) => each !== null))
      marks += spoke(limit, radius - 8, radius + 16, "limit");
    if (bank !== null)
      marks += `<path class="full" data-hud="pointer" transform="rotate(${bank})" ` +
        `d="M0 ${-radius + 2} l-7 13 h14 z"/>`;
    const side = bank === null ? "bank not known" : `bank ${tilted(bank)}`;
    const limit = most === null ? "" : `, limit ${most.toFixed(0)}°`;
    return `<g transform="translate(${w / 2},${h / 2})">${marks}` +
      label(0, -radius - 22, side + limit, "middle", 'data-hud="bank"') + "</g>";
  }
  function tapes(sight, w, h, off) {
    const { Airspeed, Altitude, Range } = sight.readings;
    let drawing = tape(w / 2 - off, h, Airspeed, 0.5, -1, "airspeed") +
      tape(w / 2 + off, h, Altitude, 5, 1, "altitude");
    const error = Range[2], bottom = Math.min(h / 2 + Math.min(0.36 * h, 190) + 12, h - 50);
    const wind = sight.wind === null ? "wind not known" : sight.wind < 0.05 ? "no wind"
      : `wind ${sight.wind.toFixed(1)} m/s from ${sight.wind_from.toFixed(0)}°`;
    drawing += label(w / 2, bottom, error === null ? "range error not known"
      : `range error ${error >= 0.05 ? "+" : ""}${shown(error)} m`, "middle", 'data-hud="range"');
    drawing += label(w / 2, bottom + 18, now.modes[sight.mode][0], "middle", 'data-hud="mode"');
    if (w >= 480) drawing += label(w / 2, bottom + 36, `heading ${shown(sight.course, 0)}°, ${wind}`);
    return drawing;
  }
  function tape(x, h, [unit, value, error, least, most], step, side, name) {
    const half = Math.min(0.3 * h, 150), pixels = half / (8 * step); // eight marks up, eight down
    let marks = line(x, h / 2 - half, x, h / 2 + half);
    if (value === null) return marks + label(x, h / 2, `${name} not known`);
    const y = (number) => h / 2 - (number - value) * pixels;
    for (let k = Math.ceil(value / step - 8); k <= value / step + 8; k++) {
      const long = k % 4 === 0;
      marks += line(x, y(k * step), x + side * (long ? 10 : 5), y(k * step));
      if (long && Math.abs(y(k * step) - h / 2) > 14)
        marks += label(x + side * 15, y(k * step), k * step, side > 0 ? "start" : "end");
    }
    for (const limit of [least, most])
      if (limit !== null && Math.abs(y(limit) - h / 2) <= half)
        marks += line(x - side * 10, y(limit), x + side * 12, y(limit), "limit");
    if (error !== null && Math.abs(y(value - error) - h / 2) <= half) // what is asked for
      marks += `<path class="full" d="M${x - 2 * side} ${y(value - error)} l${-9 * side} -5 v10 z"/>`;
    marks += label(x + side * 15, h / 2, `${value.toFixed(1)} ${unit}`, side > 0 ? "start" : "end",
      `data-hud="${name}" style="font-size:${innerWidth < NARROW ? 13 : 17}px"`);
    return marks + label(x, h / 2 - half - 14, name);
  }
  // ---- a mission in the address ----------------------------------------------------------------
  function offerMission() {
    const mission = new URLSearchParams(location.hash.slice(1)).get("mission");
    if (!mission) return;
    const box = make("div", document.body, {
      id: "flight-mission", role: "dialog", "aria-label": "A mission in the address",
    });
    box.addEventListener("keydown", (event) => event.key === "Escape" && end());
    const words = make("b", box, {}, "This address holds a mission. Fly it?");
    make("pre", box, {}, mission);
    const end = () => {
      clearInterval(waiting);
      box.remove();
      history.replaceState(null, "", location.pathname + location.search);
    };
    const fly = button(box, "Fly it", async () => {
      const query = { page: pageTag().dataset.flightPage, name: now.name, mission };
      const failed = (error) => ({ refused: error.message });
      const { refused } = await ask("flight/mission", query).catch(failed);
      if (refused) words.textContent = `It is not flown: ${refused}`;
      else end();
    });
    fly.disabled = true; // until it is known what flies
    const waiting = setInterval(() => (fly.disabled = !pageTag() || !now?.name), TICK);
    button(box, "Not now", end).focus();
  }
  // ---- begin -----------------------------------------------------------------------------------
  function begin() {
    build();
    if (record) {
      Object.assign(drawn, record);
      now = { record: [record.begin, record.end] };
      play.hidden = true;
      words.textContent = "the whole flight: click to go to a time";
    } else {
      offerMission();
      window.addEventListener("hashchange", () => location.reload()); // a link opened in this tab
      poll();
      pollRows();
      setInterval(tick, TICK);
    }
    drawStrip();
  }
  if (document.readyState === "loading") document.addEventListener("DOMContentLoaded", begin);
  else begin();
})();
