// The page of `sinew scope`: what the driver does, as it does it; or the numbers of a stream (`rig.of` is "stream"), whose
// columns are the channels and whose units are the quantities.
//
// Curves come over a WebSocket in binary frames (data.js), everything else as JSON: `hello` (the rig), `status` (modes,
// faults, the loop), `may` (whether this page may command), `answer` (what became of a request), `picture` (the machine,
// picture.js) and `entry` (what became of a PIN, entry.js). Curves are drawn once a screen frame, from what is there by then.
"use strict";

const $ = (id) => document.getElementById(id);
const streams = () => page.rig?.of === "stream";
const WINDOWS = [0.5, 1, 2, 5, 10, 20, 30, 60, 120, 300, 600];
const FIRST = ["length_m", "duty"];
// A setpoint that is held is renewed so often, and lasts so long without, s. In a tab in the background a browser wakes a
// page once a second, after some minutes once a minute: then the lease runs out, which is what it is for.
const RENEW_S = 0.4, HOLD_S = 1.5;
// Curves run so far behind the newest bin, s: the driver sends in batches, and a curve that stops and jumps is hard to read.
const BEHIND_S = 0.08;
// Up to so many channels there is nothing to find or to group.
const FEW = 6;
// Wires that differ by less are equally hot to the list.
const HEAT_STEP_K = 3;
// Above so many channels dashes only clutter, and cost time to draw.
const DASHED_UP_TO = 6;

const page = {
  socket: null, rig: null, status: null, may: false,
  shown: new Set(), quantities: [...FIRST], selected: 0, focus: FIRST[0],
  generation: 0, curves: null, series: new Map(), lost: 0,
  window: 10, frozen: null, cursor: null, pinned: new Set(), arranged: [],
  clock: null, panels: [], built: 0, dirty: true, held: new Map(), asked: new Map(), ids: 0,
};

const picture = new Picture($("picture"), $("says"));
const door = new Entry($("entry"), connect);

// ——— the line to the server ———

function connect() {
  const socket = new WebSocket(`${location.protocol.replace("http", "ws")}//${location.host}/live`);
  socket.binaryType = "arraybuffer";
  page.socket = socket;
  socket.onopen = () => {
    const token = location.hash.slice(1);
    if (door.needed) send(door.knock());
    else if (token) send({ do: "token", token });
    page.rig = null;
  };
  socket.onmessage = ({ data }) => (typeof data === "string" ? told(JSON.parse(data)) : received(data));
  socket.onclose = ({ reason }) => {
    page.status = null;
    page.may = false;
    page.held.clear();
    const why = reason ? `The scope has closed this page: ${reason}.` : "The scope has ended, or its computer is out of reach.";
    banner(`${why} This page tries again every second.`);
    state("no scope", "bad");
    card();
    // whoever has no session is asked for the PIN, and connects with it
    if (door.asks) return door.unanswered(reason);
    setTimeout(connect, 1000);
  };
}

function send(message) {
  if (page.socket?.readyState === WebSocket.OPEN) page.socket.send(JSON.stringify(message));
}

// Asks something of the driver or the recorder; answers with { ok, message }.
function ask(what) {
  return new Promise((resolve) => {
    if (page.socket?.readyState !== WebSocket.OPEN) return resolve({ ok: false, message: "there is no connection" });
    const id = ++page.ids;
    page.asked.set(id, resolve);
    send({ do: "ask", id, what });
  });
}

function told(message) {
  if (message.kind === "entry") door.answered(message);
  else if (message.kind === "hello") hello(message);
  else if (message.kind === "status") status(message);
  else if (message.kind === "may") { page.may = message.command; $("record").hidden = !page.may; card(); }
  else if (message.kind === "picture") { send({ do: "seen", frame: message.frame }); picture.show(message.picture); }
  else if (message.kind === "answer") { page.asked.get(message.id)?.(message); page.asked.delete(message.id); }
}

