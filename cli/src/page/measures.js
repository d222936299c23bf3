// What the viewer computes of points and triangles, and the text that it saves.
"use strict";
const { minus, dot, cross, EDGES, angles, frame, share, vtk } = (() => {
  const minus = (p, q) => [p[0] - q[0], p[1] - q[1], p[2] - q[2]];
  const dot = (p, q) => p[0] * q[0] + p[1] * q[1] + p[2] * q[2];
  const cross = (p, q) => [p[1] * q[2] - p[2] * q[1], p[2] * q[0] - p[0] * q[2],
    p[0] * q[1] - p[1] * q[0]];
  const EDGES = [[0, 1, 2, 3], [0, 2, 1, 3], [0, 3, 1, 2], [1, 2, 0, 3], [1, 3, 0, 2],
    [2, 3, 0, 1]];
  const angles = p => EDGES.map(([i, j, k, l]) => {
    const e = minus(p[j], p[i]);
    const a = cross(e, minus(p[k], p[i])), b = cross(e, minus(p[l], p[i]));
    return Math.atan2(Math.hypot(...cross(a, b)), dot(a, b)) * 180 / Math.PI;
  });
  // The box around points, as three numbers each, that are seen by an eye at a distance.
  const frame = (place, r, eye) => {
    const box = [Infinity, Infinity, -Infinity, -Infinity];
    for (let i = 0; i < place.length; i += 3) {
      const p = [place[i], place[i + 1], place[i + 2]], depth = eye - dot(r[2], p);
      [0, 1].forEach(k => {
        const at = dot(r[k], p) / depth;
        box[k] = Math.min(box[k], at);
        box[k + 2] = Math.max(box[k + 2], at);
      });
    }
    return box;
  };
  // Tetrahedra in VTK's legacy format, with names of columns and a row of values for each.
  const vtk = (points, tets, columns) => {
    const lines = ["# vtk DataFile Version 3.0", "a part of a mesh by ltbw", "ASCII",
      "DATASET UNSTRUCTURED_GRID", `POINTS ${points.length} float`,
      ...points.map(p => p.join(" ")), `CELLS ${tets.length} ${5 * tets.length}`,
      ...tets.map(t => `4 ${t.join(" ")}`), `CELL_TYPES ${tets.length}`, ...tets.map(() => 10),
      `CELL_DATA ${tets.length}`];
    for (const [name, values] of columns) {
      lines.push(`SCALARS ${name} float 1`, "LOOKUP_TABLE default", ...values);
    }
    return lines.join("\n") + "\n";
  };
  // The share of pixels that are not background.
  const share = pixels => {
    let count = 0;
    for (let i = 0; i < pixels.length; i += 4) {
      count += pixels[i] !== 244 || pixels[i + 1] !== 245 || pixels[i + 2] !== 247;
    }
    return (4 * count / pixels.length).toFixed(3);
  };
  return { minus, dot, cross, EDGES, angles, frame, share, vtk };
})();
// The graphics card's part: triangles lit by where they face, with their edges.
const VERTICES = `#version 300 es
  uniform mat4 project; uniform mat3 turn;
  in vec3 place; in vec3 paint; out vec3 position, corner, colour;
  void main() {
    gl_Position = project * vec4(place, 1.0);
    position = turn * place;
    int k = gl_VertexID % 3;
    corner = vec3(k == 0, k == 1, k == 2);
    colour = paint;
  }`;
const PIXELS = `#version 300 es
  precision highp float;
  uniform float lines; in vec3 position, corner, colour; out vec4 result;
  void main() {
    vec3 across = normalize(cross(dFdx(position), dFdy(position)));
    vec3 width = fwidth(corner);
    float coarse = max(width.x, max(width.y, width.z));
    vec3 inner = smoothstep(vec3(0.0), 1.3 * width, corner);
    float edge = 1.0 - min(inner.x, min(inner.y, inner.z));
    edge *= lines * 0.75 * (1.0 - smoothstep(0.12, 0.5, coarse));
    float light = 0.5 + 0.5 * dot(across, vec3(-0.35, 0.45, 0.82));
    vec3 lit = colour * (0.3 + 0.74 * light);
    result = vec4(mix(lit, vec3(0.12), edge), 1.0);
  }`;
