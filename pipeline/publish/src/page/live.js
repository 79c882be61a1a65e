"use strict";
// The reduced tail, live: stepped in time with the clock, drawn from above, beside the recorded path of its marker.
(function () {
  const canvas = document.getElementById("live-tail"), data = JSON.parse(document.getElementById("tails").textContent);
  if (!canvas || data.length === 0) return;
  const ask = (id) => document.getElementById("live-" + id), ink = canvas.getContext("2d");
  const RATE = 240, RAMP = 0.15, SHARPNESS = 6, TRACE = 480;
  const bytes = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0)).buffer;
  let tail = null, twin = null, state = null, path = [], begun = 0, playing = false, factor = 0;

  function choose(index) {
    tail = data[index];
    twin = Twin(bytes(tail.arrays));
    const number = (name) => [twin.outputs.indexOf(name + "_x"), twin.outputs.indexOf(name + "_y")];
    tail.tip = number(tail.marker);
    tail.stations = [];
    for (let i = 0; number("station" + i)[0] >= 0; i++) tail.stations.push(number("station" + i));
    updateSliderLabels();
    restart();
  }

  function updateSliderLabels() {
    ask("pressure").textContent = `${(tail.highest * ask("amplitude").value / 100).toFixed(0)} mbar`;
    ask("hertz").textContent = `${Number(ask("frequency").value).toFixed(1)} Hz`;
  }

  function restart() { state = twin.start(); path = []; begun = performance.now(); draw(); }

  // index of the frame before a time, and the part of the way to the next
  function frame(t) {
    const time = tail.time, last = time.length - 2;
    let low = 0, high = last;
    while (low < high) { const middle = (low + high + 1) >> 1; if (time[middle] <= t) low = middle; else high = middle - 1; }
    return [low, Math.min(Math.max((t - time[low]) / (time[low + 1] - time[low]), 0), 1)];
  }

  function recorded(t) {
    const [i, part] = frame(t);
    return tail.pressures.map((own) => own[i] + part * (own[i + 1] - own[i]));
  }

  function wave(t) {
    const ease = Math.min(t / RAMP, 1), size = tail.highest * ask("amplitude").value * ease * ease * (3 - 2 * ease);
    const phase = SHARPNESS * Math.sin(2 * Math.PI * ask("frequency").value * t);
    return Array.from({ length: twin.chambers }, (_, c) => (c < 2 ? size / (1 + Math.exp((c === 0 ? -1 : 1) * phase)) : 0));
  }

  // steps up to the clock, for at most a frame's time: a slow computer shows a slow motion
  function advance(now) {
    const until = Math.min((now - begun) / 1000, state.time + 0.1), from = performance.now(), before = state.time;
    while (state.time < until && performance.now() - from < 14) {
      const time = state.time + 1 / RATE;
      if (!twin.step(state, ask("recorded").checked ? recorded(time) : wave(time), 1 / RATE)) { restart(); return; }
      path.push(tail.tip.map((n) => twin.output(state, n)));
      if (path.length > TRACE) path.shift();
    }
    const spent = performance.now() - from;
    if (state.time > before && spent > 0) factor += 0.05 * (1000 * (state.time - before) / spent - factor);
    if ((now - begun) / 1000 > state.time + 0.2) begun = now - 1000 * state.time;
    if (ask("recorded").checked && state.time > tail.time[tail.time.length - 1]) restart();
  }

  function line(points, colour, width) {
    ink.strokeStyle = colour; ink.lineWidth = width; ink.lineJoin = ink.lineCap = "round"; ink.beginPath();
    points.forEach(([x, y], i) => (i ? ink.lineTo(x, y) : ink.moveTo(x, y)));
    ink.stroke();
  }

  function fill(points, colour) {
    ink.fillStyle = colour; ink.beginPath();
    points.forEach(([x, y], i) => (i ? ink.lineTo(x, y) : ink.moveTo(x, y)));
    ink.fill();
  }

  // one side of a body that narrows to a tenth of its half width
  function flank(bones, half) {
    const last = bones.length - 1;
    return bones.map(([x, y], i) => {
      const [a, b] = [bones[Math.max(i - 1, 0)], bones[Math.min(i + 1, last)]], length = Math.hypot(b[0] - a[0], b[1] - a[1]);
      const aside = half * (1 - 0.9 * i / last) / length;
      return [x - aside * (b[1] - a[1]), y + aside * (b[0] - a[0])];
    });
  }

  // stations lie evenly between the clamp and the end; the marker's path is drawn beside the tail, x twice as large
  function draw() {
    const dots = Math.min(window.devicePixelRatio || 1, 2), width = canvas.clientWidth * dots, height = canvas.clientHeight * dots;
    canvas.width = width; canvas.height = height;
    const scale = 0.75 * width / (1.1 * tail.length), n = tail.stations.length, end = 1.09 * tail.length;
    const place = (x, y) => [0.08 * width + scale * x, 0.5 * height - scale * y];
    const axis = tail.stations.map(([x, y], i) => [end * (i + 1) / n + twin.output(state, x), twin.output(state, y)]);
    const bones = [[0, 0], ...axis].map(([x, y]) => place(x, y));
    fill([...flank(bones, scale * 0.01), ...flank(bones, -scale * 0.01).reverse()], "#d9b38c");
    line(bones, "#1a1a1a", 2 * dots);
    const home = [0.93 * width, 0.5 * height], near = ([x, y]) => [home[0] + 2 * scale * x, home[1] - scale * y];
    if (ask("recorded").checked && tail.time.length > 1) {
      const [last] = frame(state.time), first = frame(Math.max(0, state.time - TRACE / RATE))[0];
      line(tail.measured.slice(first, last + 1).map(([x, y]) => near([1e-6 * x, 1e-6 * y])), "#e69f00", 3 * dots);
    }
    line(path.map(near), "#0072b2", 1.5 * dots);
    ask("said").textContent = `${state.time.toFixed(1)} s, ${factor.toFixed(1)} times real time, tip ${(1000 * twin.output(state, tail.tip[1])).toFixed(1)} mm`;
  }

  function play(now) { if (!playing) return; advance(now); draw(); requestAnimationFrame(play); }

  data.forEach((one, i) => ask("name").add(new Option(one.name, i)));
  ask("name").onchange = (e) => choose(Number(e.target.value));
  ask("recorded").onchange = restart;
  ask("amplitude").oninput = ask("frequency").oninput = updateSliderLabels;
  ask("play").onclick = () => {
    playing = !playing;
    ask("play").textContent = playing ? "stop" : "play";
    if (playing) { begun = performance.now() - 1000 * state.time; requestAnimationFrame(play); }
  };
  choose(0);
})();
