"use strict";
(function () {
  const seen = { errors: [], pressures: [] };
  window.onerror = (message) => { seen.errors.push(String(message)); };
  // nothing is shown, so nothing asks for frames: the clock does
  window.requestAnimationFrame = (draw) => setTimeout(() => draw(performance.now()), 16);
  let canvas = null;
  const ask = (id) => document.getElementById(id);
  const frame = () => new Promise((done) => requestAnimationFrame(() => requestAnimationFrame(done)));
  const dots = () => canvas.getContext("2d").getImageData(0, 0, canvas.width, canvas.height).data;
  const mark = () => dots().reduce((sum, value, i) => (sum + value * (1 + i % 9973)) % 4294967291, 0);
  let last = 0;
  async function changed(act) {
    act();
    await frame();
    const now = mark(), differs = now !== last;
    last = now;
    return differs;
  }
  const slide = (level) => () => {
    ask("level").value = level;
    ask("level").dispatchEvent(new Event("input"));
  };
  const pointer = (kind, x, y) => canvas.dispatchEvent(new PointerEvent(kind, { clientX: x, clientY: y }));
  const drag = () => { pointer("pointerdown", 100, 100); pointer("pointermove", 160, 130); pointer("pointerup", 160, 130); };
  const told = () => seen.pressures.push(ask("pressure").textContent);
  async function read() {
    canvas = ask("stage");
    canvas.setPointerCapture = () => {}; // a pointer that is played cannot be held
    await frame();
    last = mark();
    told();
    const data = dots();
    seen.dots = 0;
    for (let i = 0; i < data.length; i += 4) seen.dots += data[i] + data[i + 1] + data[i + 2] < 700;
    seen.inflated = await changed(slide("0"));
    told();
    ask("level").step = "any";
    seen.inflated = (await changed(slide("0.5"))) && seen.inflated;
    told();
    seen.turned = await changed(drag);
    seen.nearer = await changed(() => canvas.dispatchEvent(new WheelEvent("wheel", { deltaY: -300 })));
    seen.cut = await changed(() => ask("cut").click());
    seen.coloured = await changed(() => ask("far").click());
    seen.another = await changed(() => { ask("body").value = "1"; ask("body").dispatchEvent(new Event("change")); });
    const answer = document.createElement("pre");
    answer.id = "seen";
    answer.textContent = JSON.stringify(seen);
    document.body.append(answer);
  }
  window.addEventListener("load", read);
})();
