// Viewpoints of a transforms.json in the axes of a PLY of splats, and pictures of them.
import { mkdirSync, readFileSync, writeFileSync } from "node:fs";
import { dirname, join } from "node:path";
import { crc32, deflateSync } from "node:zlib";

/**
 * The viewpoints of one frame, the nth of their times: lens in pixels, `position`, and as `rows` the directions right, down and forward,
 * in the axes of a PLY whose scene has z up: (x, -z, y).
 */
export function readViews(path, frame) {
  const { frames } = JSON.parse(readFileSync(path, "utf8"));
  const times = [...new Set(frames.map((one) => one.time))].sort((a, b) => a - b);
  const turned = ([x, y, z]) => [x, -z, y];
  return frames.filter((one) => one.time === times[frame]).map((one) => {
    const column = (nth, sign) => turned(one.transform_matrix.slice(0, 3).map((row) => sign * row[nth]));
    return {
      name: one.file_path.replace(/\.\w+$/, ".png"), width: one.w, height: one.h, fx: one.fl_x, fy: one.fl_y, cx: one.cx, cy: one.cy,
      rows: [column(0, 1), column(1, -1), column(2, -1)], position: column(3, 1),
    };
  });
}

/** Writes a view's picture, three bytes a pixel, as PNG under its name. */
export function writePicture(folder, { name, width, height }, bytes) {
  const chunk = (kind, data) => {
    const named = Buffer.concat([Buffer.from(kind), data]);
    const word = (value) => Buffer.from(new Uint32Array([value]).buffer).swap32();
    return Buffer.concat([word(data.length), named, word(crc32(named))]);
  };
  const header = Buffer.alloc(13);
  header.writeUInt32BE(width, 0);
  header.writeUInt32BE(height, 4);
  header.set([8, 2, 0, 0, 0], 8);
  const rows = Buffer.alloc((3 * width + 1) * height);
  for (let row = 0; row < height; row++) rows.set(bytes.subarray(3 * width * row, 3 * width * (row + 1)), (3 * width + 1) * row + 1);
  const path = join(folder, name);
  mkdirSync(dirname(path), { recursive: true });
  const signature = Buffer.from([137, 80, 78, 71, 13, 10, 26, 10]);
  writeFileSync(path, Buffer.concat([signature, chunk("IHDR", header), chunk("IDAT", deflateSync(rows)), chunk("IEND", Buffer.alloc(0))]));
}
