"use strict";
// The inflating tail: a surface drawn by hand into a picture, so that it needs neither a library nor a graphics card.
(function () {
  const canvas = document.getElementById("stage");
  const data = JSON.parse(document.getElementById("bodies").textContent);
  if (!canvas || data.length === 0) return;
  const ask = (id) => document.getElementById(id);
  const ink = canvas.getContext("2d");
  const bytes = (text) => Uint8Array.from(atob(text), (c) => c.charCodeAt(0)).buffer;
  const bodies = data.map((b) => ({ ...b, at: new Int16Array(bytes(b.at)), faces: new Uint32Array(bytes(b.faces)) }));
  const state = { body: 0, level: 0, turn: -0.55, tilt: 0.75, zoom: 1, cut: false, far: false, playing: false };
  let width = 0, height = 0, picture = null, depth = null, waiting = false;

  function resize() {
    const dots = Math.min(window.devicePixelRatio || 1, 1.5);
    width = Math.max(1, Math.round(canvas.clientWidth * dots));
    height = Math.max(1, Math.round(canvas.clientHeight * dots));
    canvas.width = width; canvas.height = height;
    picture = ink.createImageData(width, height);
    depth = new Float32Array(width * height);
    redraw();
  }

  // points between two levels, in metres, and how far each has moved
  function points(body, level) {
    const low = Math.min(Math.floor(level), body.levels.length - 1), high = Math.min(low + 1, body.levels.length - 1);
    const part = level - low, n = 3 * body.count, out = new Float32Array(n), far = new Float32Array(body.count);
    for (let i = 0; i < n; i++) {
      const a = body.at[low * n + i], b = body.at[high * n + i];
      out[i] = (a + part * (b - a)) * body.scale;
    }
    for (let i = 0; i < body.count; i++) {
      const d = [0, 1, 2].map((k) => out[3 * i + k] - body.at[3 * i + k] * body.scale);
      far[i] = Math.hypot(d[0], d[1], d[2]);
    }
    return { out, far };
  }

  const heat = [[68, 1, 84], [59, 81, 139], [33, 144, 141], [92, 200, 99], [253, 231, 37]];
  function hot(part) {
    const p = Math.min(Math.max(part, 0), 0.9999) * 4, k = Math.floor(p), f = p - k;
    return heat[k].map((v, i) => v + f * (heat[k + 1][i] - v));
  }

  function draw() {
    waiting = false;
    const body = bodies[state.body], { out, far } = points(body, state.level);
    const ct = Math.cos(state.turn), st = Math.sin(state.turn), cu = Math.cos(state.tilt), su = Math.sin(state.tilt);
    const zoom = state.zoom * Math.min(width / (1.25 * body.reach), height / (0.95 * body.reach));
    const n = body.count, seen = new Float32Array(6 * n), sides = body.half && !state.cut ? [1, -1] : body.half ? [-1] : [1];
    picture.data.fill(255); depth.fill(Infinity);
    for (const side of sides) {
      for (let i = 0; i < n; i++) {
        const x = out[3 * i] - body.middle[0], y = out[3 * i + 1] - body.middle[1], z = side * out[3 * i + 2];
        const a = ct * x - st * y, b = st * x + ct * y;
        seen[3 * i] = width / 2 + zoom * a;
        seen[3 * i + 1] = height / 2 - zoom * (su * b + cu * z);
        seen[3 * i + 2] = cu * b - su * z;
      }
      let first = 0;
      for (const group of body.groups) {
        if (!group.inside || state.cut) surface(body, seen, far, first, group, zoom);
        first += 3 * group.count;
      }
    }
    ink.putImageData(picture, 0, 0);
    ink.fillStyle = "#1a1a1a"; ink.font = Math.round(height / 26) + "px sans-serif";
    ink.fillText(body.name, 12, Math.round(height / 18));
  }

  // one surface: normals by node, then its triangles row by row into the picture
  function surface(body, seen, far, first, group, zoom) {
    const last = first + 3 * group.count, f = body.faces, normal = new Float32Array(3 * body.count);
    for (let t = first; t < last; t += 3) {
      const [a, b, c] = [3 * f[t], 3 * f[t + 1], 3 * f[t + 2]];
      const u = [seen[b] - seen[a], seen[b + 1] - seen[a + 1]], v = [seen[c] - seen[a], seen[c + 1] - seen[a + 1]];
      const du = (seen[b + 2] - seen[a + 2]) * zoom, dv = (seen[c + 2] - seen[a + 2]) * zoom;
      const nx = u[1] * dv - du * v[1], ny = du * v[0] - u[0] * dv, nz = u[0] * v[1] - u[1] * v[0];
      for (const i of [a, b, c]) { normal[i] += nx; normal[i + 1] += ny; normal[i + 2] += nz; }
    }
    const most = body.most || 1, shade = new Float32Array(3 * body.count), done = new Uint8Array(body.count);
    for (let t = first; t < last; t++) {
      const i = f[t];
      if (done[i]) continue;
      done[i] = 1;
      const [x, y, z] = [normal[3 * i], normal[3 * i + 1], normal[3 * i + 2]], size = Math.hypot(x, y, z) || 1;
      const sign = z < 0 ? -1 : 1, light = Math.max(0, sign * (0.3 * x + 0.5 * y + 0.8 * z) / size);
      const colour = state.far && !group.inside ? hot(far[i] / most) : group.colour;
      for (let k = 0; k < 3; k++) shade[3 * i + k] = Math.min(255, colour[k] * (0.42 + 0.62 * light));
    }
    for (let t = first; t < last; t += 3) triangle(seen, shade, f[t], f[t + 1], f[t + 2]);
  }

  function triangle(seen, shade, i, j, k) {
    const [ax, ay, az] = [seen[3 * i], seen[3 * i + 1], seen[3 * i + 2]];
    const [bx, by, bz] = [seen[3 * j], seen[3 * j + 1], seen[3 * j + 2]];
    const [cx, cy, cz] = [seen[3 * k], seen[3 * k + 1], seen[3 * k + 2]];
    const area = (bx - ax) * (cy - ay) - (by - ay) * (cx - ax);
    if (area === 0) return;
    const top = Math.max(0, Math.ceil(Math.min(ay, by, cy))), low = Math.min(height - 1, Math.floor(Math.max(ay, by, cy)));
    const left = Math.max(0, Math.ceil(Math.min(ax, bx, cx))), right = Math.min(width - 1, Math.floor(Math.max(ax, bx, cx)));
    const dots = picture.data;
    for (let y = top; y <= low; y++) {
      for (let x = left; x <= right; x++) {
        const v = ((x - ax) * (cy - ay) - (y - ay) * (cx - ax)) / area, w = ((bx - ax) * (y - ay) - (by - ay) * (x - ax)) / area;
        const u = 1 - v - w;
        if (u < -1e-4 || v < -1e-4 || w < -1e-4) continue;
        const z = u * az + v * bz + w * cz, at = y * width + x;
        if (z >= depth[at]) continue;
        depth[at] = z;
        for (let c = 0; c < 3; c++) dots[4 * at + c] = u * shade[3 * i + c] + v * shade[3 * j + c] + w * shade[3 * k + c];
      }
    }
  }

  function redraw() { if (!waiting) { waiting = true; requestAnimationFrame(draw); } }

  function told() {
    const body = bodies[state.body], low = Math.floor(state.level), high = Math.min(low + 1, body.levels.length - 1);
    const mbar = body.levels[low] + (state.level - low) * (body.levels[high] - body.levels[low]);
    ask("pressure").textContent = mbar.toFixed(0) + " mbar";
  }

  function choose(index) {
    state.body = index;
    const body = bodies[index];
    ask("level").max = body.levels.length - 1;
    ask("cut").disabled = !body.half;
    if (!body.half) { state.cut = false; ask("cut").checked = false; }
    slide(Math.min(state.level, body.levels.length - 1));
  }

  function slide(level) { state.level = level; ask("level").value = level; told(); redraw(); }

  let began = 0;
  function play(now) {
    if (!state.playing) return;
    const top = bodies[state.body].levels.length - 1;
    slide(top * 0.5 * (1 - Math.cos((now - began) / 1100)));
    requestAnimationFrame(play);
  }

  bodies.forEach((b, i) => ask("body").add(new Option(b.name, i)));
  ask("body").onchange = (e) => choose(Number(e.target.value));
  ask("level").oninput = (e) => { state.playing = false; ask("play").textContent = "play"; slide(Number(e.target.value)); };
  ask("cut").onchange = (e) => { state.cut = e.target.checked; redraw(); };
  ask("far").onchange = (e) => { state.far = e.target.checked; redraw(); };
  ask("play").onclick = () => {
    state.playing = !state.playing;
    ask("play").textContent = state.playing ? "stop" : "play";
    if (state.playing) { began = performance.now(); requestAnimationFrame(play); }
  };
  let held = null;
  canvas.onpointerdown = (e) => { held = [e.clientX, e.clientY]; canvas.setPointerCapture(e.pointerId); };
  canvas.onpointerup = () => { held = null; };
  canvas.onpointermove = (e) => {
    if (!held) return;
    state.turn += 0.01 * (e.clientX - held[0]);
    state.tilt = Math.min(1.57, Math.max(-1.57, state.tilt + 0.01 * (e.clientY - held[1])));
    held = [e.clientX, e.clientY];
    redraw();
  };
  canvas.onwheel = (e) => { e.preventDefault(); state.zoom = Math.min(8, Math.max(0.4, state.zoom * Math.exp(-0.001 * e.deltaY))); redraw(); };
  window.onresize = resize;
  choose(0);
  resize();
  slide(bodies[0].levels.length - 1);
})();