function hello(rig) {
  const same = page.rig?.channels.map((c) => c.name).join() === rig.channels.map((c) => c.name).join();
  const first = !page.names;
  page.rig = rig;
  document.title = `${rig.rig} · sinew scope`;
  $("rig").textContent = rig.rig;
  $("simulated").hidden = !rig.simulated;
  $("machine").hidden = !rig.picture;
  const names = rig.channels.map((c) => c.name);
  if (first || page.names.join() !== names.join()) {
    page.names = names;
    page.selected = 0;
    page.pinned = new Set();
    $("find").value = "";
    const first = names.map((_, i) => i).filter((i) => !rig.channels[i].clock);
    page.shown = new Set(first.slice(0, names.length <= 6 || streams() ? 12 : 3));
    if (streams()) page.quantities = rig.quantities.map((q) => q.name).filter((name) => first.some((i) => panelOf(i) === name));
    page.focus = page.quantities[0];
    document.body.classList.toggle("streams", streams());
    channels();
    quantities();
    windows();
  }
  if (!same) card();
  show();
}

// Tells the server which curves are shown; it sends them from as far back as it has them.
function show() {
  const rig = page.rig;
  if (!rig) return;
  // a column of a stream has one quantity, and is in the panel of its unit
  const place = (quantity) => (streams() ? 0 : rig.quantities.findIndex((q) => q.name === quantity));
  const wanted = new Set(page.quantities);
  if (wanted.has("length_m") || wanted.has("measured_length_m")) wanted.add("target_m");
  page.series = new Map();
  const series = [];
  for (const quantity of wanted) {
    for (const channel of shownIn(quantity)) {
      page.series.set(`${quantity} ${channel}`, series.length);
      series.push([channel, place(quantity)]);
    }
  }
  page.generation += 1;
  page.waiting = new Curves(series.length, rig.values, rig.capacity);
  send({ do: "show", generation: page.generation, series });
  if (!series.length) page.curves = page.waiting;
  panels();
}

// The channels that are shown in the panel of this quantity.
function shownIn(quantity) {
  const shown = [...page.shown].sort((a, b) => a - b);
  if (!streams()) return shown;
  return shown.filter((i) => panelOf(i) === quantity);
}

// The panel of a stream's column.
const panelOf = (i) => page.rig.quantities[page.rig.channels[i].panel].name;

// The quantity of a channel whose value stands beside its name.
const focused = (i) => page.rig.quantities.find((q, k) => (streams() ? k === page.rig.channels[i].panel : q.name === page.focus));

function received(buffer) {
  const frame = readFrame(buffer);
  send({ do: "seen", frame: frame.number });
  if (frame.generation !== page.generation) return;
  if (page.waiting) {
    // the old curves stay on the screen until the new ones are here
    page.curves = page.waiting;
    page.waiting = null;
    build();
  }
  page.lost = frame.lost;
  page.curves.append(frame.bins, frame.time, frame.floats);
  page.dirty = true;
  // of a long history's pieces only the last one is new
  if (frame.more) return;
  const now = performance.now() / 1000, offset = now - page.curves.last;
  // the page's clock against the driver's: the quickest frame tells it best; it creeps, so that neither may drift
  if (page.clock === null || Math.abs(offset - page.clock) > 1) page.clock = offset;
  page.clock = Math.min(page.clock + 1e-5, offset);
}

// ——— what does not move ———

function state(words, how = "") {
  $("driver").textContent = words;
  $("driver").className = "state " + how;
  picture.past(how === "bad");
}
function banner(words) { $("banner").hidden = !words; if ($("banner").textContent !== words) $("banner").textContent = words; }

let silence;
function say(answer) {
  $("said").textContent = answer.message;
  $("said").className = answer.ok ? "" : "refused";
  clearTimeout(silence);
  silence = setTimeout(() => { $("said").textContent = ""; }, answer.ok ? 2500 : 8000);
}

const BANNERS = {
  gone: "The driver has stopped. This page waits for it and goes on by itself.",
  stopped: "The driver has stopped. This page waits for it and goes on by itself.",
  died: "The driver has died without stopping: switch the supply off. This page waits for another one.",
  stalled: "The driver's loop stands still.",
};

const STREAM_BANNERS = {
  ended: "The stream has ended. What came last is still here.",
  broken: "The line has broken off. This page waits for it and goes on by itself.",
  silent: "Nothing has come for some seconds.",
};

