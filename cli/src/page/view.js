// Viewer of a mesh: the tetrahedra on one side of a plane, turned by hand. No library.
(async () => {
  const $ = id => document.getElementById(id);
  const head = JSON.parse($("mesh-head").textContent);
  const canvas = $("canvas"), shown = $("shown");

  // Columns of 32-bit numbers, each as four planes of bytes, lowest first.
  const packed = Uint8Array.from(atob($("mesh-data").textContent.trim()), c => c.charCodeAt(0));
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("deflate"));
  const bytes = new Uint8Array(await new Response(stream).arrayBuffer());
  let at = 0;
  const column = count => {
    const words = new Uint32Array(count);
    for (let shift = 0; shift < 32; shift += 8) {
      for (let i = 0; i < count; i++) words[i] |= bytes[at++] << shift;
    }
    return words;
  };
  const n = head.points, m = head.tets;
  const xyz = [0, 1, 2].map(() => new Float32Array(column(n).buffer));
  const pointNumber = column(n), tetNumber = column(m);
  // Corners are in ascending order: the first as a step from that of the tetrahedron before.
  const corners = new Uint32Array(4 * m);
  for (let k = 0; k < 4; k++) {
    const step = column(m);
    for (let t = 0; t < m; t++) {
      const from = k > 0 ? corners[4 * t + k - 1] : t > 0 ? corners[4 * t - 4] : 0;
      corners[4 * t + k] = from + step[t];
    }
  }
  const region = column(m), worker = column(m), marker = column(4 * m);

  // The faces opposite to the corners 0 to 3, and the tetrahedron behind each: -1 for none.
  const FACES = [[1, 2, 3], [0, 2, 3], [0, 1, 3], [0, 1, 2]];
  const beyond = new Int32Array(4 * m).fill(-1);
  {
    let size = 16;
    while (size < 6 * m) size *= 2;
    const table = new Int32Array(size).fill(-1), mask = size - 1;
    const corner = (face, k) => corners[(face & ~3) + FACES[face & 3][k]];
    for (let face = 0; face < 4 * m; face++) {
      const [a, b, c] = [corner(face, 0), corner(face, 1), corner(face, 2)];
      let h = Math.imul(a, 0x9e3779b1) ^ Math.imul(b, 0x85ebca6b) ^ Math.imul(c, 0xc2b2ae35);
      for (h = (h ^ (h >>> 15)) & mask; ; h = (h + 1) & mask) {
        const other = table[h];
        if (other < 0) { table[h] = face; break; }
        if (corner(other, 0) === a && corner(other, 1) === b && corner(other, 2) === c) {
          beyond[face] = other >> 2;
          beyond[other] = face >> 2;
          break;
        }
      }
    }
  }

  // Measures.
  const point = v => [xyz[0][v], xyz[1][v], xyz[2][v]];
  const cornersOf = t => [0, 1, 2, 3].map(k => point(corners[4 * t + k]));
  const measure = t => {
    const p = cornersOf(t), dihedral = angles(p);
    const edges = EDGES.map(([i, j]) => Math.hypot(...minus(p[i], p[j])));
    const [a, b, c] = [0, 1, 2].map(k => minus(p[k], p[3]));
    const normals = [cross(b, c), cross(c, a), cross(a, b)];
    const centre = [0, 1, 2].map(k => dot(a, a) * normals[0][k] + dot(b, b) * normals[1][k]
      + dot(c, c) * normals[2][k]);
    const det = Math.abs(dot(a, normals[0]));
    return { p, dihedral, edges, volume: det / 6,
      ratio: Math.hypot(...centre) / (2 * det) / Math.min(...edges) };
  };
  // The least dihedral angle has the largest cosine: between outer normals, minus that.
  const least = new Float32Array(m);
  for (let t = 0; t < m; t++) {
    const [a, b, c, d] = cornersOf(t), [u, v, w] = [minus(b, a), minus(c, a), minus(d, a)];
    const [x, y, z] = [cross(v, w), cross(w, u), cross(u, v)];
    const o = [-x[0] - y[0] - z[0], -x[1] - y[1] - z[1], -x[2] - y[2] - z[2]];
    const cosine = (p, q) => -dot(p, q) / Math.sqrt(dot(p, p) * dot(q, q));
    const most = Math.max(cosine(o, x), cosine(o, y), cosine(o, z), cosine(x, y), cosine(y, z),
      cosine(z, x));
    least[t] = most < 1 ? Math.acos(most) * 180 / Math.PI : 0;
  }

  // Colours.
  const BAD = [[178, 24, 43], [239, 138, 98], [253, 219, 199], [224, 243, 248], [171, 217, 233],
    [116, 173, 209], [69, 117, 180]];
  const MANY = [[78, 121, 167], [242, 142, 43], [89, 161, 79], [225, 87, 89], [118, 183, 178],
    [237, 201, 72], [176, 122, 161], [255, 157, 167], [156, 117, 95], [186, 176, 172]];
  const GREY = [205, 208, 214], CHOSEN = [255, 214, 0];
  const angleClass = t => Math.min(BAD.length - 1, Math.floor(least[t] / 10));
  const many = k => MANY[k % MANY.length];
  const COLOURS = {
    angle: (t) => BAD[angleClass(t)],
    region: (t) => many(region[t]),
    marker: (t, k) => marker[4 * t + k] ? many(marker[4 * t + k] - 1) : GREY,
    worker: (t) => many(worker[t]),
  };
  const digits = x => Number(x.toPrecision(6)).toString();
  const partName = k => head.names[k] || `marker ${head.markers[k]}`;
  // The areas of parts, of the tetrahedra that are in the page.
  const sums = new Float64Array(head.markers.length);
  for (let face = 0; face < 4 * m; face++) {
    if (!marker[face]) continue;
    const [a, b, c] = FACES[face & 3].map(k => point(corners[(face & ~3) + k]));
    sums[marker[face] - 1] += Math.hypot(...cross(minus(b, a), minus(c, a))) / 2;
  }
  const areas = Array.from(sums, sum => Number(sum.toPrecision(4)));
  const classes = {
    angle: BAD.map((c, k) => [c, k < 6 ? `${10 * k}–${10 * k + 10}°` : "60° and more"]),
    region: head.regions.map((name, k) => [many(k), `region ${name}`]),
    marker: [...head.markers.map((_, k) => [many(k), `${partName(k)}, area ${areas[k]}`]),
      [GREY, "inside"]],
    worker: head.workers.map((name, k) => [many(k), `worker ${name}`]),
  };

  // State, kept in the address so that a view can be passed on: #cut=z:0.5&colour=region&...
  const state = { cut: "z", place: 0.45, flip: false, colour: "angle", worse: 90, edges: true,
    yaw: -0.22, pitch: 0.3, zoom: 1, shift: [0, 0], tet: -1, fit: true };
  const readAddress = () => {
    const wish = new URLSearchParams(location.hash.slice(1));
    const number = (key, low, high) => {
      const value = Number.parseFloat(wish.get(key));
      return value >= low && value <= high ? value : null;
    };
    const [axis, place] = (wish.get("cut") ?? "").split(":");
    if (["none", "x", "y", "z", "view"].includes(axis)) state.cut = axis;
    const where = Number.parseFloat(place);
    if (where >= 0 && where <= 1) state.place = where;
    if (wish.get("colour") in COLOURS) state.colour = wish.get("colour");
    state.flip = wish.has("flip") ? wish.get("flip") === "1" : state.flip;
    state.edges = wish.has("edges") ? wish.get("edges") === "1" : state.edges;
    state.worse = number("worse", 0, 90) ?? state.worse;
    state.yaw = number("yaw", -100, 100) ?? state.yaw;
    state.pitch = number("pitch", -1.6, 1.6) ?? state.pitch;
    const zoom = number("zoom", 0.05, 100);
    if (zoom !== null) Object.assign(state, { zoom, fit: false });
    const tet = number("tet", 0, 2 ** 32);
    if (tet !== null) state.tet = tetNumber.indexOf(tet);
    document.body.classList.toggle("bare", wish.get("bare") === "1");
  };
  const writeAddress = () => {
    const wish = new URLSearchParams({ cut: `${state.cut}:${state.place}`, colour: state.colour,
      flip: Number(state.flip), edges: Number(state.edges), worse: state.worse,
      yaw: state.yaw.toFixed(3), pitch: state.pitch.toFixed(3) });
    if (!state.fit) wish.set("zoom", state.zoom.toFixed(3));
    if (state.tet >= 0) wish.set("tet", tetNumber[state.tet]);
    if (document.body.classList.contains("bare")) wish.set("bare", 1);
    history.replaceState(null, "", "#" + wish);
  };

  // The ball around the mesh.
  const low = xyz.map(a => a.reduce((p, q) => Math.min(p, q), Infinity));
  const high = xyz.map(a => a.reduce((p, q) => Math.max(p, q), -Infinity));
  const middle = low.map((p, k) => (p + high[k]) / 2);
  const radius = Math.hypot(...minus(high, low)) / 2 || 1;

  // Rows: right, up, towards the eye.
  const rotation = () => {
    const [c, s] = [Math.cos(state.yaw), Math.sin(state.yaw)];
    const [d, e] = [Math.cos(state.pitch), Math.sin(state.pitch)];
    return [[c, s, 0], [-s * e, c * e, d], [s * d, -c * d, e]];
  };
  const AXES = { x: [1, 0, 0], y: [0, 1, 0], z: [0, 0, 1] };
  let across = AXES.z;
  const turnPlane = () => { across = AXES[state.cut] ?? rotation()[2]; };

  // The triangles to draw: (tetrahedron, face) as 4 t + k.
  let drawn = new Uint32Array(0), buffers = null;
  const visible = new Uint8Array(m);
  const choose = () => {
    let [from, to] = [Infinity, -Infinity];
    const height = v => xyz[0][v] * across[0] + xyz[1][v] * across[1] + xyz[2][v] * across[2];
    for (let v = 0; v < n; v++) {
      from = Math.min(from, height(v));
      to = Math.max(to, height(v));
    }
    const limit = from + state.place * (to - from), sign = state.flip ? -1 : 1;
    let count = 0;
    for (let t = 0; t < m; t++) {
      let seen = state.worse >= 90 || least[t] < state.worse;
      if (seen && state.cut !== "none") {
        let sum = 0;
        for (let k = 0; k < 4; k++) sum += height(corners[4 * t + k]);
        seen = sign * (sum / 4 - limit) <= 0;
      }
      visible[t] = seen ? 1 : 0;
      count += visible[t];
    }
    const list = [];
    for (let face = 0; face < 4 * m; face++) {
      if (visible[face >> 2] && (beyond[face] < 0 || !visible[beyond[face]])) list.push(face);
    }
    drawn = Uint32Array.from(list);
    const all = head.total.toLocaleString("en");
    const part = head.total > m ? ` (${m.toLocaleString("en")} are in this page)` : "";
    shown.textContent = `${count.toLocaleString("en")} of ${all} tetrahedra${part}`;
    fill();
  };
  const fill = () => {
    const place = new Float32Array(9 * drawn.length), paint = new Uint8Array(12 * drawn.length);
    drawn.forEach((face, i) => {
      const t = face >> 2, k = face & 3;
      const colour = t === state.tet ? CHOSEN : COLOURS[state.colour](t, k);
      FACES[k].forEach((slot, j) => {
        const v = corners[4 * t + slot];
        for (let a = 0; a < 3; a++) {
          place[9 * i + 3 * j + a] = (xyz[a][v] - middle[a]) / radius;
          paint[12 * i + 4 * j + a] = colour[a];
        }
        paint[12 * i + 4 * j + 3] = 255;
      });
    });
    buffers = { place, paint, fresh: true };
    later();
  };

  // The camera: the eye is at a distance on the third axis, all in units of the ball's radius.
  const EYE = 6;
  const camera = () => {
    const wide = canvas.width / canvas.height, f = 5.2 * state.zoom;
    return { r: rotation(), fx: f / Math.max(wide, 1), fy: f * Math.min(wide, 1) };
  };
  const matrix = () => {
    const { r, fx, fy } = camera(), [sx, sy] = state.shift;
    const near = EYE - 2.5, far = EYE + 3, z = (far + near) / (near - far), w = 2 * far * near / (near - far);
    // Columns of the product of projection and turn.
    const columns = [0, 1, 2].map(a => [fx * r[0][a] - sx * r[2][a], fy * r[1][a] - sy * r[2][a],
      z * r[2][a], -r[2][a]]);
    return [...columns.flat(), sx * EYE, sy * EYE, w - z * EYE, EYE];
  };

  const gl = head.no_webgl ? null : canvas.getContext("webgl2", { antialias: true });
  const plain = gl ? null : canvas.getContext("2d");
  let program = null, places = null;
  if (gl) {
    const shader = (kind, text) => {
      const made = gl.createShader(kind);
      gl.shaderSource(made, text);
      gl.compileShader(made);
      return made;
    };
    program = gl.createProgram();
    gl.attachShader(program, shader(gl.VERTEX_SHADER, VERTICES));
    gl.attachShader(program, shader(gl.FRAGMENT_SHADER, PIXELS));
    gl.linkProgram(program);
    gl.useProgram(program);
    gl.enable(gl.DEPTH_TEST);
    places = ["place", "paint"].map(name => {
      const buffer = gl.createBuffer(), where = gl.getAttribLocation(program, name);
      gl.enableVertexAttribArray(where);
      return { buffer, where };
    });
  }
  const drawByCard = () => {
    if (buffers.fresh) {
      const [place, paint] = places;
      gl.bindBuffer(gl.ARRAY_BUFFER, place.buffer);
      gl.bufferData(gl.ARRAY_BUFFER, buffers.place, gl.DYNAMIC_DRAW);
      gl.vertexAttribPointer(place.where, 3, gl.FLOAT, false, 0, 0);
      gl.bindBuffer(gl.ARRAY_BUFFER, paint.buffer);
      gl.bufferData(gl.ARRAY_BUFFER, buffers.paint, gl.DYNAMIC_DRAW);
      gl.vertexAttribPointer(paint.where, 3, gl.UNSIGNED_BYTE, true, 4, 0);
      buffers.fresh = false;
    }
    const r = rotation(), uniform = name => gl.getUniformLocation(program, name);
    gl.viewport(0, 0, canvas.width, canvas.height);
    gl.clearColor(0.957, 0.961, 0.969, 1);
    gl.clear(gl.COLOR_BUFFER_BIT | gl.DEPTH_BUFFER_BIT);
    gl.uniformMatrix4fv(uniform("project"), false, matrix());
    gl.uniformMatrix3fv(uniform("turn"), true, r.flat());
    gl.uniform1f(uniform("lines"), state.edges ? 1 : 0);
    gl.drawArrays(gl.TRIANGLES, 0, 3 * drawn.length);
  };
  // Without a graphics card's help: triangles from back to front.
  const project = (place, i) => {
    const { r, fx, fy } = camera(), p = [place[i], place[i + 1], place[i + 2]];
    const depth = EYE - dot(r[2], p);
    const x = (fx * dot(r[0], p)) / depth + state.shift[0];
    const y = (fy * dot(r[1], p)) / depth + state.shift[1];
    return [(x + 1) / 2 * canvas.width, (1 - y) / 2 * canvas.height, depth];
  };
  const drawByHand = () => {
    const { place, paint } = buffers, r = rotation();
    const flat = new Array(drawn.length), depths = new Float32Array(drawn.length);
    for (let i = 0; i < drawn.length; i++) {
      const q = [0, 3, 6].map(j => project(place, 9 * i + j));
      flat[i] = q;
      depths[i] = q[0][2] + q[1][2] + q[2][2];
    }
    const order = Uint32Array.from(depths.keys()).sort((a, b) => depths[b] - depths[a]);
    plain.fillStyle = "#f4f5f7";
    plain.fillRect(0, 0, canvas.width, canvas.height);
    plain.strokeStyle = "#3338";
    plain.lineWidth = 0.5;
    for (const i of order) {
      const [p, q, s] = [0, 3, 6].map(j => [...place.subarray(9 * i + j, 9 * i + j + 3)]);
      const normal = cross(minus(q, p), minus(s, p));
      const light = 0.4 + 0.6 * Math.abs(dot(r[2], normal)) / (Math.hypot(...normal) || 1);
      const colour = [0, 1, 2].map(a => Math.round(paint[12 * i + a] * light));
      plain.fillStyle = `rgb(${colour})`;
      plain.beginPath();
      flat[i].forEach(([x, y], j) => j ? plain.lineTo(x, y) : plain.moveTo(x, y));
      plain.closePath();
      plain.fill();
      if (state.edges) plain.stroke();
    }
  };
  // What is shown fills the canvas, until somebody turns, shifts or zooms.
  const fit = () => {
    if (!state.fit || !drawn.length) return;
    Object.assign(state, { zoom: 1, shift: [0, 0] });
    const { r, fx, fy } = camera(), [left, low, right, high] = frame(buffers.place, r, EYE);
    state.zoom = 1.96 / Math.max(fx * (right - left), fy * (high - low));
    state.shift = [-fx * (left + right), -fy * (low + high)].map(s => s * state.zoom / 2);
  };
  const pixels = () => {
    const [wide, high] = [canvas.width, canvas.height], all = new Uint8Array(4 * wide * high);
    if (gl) gl.readPixels(0, 0, wide, high, gl.RGBA, gl.UNSIGNED_BYTE, all);
    else all.set(plain.getImageData(0, 0, wide, high).data);
    return all;
  };
  const draw = () => {
    waiting = false;
    const scale = window.devicePixelRatio || 1;
    canvas.width = Math.max(1, Math.round(canvas.clientWidth * scale));
    canvas.height = Math.max(1, Math.round(canvas.clientHeight * scale));
    fit();
    if (gl) drawByCard(); else drawByHand();
    document.body.dataset.drawn = drawn.length;
    if (!location.hash.includes("measure=1")) return;
    const { scrollWidth, clientWidth } = document.documentElement;
    Object.assign(document.body.dataset, { filled: share(pixels()), beyond: scrollWidth - clientWidth });
  };
  let waiting = false;
  const later = () => {
    if (!waiting) requestAnimationFrame(draw);
    waiting = true;
  };

  // The figures of one tetrahedron.
  const tell = () => {
    const box = $("picked"), t = state.tet;
    box.replaceChildren();
    if (t < 0) return;
    const f = measure(t), slots = [0, 1, 2, 3];
    const found = slots.map(k => marker[4 * t + k]).filter(k => k);
    const range = list => `${digits(Math.min(...list))} to ${digits(Math.max(...list))}`;
    const rows = [["tetrahedron", tetNumber[t]],
      ...slots.map(k => [`vertex ${pointNumber[corners[4 * t + k]]}`,
        f.p[k].map(digits).join(", ")]),
      ["dihedral angles", range(f.dihedral) + "°"],
      ["circumradius / shortest edge", digits(f.ratio)],
      ["edges", range(f.edges)], ["volume", digits(f.volume)]];
    if (head.regions.length) rows.push(["region", head.regions[region[t]]]);
    if (head.workers.length) rows.push(["worker", head.workers[worker[t]]]);
    if (found.length) rows.push(["part", found.map(k => partName(k - 1)).join(", ")]);
    const reason = head.excused[tetNumber[t]];
    if (reason) rows.push(["over a bound", reason]);
    const table = box.appendChild(document.createElement("table"));
    for (const row of rows) {
      const tr = table.insertRow();
      for (const text of row) tr.insertCell().textContent = text;
    }
  };
  // The nearest triangle under the pointer, among those drawn.
  const pick = (x, y) => {
    const scale = canvas.width / canvas.clientWidth, [px, py] = [x * scale, y * scale];
    let best = -1, nearest = Infinity;
    for (let i = 0; i < drawn.length; i++) {
      const [a, b, c] = [0, 3, 6].map(j => project(buffers.place, 9 * i + j));
      const area = (p, q, rx, ry) => (q[0] - p[0]) * (ry - p[1]) - (q[1] - p[1]) * (rx - p[0]);
      const whole = area(a, b, c[0], c[1]);
      const u = area(b, c, px, py) / whole, v = area(c, a, px, py) / whole, w = 1 - u - v;
      const depth = u * a[2] + v * b[2] + w * c[2];
      if (u >= 0 && v >= 0 && w >= 0 && depth < nearest) {
        nearest = depth;
        best = drawn[i] >> 2;
      }
    }
    return best;
  };

  // Controls.
  const controls = { cut: "cut", colour: "colour", place: "place", worse: "worse", flip: "flip",
    edges: "edges" };
  const key = () => {
    $("key").replaceChildren(...classes[state.colour].slice(0, 40).map(([colour, text]) => {
      const entry = document.createElement("span"), box = document.createElement("i");
      box.style.background = `rgb(${colour})`;
      entry.append(box, text);
      return entry;
    }));
  };
  const showControls = () => {
    for (const [id, name] of Object.entries(controls)) {
      if ($(id).type === "checkbox") $(id).checked = state[name]; else $(id).value = state[name];
    }
    $("worse-text").textContent = state.worse >= 90 ? "all" : `below ${state.worse}°`;
    $("place").disabled = $("flip").disabled = state.cut === "none";
    key();
  };
  const refresh = () => { showControls(); choose(); tell(); };
  for (const name of ["region", "marker", "worker"]) {
    if (head[name + "s"].length < 1) $("colour").querySelector(`[value=${name}]`).remove();
  }
  for (const [id, name] of Object.entries(controls)) {
    $(id).addEventListener("input", event => {
      const box = event.target;
      state[name] = box.type === "checkbox" ? box.checked
        : box.type === "range" ? Number(box.value) : box.value;
      if (name === "cut") turnPlane();
      refresh();
      writeAddress();
    });
  }
  $("reset").addEventListener("click", () => {
    Object.assign(state, { yaw: -0.22, pitch: 0.3, tet: -1, fit: true });
    refresh();
    writeAddress();
  });
  $("export").addEventListener("click", () => {
    const tets = Array.from(visible.keys()).filter(t => visible[t]), places = new Map();
    const rows = tets.map(t => [0, 1, 2, 3].map(k => {
      const v = corners[4 * t + k];
      return places.get(v) ?? places.set(v, places.size).size - 1;
    }));
    const columns = [["tetrahedron", t => tetNumber[t]], ["dihedral", t => least[t]],
      ["region", t => head.regions[region[t]] ?? 0]].map(([name, of]) => [name, tets.map(of)]);
    const text = vtk([...places.keys()].map(point), rows, columns);
    const link = document.createElement("a");
    link.href = URL.createObjectURL(new Blob([text]));
    link.download = "part.vtk";
    link.click();
    document.body.dataset.saved = text.length;
  });
  const pointers = new Map();
  let moved = 0;
  canvas.addEventListener("pointerdown", event => {
    pointers.set(event.pointerId, event);
    moved = 0;
    canvas.classList.add("turning");
    try { canvas.setPointerCapture(event.pointerId); } catch { /* A pointer made by a script. */ }
  });
  canvas.addEventListener("pointermove", event => {
    const before = pointers.get(event.pointerId);
    if (!before) return;
    const dx = event.clientX - before.clientX, dy = event.clientY - before.clientY;
    moved += Math.abs(dx) + Math.abs(dy);
    state.fit = false;
    if (pointers.size === 2) {
      const [other] = [...pointers.values()].filter(p => p.pointerId !== event.pointerId);
      const apart = p => Math.hypot(p.clientX - other.clientX, p.clientY - other.clientY) || 1;
      state.zoom = Math.min(100, Math.max(0.05, state.zoom * apart(event) / apart(before)));
    } else if (event.shiftKey || event.buttons & 6) {
      state.shift[0] += 2 * dx / canvas.clientWidth;
      state.shift[1] -= 2 * dy / canvas.clientHeight;
    } else {
      state.yaw -= dx / 150;
      state.pitch = Math.min(1.57, Math.max(-1.57, state.pitch + dy / 150));
    }
    pointers.set(event.pointerId, event);
    later();
  });
  const release = event => {
    if (!pointers.delete(event.pointerId)) return;
    canvas.classList.remove("turning");
    if (moved < 4 && event.type === "pointerup") {
      const box = canvas.getBoundingClientRect();
      state.tet = pick(event.clientX - box.left, event.clientY - box.top);
      tell();
      fill();
    }
    writeAddress();
  };
  canvas.addEventListener("pointerup", release);
  canvas.addEventListener("pointercancel", release);
  canvas.addEventListener("contextmenu", event => event.preventDefault());
  canvas.addEventListener("wheel", event => {
    event.preventDefault();
    state.fit = false;
    state.zoom = Math.min(100, Math.max(0.05, state.zoom * Math.exp(-event.deltaY / 600)));
    later();
    writeAddress();
  }, { passive: false });
  canvas.addEventListener("keydown", event => {
    const turn = { ArrowLeft: [0.1, 0], ArrowRight: [-0.1, 0], ArrowUp: [0, 0.1],
      ArrowDown: [0, -0.1] }[event.key];
    if (!turn) return;
    event.preventDefault();
    state.fit = false;
    state.yaw += turn[0];
    state.pitch = Math.min(1.57, Math.max(-1.57, state.pitch + turn[1]));
    later();
  });
  window.addEventListener("resize", later);
  window.addEventListener("hashchange", () => { readAddress(); turnPlane(); refresh(); });

  readAddress();
  turnPlane();
  refresh();
  document.body.dataset.ready = "yes";
})().catch(error => {
  document.getElementById("shown").textContent = `this view cannot be shown: ${error.message}`;
});
