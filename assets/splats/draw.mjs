// Draws a PLY of splats as the program of its authors does, in plain steps, to see what viewers make of it. Needs nothing but Node 20.15.
//
//     node draw.mjs scene.ply VIEWS OUT [--frame 0] [--antialias] [--low-pass 0.3]
//
// VIEWS is a transforms.json whose scene has z up, as that in the `novel` folder of `overlook demo`: its pictures of one frame are
// drawn, and written to OUT as PNG under their own names. --antialias lowers opacities by what the low-pass filter widens, as "mip"
// viewers do. `overlook evaluate CAPTURE --pictures OUT` scores them.
//
// Source: Kerbl et al., 3D Gaussian Splatting for Real-Time Radiance Field Rendering, SIGGRAPH 2023, and the rasterizer of its program.
import { readFileSync } from "node:fs";
import { parseArgs } from "node:util";
import { readViews, writePicture } from "./views.mjs";

const { positionals, values } = parseArgs({
  allowPositionals: true,
  options: { frame: { type: "string", default: "0" }, antialias: { type: "boolean" }, "low-pass": { type: "string", default: "0.3" } },
});
const [ply, viewsFile, out] = positionals;
const lowPass = Number(values["low-pass"]);

/** The floats of a PLY's splats, by property: [x of all, y of all, ...]. */
function readSplats(path) {
  const bytes = readFileSync(path);
  const start = bytes.indexOf("end_header\n") + "end_header\n".length;
  const header = bytes.toString("latin1", 0, start);
  const names = [...header.matchAll(/property float (\w+)/g)].map((match) => match[1]);
  const count = Number(/element vertex (\d+)/.exec(header)[1]);
  const floats = new Float32Array(bytes.buffer.slice(bytes.byteOffset + start, bytes.byteOffset + start + 4 * names.length * count));
  const column = (name) => Float32Array.from({ length: count }, (_, nth) => floats[nth * names.length + names.indexOf(name)]);
  return { count, ...Object.fromEntries(names.map((name) => [name, column(name)])) };
}

/** The upper half of a splat's covariance in the axes of the file: xx, xy, xz, yy, yz, zz. */
function covariance(splats, nth) {
  let [w, x, y, z] = [0, 1, 2, 3].map((part) => splats[`rot_${part}`][nth]);
  const length = Math.hypot(w, x, y, z);
  [w, x, y, z] = [w / length, x / length, y / length, z / length];
  const axes = [
    [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
    [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
    [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
  ];
  const variances = [0, 1, 2].map((axis) => Math.exp(2 * splats[`scale_${axis}`][nth]));
  const part = (row, column) => variances.reduce((sum, variance, axis) => sum + variance * axes[row][axis] * axes[column][axis], 0);
  return [part(0, 0), part(0, 1), part(0, 2), part(1, 1), part(1, 2), part(2, 2)];
}

/** A splat in a picture: its depth, its middle in pixels, the inverse of its covariance there, its opacity; nothing where none is seen. */
function project(splats, covariances, nth, view) {
  const { fx, fy, cx, cy, width, height, rows, position } = view;
  const off = [splats.x[nth] - position[0], splats.y[nth] - position[1], splats.z[nth] - position[2]];
  const [x, y, z] = rows.map((row) => row[0] * off[0] + row[1] * off[1] + row[2] * off[2]);
  if (z < 0.2) return undefined;
  // Far outside, the projection is nothing like linear.
  const bound = (slope, limit) => Math.min(Math.max(slope, -limit), limit);
  const [slopeX, slopeY] = [bound(x / z, (0.65 * width) / fx), bound(y / z, (0.65 * height) / fy)];
  const across = [0, 1, 2].map((axis) => (fx * (rows[0][axis] - slopeX * rows[2][axis])) / z);
  const down = [0, 1, 2].map((axis) => (fy * (rows[1][axis] - slopeY * rows[2][axis])) / z);
  const [sxx, sxy, sxz, syy, syz, szz] = covariances[nth];
  const times = ([a, b, c]) => [sxx * a + sxy * b + sxz * c, sxy * a + syy * b + syz * c, sxz * a + syz * b + szz * c];
  const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
  const [ofAcross, ofDown] = [times(across), times(down)];
  const [narrowXx, xy, narrowYy] = [dot(across, ofAcross), dot(down, ofAcross), dot(down, ofDown)];
  const [xx, yy] = [narrowXx + lowPass, narrowYy + lowPass];
  const determinant = xx * yy - xy * xy;
  const narrow = Math.max(narrowXx * narrowYy - xy * xy, 0);
  const share = values.antialias ? Math.sqrt(narrow / determinant) : 1;
  const opacity = share / (1 + Math.exp(-splats.opacity[nth]));
  if (opacity < 1 / 255) return undefined;
  // Where it falls below what 8 bits show.
  const reach = Math.sqrt(2 * Math.log(255 * opacity));
  const [reachX, reachY] = [reach * Math.sqrt(xx), reach * Math.sqrt(yy)];
  const [atX, atY] = [(fx * x) / z + cx, (fy * y) / z + cy];
  if (atX + reachX < 0 || atX - reachX > width || atY + reachY < 0 || atY - reachY > height) return undefined;
  return { z, nth, atX, atY, reachX, reachY, inverse: [yy / determinant, -xy / determinant, xx / determinant], opacity };
}

/** The sRGB bytes of a view, over black. */
function draw(splats, covariances, view) {
  const { width, height } = view;
  const seen = [];
  for (let nth = 0; nth < splats.count; nth++) {
    const splat = project(splats, covariances, nth, view);
    if (splat) seen.push(splat);
  }
  seen.sort((a, b) => a.z - b.z);
  const sums = new Float64Array(3 * width * height);
  const left = new Float64Array(width * height).fill(1);
  for (const { nth, atX, atY, reachX, reachY, inverse, opacity } of seen) {
    const color = [0, 1, 2].map((channel) => Math.max(0.5 + 0.28209479177387814 * splats[`f_dc_${channel}`][nth], 0));
    const [first, last] = [Math.max(Math.ceil(atX - reachX - 0.5), 0), Math.min(Math.floor(atX + reachX - 0.5), width - 1)];
    for (let row = Math.max(Math.ceil(atY - reachY - 0.5), 0); row <= Math.min(atY + reachY - 0.5, height - 1); row++) {
      for (let column = first; column <= last; column++) {
        const at = row * width + column;
        if (left[at] < 1e-4) continue;
        const [x, y] = [column + 0.5 - atX, row + 0.5 - atY];
        const power = -0.5 * (inverse[0] * x * x + inverse[2] * y * y) - inverse[1] * x * y;
        const alpha = Math.min(0.99, opacity * Math.exp(power));
        if (alpha < 1 / 255) continue;
        for (let channel = 0; channel < 3; channel++) sums[3 * at + channel] += left[at] * alpha * color[channel];
        left[at] *= 1 - alpha;
      }
    }
  }
  return Uint8Array.from(sums, (sum) => Math.min(255 * sum + 0.5, 255));
}

const splats = readSplats(ply);
const covariances = Array.from({ length: splats.count }, (_, nth) => covariance(splats, nth));
for (const view of readViews(viewsFile, Number(values.frame))) {
  writePicture(out, view, draw(splats, covariances, view));
}