function status(now) {
  const before = page.status;
  page.status = now;
  state(now.driver, { running: "running", starting: "", waiting: "" }[now.driver] ?? "bad");
  banner(streams() ? now.problem || STREAM_BANNERS[now.driver] : BANNERS[now.driver] ?? (now.dead ?? []).join(" "));
  traffic(now.traffic);
  if (streams()) return streamed(now);
  if (now.driver === "gone") { page.held.clear(); card(); return; }
  const us = (v) => (v >= 1000 ? (v / 1000).toFixed(1) + " ms" : v.toFixed(0) + " µs");
  $("rate").textContent = now.rate_hz === null ? "–" : now.rate_hz.toFixed(0) + " Hz";
  $("missed").textContent = now.missed;
  $("missed").className = now.missed > 0 ? "bad" : "";
  $("late").textContent = `${us(now.lateness_us.p99)} / ${us(now.lateness_us.max)}`;
  $("cycle").textContent = us(now.cycle_us.p99);
  flow(now);
  const usual = usualMode(now.channels);
  now.channels.forEach((channel, i) => {
    const row = page.rows?.[i];
    if (!row) return;
    const odd = channel.health && !channel.fault;
    const words = channel.fault ? channel.fault.flag : odd ? channel.health : page.held.has(i) ? "held" : channel.mode;
    row.mode.textContent = words;
    // names need the room: what all the others do as well is said once, above
    row.mode.hidden = words === usual;
    row.mode.className = "mode" + (channel.fault ? " fault" : odd ? " odd" : page.held.has(i) ? " held" : "");
    row.mode.title = channel.fault ? `${channel.fault.cause}. ${channel.fault.remedy}` : "";
  });
  const faulted = (s) => s?.channels?.[page.selected]?.fault?.flag;
  if (faulted(before) !== faulted(now) || before?.channels?.[page.selected]?.mode !== now.channels[page.selected]?.mode) card();
}

// The mode most channels are in, where there are many of them: said once instead of in every line.
function usualMode(channels) {
  const counts = new Map();
  for (const { mode } of channels) counts.set(mode, (counts.get(mode) ?? 0) + 1);
  const [mode, count] = [...counts].sort((a, b) => b[1] - a[1])[0] ?? [];
  const usual = channels.length > FEW && count > 1 ? mode : null;
  $("usual").textContent = usual === null ? "" : `${count === channels.length ? "all" : count}: ${usual}`;
  return usual;
}

// What is lost on the way here, and what is recorded.
function flow({ lost, recording }) {
  $("lost").textContent = lost + page.lost;
  $("lost").className = lost + page.lost > 0 ? "bad" : "";
  $("record").setAttribute("aria-pressed", String(!!recording));
  $("recording").textContent = recording ? recorded(recording) : "Record";
  $("record").title = recording ? `${recording.file}; click to end` : streams() ? "Record every row, as CSV" : "Record every cycle of every channel";
}

// How a stream does.
function streamed(now) {
  const rate = now.rate_hz;
  $("rate").textContent = rate === null ? "–" : `${rate.toFixed(rate < 10 ? 1 : 0)} /s`;
  $("odd").textContent = now.odd;
  $("odd").className = now.odd > 0 ? "bad" : "";
  $("words").parentElement.hidden = !now.words;
  $("words").textContent = now.words;
  $("words").title = now.words;
  flow(now);
}

// What the scope has refused, of anybody's: shown once there is any.
function traffic({ connections_open, clients_open, refused, refused_in_all }) {
  const kinds = Object.entries(refused).filter(([, count]) => count > 0).map(([name, count]) => `${name.replaceAll("_", " ")}: ${count}`);
  $("traffic").hidden = refused_in_all === 0;
  $("traffic").title = `What this scope has refused, of all who connect to it – ${kinds.join(", ")}. Open now: ${clients_open} pages, ${connections_open} connections.`;
  $("refused").textContent = refused_in_all;
}

function recorded({ seconds, bytes, lost }) {
  const size = bytes >= 1e9 ? (bytes / 1e9).toFixed(2) + " GB" : (bytes / 1e6).toFixed(1) + " MB";
  return `${seconds.toFixed(0)} s, ${size}${lost ? `, ${lost} lost` : ""}`;
}

function channels() {
  page.rows = page.names.map((name, i) => {
    const li = document.createElement("li");
    const shows = button("", "shows", () => toggle(i));
    shows.setAttribute("aria-label", `show ${name}`);
    const of = button(name, "name", () => { page.selected = i; mark(); card(); });
    of.title = name;
    const mode = document.createElement("span"), value = document.createElement("span");
    mode.className = "mode";
    value.className = "value";
    const pin = button("☆", "pin", () => pinned(i));
    pin.setAttribute("aria-label", `pin ${name} to the top`);
    li.append(shows, of, mode, value, pin);
    return { li, shows, mode, value, pin };
  });
  $("finding").hidden = page.names.length <= FEW;
  page.arranged = [];
  arrange();
  groups();
  mark();
}

