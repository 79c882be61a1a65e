"use strict";
// A reduced tail that steps in a browser: the equations and the method of the crate `twin`, point by point in double precision.
function Twin(buffer) {
  const view = new DataView(buffer), length = Number(view.getBigUint64(0, true));
  const header = JSON.parse(new TextDecoder().decode(new Uint8Array(buffer, 8, length)));
  const array = (name) => {
    const [from, to] = header[name].data_offsets;
    return new Float64Array(buffer.slice(8 + length + from, 8 + length + to));
  };
  const count = (part) => { let n = 0; while (header[part.replace("#", n)]) n++; return n; };
  const mass = array("mass"), size = array("size")[0], r = Math.round(Math.sqrt(mass.length)), rr = r * r;
  const regions = Array.from({ length: count("region#.moduli") }, (_, i) => {
    const of = (part) => array(`region${i}.${part}`), [mu, lambda, c20, c30] = of("moduli"), flat = of("branches");
    const branches = Array.from({ length: flat.length / 2 }, (_, b) => [flat[2 * b], flat[2 * b + 1]]);
    return { mu, lambda, c20, c30, branches, weights: of("weights"), gradients: of("gradients") };
  });
  const chambers = Array.from({ length: count("chamber#.at_rest") }, (_, i) =>
    ["linear", "quadratic", "cubic"].map((part) => array(`chamber${i}.${part}`)));
  const [slope, value, by] = ["slope", "value", "by"].map((part) => array(`sections.${part}`));
  const rows = array("outputs"), names = header.__metadata__.outputs.split(",");
  const MAX_ITERATIONS = 30, REFRESH_ABOVE = 0.1, TOLERANCE = 1e-6, SLOW = 360, LEAST = 1e-11, HALVINGS = 6, KEPT = 5, NEARER = 0.005;
  const zeros = (n) => new Float64Array(n);
  const add = (sum, factor, term) => { for (let i = 0; i < sum.length; i++) sum[i] += factor * term[i]; };
  const largest = (x) => { let most = 0; for (const v of x) most = Number.isNaN(v) ? NaN : Math.max(most, Math.abs(v)); return most; };
  const F = zeros(9), G = zeros(9), P = zeros(9), C = zeros(81), S = zeros(6);

  function start() {
    const history = (region) => zeros(region.branches.length ? 6 * region.weights.length * (1 + region.branches.length) : 0);
    return {
      time: 0, times: [0], q: [zeros(r)], v: [zeros(r)], momentum: [zeros(r)], order: 1, lagged: null, tangents: 0, residuals: 0,
      pressures: chambers.map(() => 0), histories: regions.map(history), stresses: regions.map(() => null), step: 0, factors: [],
    };
  }

  // F and its cofactor over J at a point, and what the law takes of them: [ln J, secant, curvature]
  function deform(g, at, q, acting) {
    let a = 1, b = 0, c = 0, d = 0, e = 1, f = 0, h = 0, i = 0, j = 1;
    for (let m = 0, o = at; m < r; m++, o += 9) {
      const by = q[m];
      a += g[o] * by; b += g[o + 1] * by; c += g[o + 2] * by; d += g[o + 3] * by; e += g[o + 4] * by;
      f += g[o + 5] * by; h += g[o + 6] * by; i += g[o + 7] * by; j += g[o + 8] * by;
    }
    F[0] = a; F[1] = b; F[2] = c; F[3] = d; F[4] = e; F[5] = f; F[6] = h; F[7] = i; F[8] = j;
    G[0] = F[4] * F[8] - F[7] * F[5]; G[3] = F[7] * F[2] - F[1] * F[8]; G[6] = F[1] * F[5] - F[4] * F[2];
    G[1] = F[6] * F[5] - F[3] * F[8]; G[4] = F[0] * F[8] - F[6] * F[2]; G[7] = F[3] * F[2] - F[0] * F[5];
    G[2] = F[3] * F[7] - F[6] * F[4]; G[5] = F[6] * F[1] - F[0] * F[7]; G[8] = F[0] * F[4] - F[3] * F[1];
    const J = F[0] * G[0] + F[1] * G[1] + F[2] * G[2];
    let x = -3;
    for (let k = 0; k < 9; k++) { G[k] /= J; x += F[k] * F[k]; }
    const ln = Math.log(J);
    x -= 2 * ln;
    return [ln, acting.mu + 2 * (2 * acting.c20 + 3 * acting.c30 * x) * x, 4 * (2 * acting.c20 + 6 * acting.c30 * x)];
  }

  // I − C⁻¹ at the point that was deformed last: xx, yy, zz, yz, xz, xy
  const PAIRS = [[0, 0], [1, 1], [2, 2], [1, 2], [0, 2], [0, 1]];
  function relaxing(into, at) {
    for (let n = 0; n < 6; n++) {
      const [a, b] = PAIRS[n], i = 3 * a, k = 3 * b;
      into[at + n] = (n < 3 ? 1 : 0) - G[i] * G[k] - G[i + 1] * G[k + 1] - G[i + 2] * G[k + 2];
    }
  }

  const WHOLE = [0, 5, 4, 5, 1, 3, 4, 3, 2];
  // sum += A H for the symmetric H at `at`
  function addProduct(sum, A, H, at) {
    for (let k = 0; k < 3; k++) for (let i = 0; i < 3; i++)
      for (let l = 0; l < 3; l++) sum[3 * k + i] += A[3 * l + i] * H[at + WHOLE[3 * l + k]];
  }

  function addForces(region, q, acting, forces) {
    const n = region.weights.length, left = { relaxing: zeros(6 * n), law: zeros(6 * n) };
    for (let p = 0; p < n; p++) {
      const at = 9 * r * p, [ln, secant] = deform(region.gradients, at, q, acting), pressed = region.lambda * ln;
      for (let k = 0; k < 9; k++) P[k] = secant * F[k] + (pressed - secant) * G[k];
      if (acting.held) addProduct(P, F, acting.held, 6 * p);
      relaxing(left.relaxing, 6 * p);
      for (let k = 0; k < 6; k++) left.law[6 * p + k] = (secant - pressed) * left.relaxing[6 * p + k] + (k < 3 ? pressed : 0);
      addWork(region.gradients, at, region.weights[p], forces);
    }
    return left;
  }

  // forces += w Gᵀ P
  function addWork(g, at, w, forces) {
    const [a, b, c, d, e, f, h, i, j] = P;
    for (let m = 0, o = at; m < r; m++, o += 9) {
      forces[m] += w * (g[o] * a + g[o + 1] * b + g[o + 2] * c + g[o + 3] * d + g[o + 4] * e
        + g[o + 5] * f + g[o + 6] * h + g[o + 7] * i + g[o + 8] * j);
    }
  }

  // ∂P/∂F at a point into C, its geometric part with the stress before the step
  function pointTangent(region, acting, before, p, [ln, secant, curvature]) {
    const geometric = secant - region.lambda * ln;
    relaxing(S, 0);
    for (let k = 0; k < 6; k++) {
      const now = (secant - region.lambda * ln) * S[k] + (k < 3 ? region.lambda * ln : 0);
      S[k] = (acting.held ? acting.held[6 * p + k] : 0) + (before ? before.law[6 * p + k] - now : 0);
    }
    for (let b = 0; b < 9; b++) {
      const k = b % 3, L = b - k, bent = curvature * (F[b] - G[b]), along = region.lambda * G[b] - bent;
      for (let a = 0; a < 9; a++) {
        const i = a % 3;
        C[9 * b + a] = geometric * G[i + L] * G[k + a - i] + along * G[a] + bent * F[a];
      }
      C[10 * b] += secant;
      for (let J = 0; J < 3; J++) C[9 * b + k + 3 * J] += S[WHOLE[L + J]];
    }
  }

  function addStiffness(region, q, acting, before, K) {
    const g = region.gradients;
    for (let p = 0; p < region.weights.length; p++) {
      const at = 9 * r * p, w = region.weights[p];
      pointTangent(region, acting, before, p, deform(g, at, q, acting));
      for (let m = 0; m < r; m++) addImage(g, at, m, w, K);
    }
  }

  // the upper triangle's row m of K += w Gᵀ C G
  function addImage(g, at, m, w, K) {
    const o = at + 9 * m;
    const row = (a) => w * (C[a] * g[o] + C[a + 9] * g[o + 1] + C[a + 18] * g[o + 2] + C[a + 27] * g[o + 3] + C[a + 36] * g[o + 4]
      + C[a + 45] * g[o + 5] + C[a + 54] * g[o + 6] + C[a + 63] * g[o + 7] + C[a + 72] * g[o + 8]);
    const a = row(0), b = row(1), c = row(2), d = row(3), e = row(4), f = row(5), h = row(6), i = row(7), j = row(8);
    for (let n = m, k = o; n < r; n++, k += 9) {
      K[m * r + n] += g[k] * a + g[k + 1] * b + g[k + 2] * c + g[k + 3] * d + g[k + 4] * e
        + g[k + 5] * f + g[k + 6] * h + g[k + 7] * i + g[k + 8] * j;
    }
  }

  // tangent, velocity, normal and the rest of a section
  function section(n, q, v) {
    const t = [1, 0], u = [0, 0];
    for (let k = 0; k < 2; k++) for (let m = 0, o = (2 * n + k) * r; m < r; m++) { t[k] += slope[o + m] * q[m]; u[k] += value[o + m] * v[m]; }
    const normal = [-t[1], t[0]], w = u[1] * t[0] - u[0] * t[1], along = u[0] * t[0] + u[1] * t[1];
    return { t, u, normal, w, along, flux: [0, 1].map((k) => w * (along * normal[k] - 0.5 * w * t[k])) };
  }

  function addWater(q, v, gamma, forces, momentum) {
    for (let n = 0; n < by.length / 4; n++) {
      const { normal, w, flux } = section(n, q, v), [m, drag, sheds, leaves] = by.subarray(4 * n, 4 * n + 4);
      const resists = gamma * m * w + drag * Math.abs(w) * w;
      for (let k = 0; k < 2; k++) for (let i = 0, o = (2 * n + k) * r; i < r; i++) {
        forces[i] += value[o + i] * (resists * normal[k] - leaves * flux[k]) + slope[o + i] * sheds * flux[k];
        momentum[i] += value[o + i] * m * w * normal[k];
      }
    }
  }

  function addWaterStiffness(q, v, gamma, K) {
    for (let n = 0; n < by.length / 4; n++) {
      const { t, u, normal, w, along } = section(n, q, v), [m, drag, sheds, leaves] = by.subarray(4 * n, 4 * n + 4);
      const held = gamma * m + drag * Math.abs(w), o = 2 * n * r;
      for (let c = 0; c < r; c++) {
        const dt = [slope[o + c], slope[o + r + c]], du = [gamma * value[o + c], gamma * value[o + r + c]], turned = [-dt[1], dt[0]];
        const dw = du[1] * t[0] + u[1] * dt[0] - du[0] * t[1] - u[0] * dt[1];
        const da = du[0] * t[0] + u[0] * dt[0] + du[1] * t[1] + u[1] * dt[1];
        for (let k = 0; k < 2; k++) {
          const flux = (da * w + along * dw) * normal[k] + along * w * turned[k] - w * dw * t[k] - 0.5 * w * w * dt[k];
          const push = (held + drag * Math.abs(w)) * dw * normal[k] + held * w * turned[k] - leaves * flux;
          for (let i = 0; i < r; i++) K[i * r + c] += value[o + k * r + i] * push + slope[o + k * r + i] * sheds * flux;
        }
      }
    }
  }

  function pressureWork(pressures) {
    const work = [zeros(r), zeros(rr), zeros(rr * (r + 1) / 2)];
    chambers.forEach((parts, c) => parts.forEach((part, i) => add(work[i], pressures[c], part)));
    return work;
  }

  function subtractPressure([a, B, cubic], q, forces, K) {
    for (let i = 0; i < r; i++) {
      forces && (forces[i] -= a[i]);
      for (let j = 0; j < r; j++) { if (forces) forces[j] -= q[i] * B[i * r + j]; else K[i * r + j] -= B[i * r + j]; }
    }
    for (let i = 0, o = 0; i < r; i++) for (let j = i; j < r; j++, o += r) {
      const both = (i === j ? 0.5 : 1) * q[i] * q[j];
      for (let k = 0; k < r; k++) {
        if (forces) { forces[k] -= both * cubic[o + k]; continue; }
        K[i * r + k] -= q[j] * cubic[o + k];
        if (i !== j) K[j * r + k] -= q[i] * cubic[o + k];
      }
    }
  }

  // what acts in a step from `state` over `h` seconds under `pressures`
  function equations(state, pressures, h) {
    const before = state.times.length > 1 ? h / (state.times[0] - state.times[1]) : 0;
    const gamma = before ? (1 + 2 * before) / ((1 + before) * h) : 1 / h;
    const weights = before ? [-(1 + before) / h, before * before / ((1 + before) * h)] : [-1 / h];
    const past = [state.q, state.v, state.momentum].map((of) => {
      const sum = zeros(r);
      weights.forEach((w, i) => add(sum, w, of[i]));
      return sum;
    });
    const acting = regions.map((region, i) => {
      const factors = state.factors[i], gain = factors.reduce((sum, f) => sum + f.gain, 0), history = state.histories[i];
      const held = factors.length ? zeros(6 * region.weights.length) : null, each = 6 * (1 + factors.length);
      for (let p = 0; held && p < region.weights.length; p++) for (let k = 0; k < 6; k++) {
        let sum = -gain * history[p * each + k];
        factors.forEach((f, b) => { sum += f.decay * history[p * each + 6 * (b + 1) + k]; });
        held[6 * p + k] = region.mu * sum;
      }
      return { mu: region.mu * (1 + gain), c20: region.c20, c30: region.c30, held };
    });
    return { gamma, past, acting, work: pressureWork(pressures) };
  }

  function residual(state, own, q) {
    state.residuals++;
    const v = own.past[0].slice(), acceleration = own.past[1].slice(), forces = zeros(r), momentum = zeros(r);
    add(v, own.gamma, q);
    add(acceleration, own.gamma, v);
    for (let i = 0; i < r; i++) for (let k = 0; k < r; k++) forces[i] += mass[i * r + k] * acceleration[k];
    addWater(q, v, own.gamma, forces, momentum);
    if (by.length) add(forces, 1, own.past[2]);
    const stresses = regions.map((region, i) => addForces(region, q, own.acting[i], forces));
    subtractPressure(own.work, q, forces, null);
    return { forces, stresses };
  }

  function tangent(state, own, q) {
    state.tangents++;
    const K = zeros(rr), v = own.past[0].slice();
    add(K, own.gamma * own.gamma, mass);
    add(v, own.gamma, q);
    const upper = zeros(rr);
    regions.forEach((region, i) => addStiffness(region, q, own.acting[i], state.stresses[i], upper));
    for (let m = 0; m < r; m++) for (let n = 0; n < r; n++) K[m * r + n] += upper[Math.min(m, n) * r + Math.max(m, n)];
    subtractPressure(own.work, q, null, K);
    addWaterStiffness(q, v, own.gamma, K);
    return { inverse: inverted(K), gamma: own.gamma };
  }

  function inverted(A) {
    const B = zeros(rr);
    for (let i = 0; i < r; i++) B[i * r + i] = 1;
    for (let c = 0; c < r; c++) {
      let pivot = c;
      for (let i = c; i < r; i++) if (Math.abs(A[i * r + c]) >= Math.abs(A[pivot * r + c])) pivot = i;
      const by = A[pivot * r + c];
      for (const M of [A, B]) for (let k = 0; k < r; k++) {
        const kept = M[pivot * r + k];
        M[pivot * r + k] = M[c * r + k];
        M[c * r + k] = kept / by;
      }
      for (let i = 0; i < r; i++) {
        if (i === c) continue;
        const f = A[i * r + c];
        for (const M of [A, B]) for (let k = 0; k < r; k++) M[i * r + k] -= f * M[c * r + k];
      }
    }
    return B;
  }

  function times(A, x) {
    const image = zeros(r);
    for (let i = 0; i < r; i++) for (let k = 0; k < r; k++) image[i] += A[i * r + k] * x[k];
    return image;
  }

  // the change by a lagged inverse after Broyden's update, or null where it converges too slowly
  function nextChange(lagged, before, forces) {
    const change = times(lagged.inverse, forces);
    if (!before) return change;
    let along = 0, length = 0;
    for (let i = 0; i < r; i++) { along += before[i] * change[i]; length += before[i] * before[i]; }
    const left = length - along;
    if (largest(change) > REFRESH_ABOVE * largest(before) || left < 0.1 * length) return null;
    const row = zeros(r);
    for (let i = 0; i < r; i++) for (let k = 0; k < r; k++) row[k] += before[i] * lagged.inverse[i * r + k];
    for (let i = 0; i < r; i++) for (let k = 0; k < r; k++) lagged.inverse[i * r + k] += change[i] / left * row[k];
    return change.map((x) => x * length / left);
  }

  function extrapolated(state, count, time) {
    const at = state.times.slice(0, count), sum = zeros(r);
    at.forEach((own, i) => {
      add(sum, at.reduce((w, other, j) => (i === j ? w : w * (time - other) / (own - other)), 1), state.q[i]);
    });
    return sum;
  }

  function bestOrder(state, time, q) {
    const misses = state.times.map((_, i) => {
      const guess = extrapolated(state, i + 1, time);
      return guess.reduce((most, x, k) => Math.max(most, Math.abs(x - q[k])), 0);
    });
    const best = misses.indexOf(Math.min(...misses));
    return misses[best] < NEARER * misses[0] ? best + 1 : 1;
  }

  function attempt(state, pressures, h) {
    if (!(Math.abs(state.step / h - 1) <= 1e-9)) {
      state.step = h;
      state.factors = regions.map((region) => region.branches.map(([strength, time]) =>
        ({ decay: Math.exp(-h / time), gain: strength * -Math.expm1(-h / time) * time / h })));
    }
    const own = equations(state, pressures, h), time = state.time + h, q = extrapolated(state, state.order, time);
    let lagged = state.lagged && Math.abs(state.lagged.gamma / own.gamma - 1) < 1e-9 ? state.lagged : null;
    state.lagged = null;
    const tolerance = Math.max(LEAST, TOLERANCE * Math.min(1, (SLOW / own.gamma) ** 2));
    let now = residual(state, own, q), change = null;
    for (let i = 0; i < MAX_ITERATIONS; i++) {
      const usable = lagged && nextChange(lagged, change, now.forces);
      if (!usable) lagged = tangent(state, own, q);
      change = usable || times(lagged.inverse, now.forces);
      add(q, -1, change);
      const size_now = largest(change) / size;
      if (size_now < tolerance) { accept(state, own, { q, now, time, lagged, pressures }); return true; }
      if (!Number.isFinite(size_now)) return false;
      now = residual(state, own, q);
    }
    return false;
  }

  function accept(state, own, { q, now, time, lagged, pressures }) {
    regions.forEach((region, i) => {
      const factors = state.factors[i], history = state.histories[i], each = 6 * (1 + factors.length), { relaxing } = now.stresses[i];
      for (let p = 0; factors.length && p < region.weights.length; p++) for (let k = 0; k < 6; k++) {
        const o = p * each + k, change = relaxing[6 * p + k] - history[o];
        history[o] = relaxing[6 * p + k];
        factors.forEach((f, b) => { history[o + 6 * (b + 1)] = f.decay * history[o + 6 * (b + 1)] + f.gain * change; });
      }
    });
    const v = own.past[0].slice();
    add(v, own.gamma, q);
    const momentum = zeros(r);
    addWater(q, v, own.gamma, zeros(r), momentum);
    state.order = bestOrder(state, time, q);
    [[state.times, time], [state.q, q], [state.v, v], [state.momentum, momentum]].forEach(([past, of]) => {
      past.unshift(of);
      past.length = Math.min(past.length, KEPT);
    });
    Object.assign(state, { time, lagged, pressures: pressures.slice(), stresses: now.stresses });
  }

  function step(state, pressures, h, halvings = HALVINGS) {
    if (attempt(state, pressures, h)) return true;
    if (halvings === 0) return false;
    const middle = pressures.map((p, i) => 0.5 * (p + state.pressures[i]));
    return step(state, middle, 0.5 * h, halvings - 1) && step(state, pressures, 0.5 * h, halvings - 1);
  }

  const output = (state, n) => {
    let sum = 0;
    for (let m = 0; m < r; m++) sum += rows[n * r + m] * state.q[0][m];
    return sum;
  };
  return { coordinates: r, chambers: chambers.length, outputs: names, start, step, output };
}