// ——— many channels: found, ordered, pinned, in groups ———

function pinned(i) {
  if (!page.pinned.delete(i)) page.pinned.add(i);
  mark();
  arrange();
}

// Puts the list into the order that is asked for: pinned ones first, and only those that are looked for.
function arrange() {
  const wanted = $("find").value.trim().toLowerCase(), order = $("order").value, states = page.status?.channels ?? [];
  const fault = (i) => (states[i]?.fault ? 0 : states[i]?.health ? 1 : 2);
  // in steps, and among equals as before: a list that never stands still cannot be read
  const heat = (i) => Math.round((states[i]?.temperature_c ?? -1000) / HEAT_STEP_K);
  const place = new Map(page.arranged.map((i, at) => [i, at]));
  const by = {
    rig: () => 0,
    hottest: (a, b) => heat(b) - heat(a) || (place.get(a) ?? a) - (place.get(b) ?? b),
    faults: (a, b) => fault(a) - fault(b),
  }[order];
  const pins = (i) => (page.pinned.has(i) ? 0 : 1);
  const arranged = page.names.map((_, i) => i).sort((a, b) => pins(a) - pins(b) || by(a, b) || a - b);
  page.rows.forEach((row, i) => row.li.classList.toggle("away", !page.names[i].toLowerCase().includes(wanted)));
  if (arranged.join() === page.arranged.join()) return;
  page.arranged = arranged;
  const focused = document.activeElement;
  $("channels").replaceChildren(...arranged.map((i) => page.rows[i].li));
  if ($("channels").contains(focused)) focused.focus();
}
$("find").oninput = arrange;
$("order").onchange = arrange;
setInterval(() => { if (page.rows && $("order").value !== "rig") arrange(); }, 1000);

// Channels whose names have all but the last word in common, as the joints of a leg: one click shows them alone.
function groups() {
  const found = new Map();
  page.names.forEach((name, i) => {
    const at = name.lastIndexOf("_");
    if (at > 0) found.set(name.slice(0, at), [...(found.get(name.slice(0, at)) ?? []), i]);
  });
  const several = [...found].filter(([, members]) => members.length > 1);
  $("groups").hidden = page.names.length <= FEW || several.length < 2;
  $("groups").replaceChildren(...several.map(([name, members]) => {
    const chip = button(name.replaceAll("_", " "), "", () => { page.shown = new Set(members); page.selected = members[0]; mark(); card(); show(); });
    chip.title = members.map((i) => page.names[i]).join(", ");
    chip.dataset.members = members.join();
    return chip;
  }));
}

// Selects the channel so many lines further down the list.
function step(by) {
  const seen = page.arranged.filter((i) => !page.rows[i].li.classList.contains("away"));
  const at = seen.indexOf(page.selected), next = seen[Math.max(0, Math.min(seen.length - 1, at < 0 ? 0 : at + by))];
  if (next === undefined) return;
  page.selected = next;
  page.rows[next].li.scrollIntoView({ block: "nearest" });
  mark();
  card();
}

function button(words, classes, act) {
  const made = document.createElement("button");
  made.type = "button";
  made.textContent = words;
  made.className = classes;
  made.onclick = act;
  return made;
}

// Marks which channels are shown and which one is selected.
function mark() {
  const dashed = page.shown.size <= DASHED_UP_TO;
  page.rows.forEach((row, i) => {
    row.li.classList.toggle("selected", i === page.selected);
    row.shows.setAttribute("aria-pressed", String(page.shown.has(i)));
    row.shows.replaceChildren(Chart.sample(i, dashed));
    row.pin.setAttribute("aria-pressed", String(page.pinned.has(i)));
    row.pin.textContent = page.pinned.has(i) ? "★" : "☆";
  });
  for (const chip of $("groups").children) chip.setAttribute("aria-pressed", String(chip.dataset.members === [...page.shown].sort((a, b) => a - b).join()));
  $("all").textContent = page.shown.size === page.names.length ? "one" : "all";
}

function toggle(i) {
  if (!page.shown.delete(i)) page.shown.add(i);
  mark();
  show();
}

$("all").onclick = () => {
  const all = page.shown.size === page.names.length;
  page.shown = new Set(all ? [page.selected] : page.names.map((_, i) => i));
  mark();
  show();
};

function quantities() {
  const chips = page.rig.quantities.filter((q) => q.name !== "target_m").map((q) => {
    const chip = button(q.title, "", () => {
      const on = page.quantities.includes(q.name);
      page.quantities = on ? page.quantities.filter((name) => name !== q.name) : [...page.quantities, q.name];
      chip.setAttribute("aria-pressed", String(!on));
      if (!page.quantities.includes(page.focus)) page.focus = page.quantities[0];
      show();
    });
    chip.setAttribute("aria-pressed", String(page.quantities.includes(q.name)));
    return chip;
  });
  $("quantities").replaceChildren(...chips);
}

function windows() {
  const longest = page.rig.span_s;
  $("window").replaceChildren(...WINDOWS.filter((w) => w <= longest * 1.01).map((w) => new Option(`${w} s`, w, false, w === page.window)));
}

$("window").onchange = () => { page.window = Number($("window").value); page.frozen = null; paused(); };

// ——— pause and zoom: a stretch of time that stands still ———

function paused() {
  const still = !!page.frozen;
  $("pause").setAttribute("aria-pressed", String(still));
  $("pause").textContent = still ? "Paused" : "Pause";
  $("live").hidden = !still;
  page.dirty = true;
}

function now() {
  if (!page.curves?.length || page.clock === null) return 0;
  return Math.min(page.curves.last, performance.now() / 1000 - page.clock - BEHIND_S);
}

function span() { return page.frozen ?? { from: now() - page.window, to: now() }; }
function live() { page.frozen = null; paused(); }
$("pause").onclick = () => { page.frozen = page.frozen ? null : span(); paused(); };
$("live").onclick = live;
document.addEventListener("keydown", (event) => {
  if (event.key === "Escape" && event.target === $("find")) { $("find").value = ""; arrange(); $("find").blur(); return; }
  if (event.target.closest("input, select, textarea, dialog") || event.ctrlKey || event.metaKey || event.altKey) return;
  if (event.key === " " && event.target.closest("button")) return;
  const act = KEYS[event.key];
  if (!act || !page.rows) return;
  event.preventDefault();
  act();
});

const KEYS = {
  " ": () => $("pause").click(),
  Escape: live,
  s: save,
  "/": () => $("find").focus(),
  ArrowDown: () => step(1),
  ArrowUp: () => step(-1),
  v: () => toggle(page.selected),
  p: () => pinned(page.selected),
  a: () => $("all").click(),
  "?": () => $("help").showModal(),
};
$("keys").onclick = () => $("help").showModal();

const hands = {
  zoom: (from, to) => { if (to - from > 1e-4) { page.frozen = { from, to }; paused(); } },
  reset: live,
  wheel: (factor, at) => {
    if (page.frozen) {
      const { from, to } = page.frozen;
      const width = Math.min(page.rig.span_s, Math.max(1e-3, (to - from) * factor)), share = (at - from) / (to - from);
      page.frozen = { from: at - share * width, to: at + (1 - share) * width };
      page.dirty = true;
    } else {
      // the live width takes the listed steps
      const options = [...$("window").options].map((o) => Number(o.value)), i = options.indexOf(page.window);
      turned += Math.log(factor);
      if (Math.abs(turned) < 0.3) return;
      page.window = options[Math.max(0, Math.min(options.length - 1, i + Math.sign(turned)))];
      turned = 0;
      $("window").value = page.window;
    }
  },
  cursor: (at) => { page.cursor = at; },
};
let turned = 0;

// ——— the panels ———

function panels() {
  if (!page.curves) build();
}

// Makes the charts anew: for other channels, quantities, sizes or colours.
function build() {
  for (const panel of page.panels) panel.chart.destroy();
  $("panels").replaceChildren();
  const rig = page.rig;
  if (!rig) return;
  const count = page.quantities.length;
  const room = $("panels").clientHeight, width = $("panels").clientWidth;
  const colours = Chart.inks(), inks = colours.series.map(Chart.rgb), pale = Chart.rgb(colours.pale);
  page.panels = page.quantities.map((name) => {
    const quantity = rig.quantities.find((q) => q.name === name);
    const section = document.createElement("section"), title = document.createElement("h2"), unit = document.createElement("span");
    section.className = "panel";
    title.append((streams() ? shownIn(name).map((i) => page.names[i]).join(", ") : quantity.title) + " ", unit);
    section.append(title);
    section.addEventListener("pointerenter", () => { page.focus = name; });
    $("panels").append(section);
    const shown = shownIn(name), targets = name === "length_m" || name === "measured_length_m" ? shown : [];
    const dashed = shown.length <= DASHED_UP_TO, ratio = devicePixelRatio;
    const line = (channel) => ({
      series: page.series.get(`${name} ${channel}`), ink: inks[channel % inks.length], width: (dashed ? 1.5 : 1.2) * ratio,
      dash: dashed ? Chart.dash(channel) : null,
    });
    const target = (channel) => ({ series: page.series.get(`target_m ${channel}`), ink: pale, width: 3 * ratio });
    const panel = {
      name, range: null, ranged: 0, raster: new Chart.Raster(), lines: [...targets.map(target), ...shown.map(line)],
      chart: Chart.make(section, {
        width, height: Math.max(150, Math.floor(room / Math.max(1, count)) - 26), unit: quantity.unit, sync: "scope", hands,
        heading: (text) => { unit.textContent = text; },
        paint: (u) => u.ctx.drawImage(panel.raster.canvas, u.bbox.left, u.bbox.top),
      }),
    };
    return panel;
  });
  page.built += 1;
  page.dirty = true;
}

function draw() {
  const curves = page.curves;
  if (!curves) return;
  const { from: asked, to: until } = span(), at = performance.now();
  for (const panel of page.panels) {
    const { width, height } = panel.chart.bbox;
    // whole columns on a grid of their own, so that a curve that moves is the same curve shifted
    const column = (until - asked) / width, from = Math.floor(asked / column) * column, to = from + width * column;
    const series = panel.lines.map((line) => line.series);
    // the range is looked at as a whole now and then, and by what is new every time
    const whole = panel.range === null || page.frozen || at - panel.ranged > 500;
    const [low, high] = curves.extent(series, whole ? from : Math.max(from, to - 0.3), to);
    if (whole) { panel.range = Chart.steady(panel.range, low, high); panel.ranged = at; }
    else if (low < panel.range[0] || high > panel.range[1]) panel.range = Chart.steady(panel.range, ...curves.extent(series, from, to));
    const view = { width, height, column, from, low: panel.range[0], high: panel.range[1] };
    const lines = panel.lines.map((line) => ({ ...line, ...curves.curve(line.series, from, to) }));
    panel.raster.paint(view, lines, `${page.built} ${page.generation}`);
    Chart.look(panel.chart, from, to, ...panel.range);
  }
}

// The values at the cursor, or the latest ones, beside the channels' names.
function values() {
  const { rig, curves } = page;
  if (!rig || !curves) return;
  const quantity = rig.quantities.find((q) => q.name === page.focus);
  const { to } = span(), at = page.cursor ?? to;
  $("valued").textContent = quantity ? `${streams() ? "Values" : quantity.title} ${page.cursor === null ? (page.frozen ? "at the end" : "now") : "at the cursor"}` : "";
  $("cursor").textContent = page.cursor === null ? "" : `Cursor at ${Chart.quantity(at - to, "1", 4)} s`;
  page.rows.forEach((row, i) => {
    const of = focused(i), series = page.series.get(`${of?.name} ${i}`);
    const value = series === undefined || page.waiting ? null : curves.at(series, at);
    row.value.textContent = value === null ? "" : Chart.quantity(value, of.unit);
  });
  if (streams()) card();
}

// ——— the selected channel: its state, and commands ———

const entry = { kind: "stroke", value: 0.3 };

function limits(kind, channel) {
  return {
    stroke: { low: 0, high: 1, factor: 100, unit: "%", step: 1 },
    length: { low: channel.min_length_m ?? channel.hot_m, high: channel.max_length_m ?? channel.cold_m, factor: 1000, unit: "mm", step: 0.01 },
    duty: { low: 0, high: channel.max_duty ?? 1, factor: 100, unit: "%", step: 0.5 },
    force: { low: 0, high: 10, factor: 1, unit: "N", step: 0.05 },
  }[kind];
}

function card() {
  if (streams()) return summary();
  const host = $("card"), channel = page.rig?.channels[page.selected], state = page.status?.channels?.[page.selected];
  if (!channel) return host.replaceChildren();
  const parts = [];
  const add = (tag, words, classes = "") => { const e = document.createElement(tag); e.textContent = words; e.className = classes; parts.push(e); return e; };
  const title = add("h2", channel.name);
  const small = document.createElement("small");
  small.textContent = state ? state.mode : "";
  title.append(small);
  if (state?.fault) {
    const fault = add("p", "", "fault"), name = document.createElement("b");
    name.textContent = state.fault.flag;
    fault.append(name, `: ${state.fault.cause}. Remedy: ${state.fault.remedy}.`);
  }
  if (!page.may) {
    add("p", !page.rig.commands ? "This scope only watches: it was started with --no-commands."
      : door.needed ? "On the network this page only watches: the scope was started without --lan-commands."
      : "This page only watches. To command, open the address that `sinew scope` printed, with its token.", "note");
    return host.replaceChildren(...parts);
  }
  const held = page.held.get(page.selected);
  const { low, high, factor, unit, step } = limits(entry.kind, channel);
  const clamp = (v) => Math.min(high, Math.max(low, v));
  const kinds = add("div", "", "chips");
  for (const kind of ["stroke", "length", "duty", "force"]) {
    const chip = button(kind, "", () => {
      entry.kind = kind;
      const of = limits(kind, channel);
      entry.value = kind === "stroke" ? 0.3 : kind === "duty" ? 0 : kind === "length" ? (of.low + of.high) / 2 : 1;
      release(page.selected);
      card();
    });
    chip.setAttribute("aria-pressed", String(kind === entry.kind));
    kinds.append(chip);
  }
  entry.value = clamp(entry.value);
  const row = add("div", "", "entry");
  const slider = document.createElement("input"), number = document.createElement("input"), of = document.createElement("span");
  for (const input of [slider, number]) {
    input.min = low * factor; input.max = high * factor; input.step = step;
    input.setAttribute("aria-label", `${entry.kind} in ${unit}`);
  }
  slider.type = "range"; number.type = "number"; number.id = "value";
  const write = () => { slider.value = entry.value * factor; number.value = +(entry.value * factor).toFixed(3); };
  const changed = (text) => {
    if (text === "" || !isFinite(Number(text))) return;
    entry.value = clamp(Number(text) / factor);
    if (page.held.has(page.selected)) { page.held.set(page.selected, { ...entry }); renew(page.selected); }
  };
  slider.oninput = () => { changed(slider.value); write(); };
  number.oninput = () => { changed(number.value); slider.value = entry.value * factor; };
  number.onchange = write;
  write();
  of.textContent = unit;
  row.append(slider, number, of);
  const acts = add("div", "", "chips");
  const hold = button(held ? "Holding: release" : "Hold", "hold", () => (page.held.has(page.selected) ? release(page.selected) : take(page.selected)));
  hold.id = "hold";
  hold.setAttribute("aria-pressed", String(!!held));
  hold.title = "The setpoint is renewed while this is pressed; release it, or close the page, and its lease runs out";
  acts.append(hold, button("Off", "", () => { page.held.delete(page.selected); card(); set(page.selected, "off", 0).then(say); }));
  acts.append(button("All off", "", () => { page.held.clear(); card(); ask("all_off").then(say); }));
  if (state?.fault) acts.append(button("Reset", "", () => ask({ reset: { channel: page.selected } }).then(say)));
  host.replaceChildren(...parts);
}

// The selected column over the time that is shown.
function summary() {
  const host = $("card"), channel = page.rig.channels[page.selected], of = channel && focused(page.selected);
  const series = of && page.series.get(`${of.name} ${page.selected}`);
  if (series === undefined || page.waiting || !page.curves) return host.replaceChildren();
  const { from, to } = span(), sums = page.curves.summary(series, from, to), title = document.createElement("h2"), list = document.createElement("dl");
  title.textContent = channel.name;
  const rows = [["least", sums.low], ["mean", sums.mean], ["largest", sums.high], ["deviation", sums.deviation]];
  for (const [word, value] of rows) {
    const dt = document.createElement("dt"), dd = document.createElement("dd"), row = document.createElement("div");
    dt.textContent = word;
    dd.textContent = Chart.quantity(value, of.unit);
    row.append(dt, dd);
    list.append(row);
  }
  const note = document.createElement("p");
  note.className = "note";
  note.textContent = `of ${sums.count} values in the time shown`;
  host.replaceChildren(title, list, note);
}

// ——— what is shown, as a file ———

function save() {
  const { rig, curves } = page;
  if (!rig || !curves?.length) return;
  const { from, to } = span(), heads = ["time_s"], columns = [];
  for (const quantity of page.quantities) {
    const of = rig.quantities.find((q) => q.name === quantity);
    for (const channel of shownIn(quantity)) {
      const name = rig.channels[channel].name;
      heads.push(streams() ? (of.unit === "1" ? name : `${name} [${of.unit}]`) : `${name}.${quantity}`);
      columns.push(page.series.get(`${quantity} ${channel}`));
    }
  }
  const quoted = (text) => (/[",\n]/.test(text) ? `"${text.replaceAll('"', '""')}"` : text);
  const lines = [heads.map(quoted).join(",")];
  for (let bin = curves.indexOf(from), end = curves.indexOf(to); bin < end; bin++) {
    const cells = columns.map((series) => curves.middle(series, bin)).map((value) => (Number.isNaN(value) ? "" : String(value)));
    lines.push([(curves.time[bin] - curves.time[curves.indexOf(from)]).toFixed(6), ...cells].join(","));
  }
  const link = document.createElement("a");
  link.href = URL.createObjectURL(new Blob([lines.join("\n") + "\n"], { type: "text/csv" }));
  link.download = `${rig.rig}-${new Date().toISOString().slice(0, 19).replaceAll(":", "-")}.csv`;
  link.click();
  setTimeout(() => URL.revokeObjectURL(link.href), 1000);
}
$("save").onclick = save;

const set = (channel, kind, value) => ask({ set: { channel, kind, value, hold_s: HOLD_S } });

async function renew(channel) {
  const held = page.held.get(channel);
  if (!held || held.busy) return;
  held.busy = true;
  const answer = await set(channel, held.kind, held.value);
  held.busy = false;
  if (!answer.ok && page.held.has(channel)) {
    page.held.delete(channel);
    card();
    say(answer);
  }
}

function take(channel) { page.held.set(channel, { ...entry }); card(); renew(channel); }
function release(channel) { if (page.held.delete(channel)) card(); }
setInterval(() => { for (const channel of page.held.keys()) renew(channel); }, RENEW_S * 1000);

$("record").onclick = async () => {
  const on = $("record").getAttribute("aria-pressed") !== "true";
  $("record").disabled = true;
  say(await ask({ record: { on } }));
  $("record").disabled = false;
};

// ——— once a screen frame ———

// How smoothly this page runs: read by whoever measures it, as `scope.statistics()`.
const pace = { frames: 0, since: performance.now(), last: 0, gaps: [], drawn: [] };

function frame(at) {
  if (pace.last) { pace.frames += 1; pace.gaps.push(at - pace.last); if (pace.gaps.length > 6000) pace.gaps.shift(); }
  pace.last = at;
  if (page.curves && (page.dirty || !page.frozen)) {
    const began = performance.now();
    page.dirty = false;
    draw();
    pace.drawn.push(performance.now() - began);
    if (pace.drawn.length > 6000) pace.drawn.shift();
  }
  requestAnimationFrame(frame);
}

function quantile(of, q) { const sorted = Float64Array.from(of).sort(); return sorted.length ? sorted[Math.min(sorted.length - 1, Math.floor(q * sorted.length))] : NaN; }

const scope = {
  statistics: () => ({
    seconds: (performance.now() - pace.since) / 1000, frames: pace.frames,
    fps: pace.frames / ((performance.now() - pace.since) / 1000),
    gap_ms: { p50: quantile(pace.gaps, 0.5), p99: quantile(pace.gaps, 0.99), max: quantile(pace.gaps, 1) },
    draw_ms: { p50: quantile(pace.drawn, 0.5), p99: quantile(pace.drawn, 0.99) },
    bins: page.curves?.length ?? 0, series: page.curves?.series ?? 0, lost: (page.status?.lost ?? 0) + page.lost,
    span: span(), last: page.curves?.last ?? null,
  }),
  restart: () => { Object.assign(pace, { frames: 0, since: performance.now(), last: 0, gaps: [], drawn: [] }); },
};

let counted = { frames: 0, at: performance.now() };
setInterval(() => {
  values();
}, 100);
setInterval(() => {
  const at = performance.now(), frames = pace.frames - counted.frames;
  if (frames >= 0) $("fps").textContent = (frames / ((at - counted.at) / 1000)).toFixed(0) + "/s";
  counted = { frames: pace.frames, at };
}, 1000);
new ResizeObserver(() => { if (page.curves && page.rig) build(); }).observe($("panels"));
matchMedia("(prefers-color-scheme: dark)").addEventListener("change", () => { if (page.curves && page.rig) build(); });
if (door.needed && !door.token) door.ask(); else connect();
requestAnimationFrame(frame);
