//! The gather stage: surface first, color second.
use rayon::prelude::*;

use glam::{DVec2, Vec3};

use super::frame_samples::FrameSamples;
use super::keys::{inverse_depth_of, slot_of};
use super::project::{Projector, focal};
use crate::capture::Camera;
use crate::preprocess::TILE;

fn knob(name: &str, default: f32) -> f32 {
    std::env::var(name).ok().and_then(|v| v.parse().ok()).unwrap_or(default)
}

struct View {
    source_from_target: Projector,
    target_from_source: Projector,
    center_offset: Vec3,
    width: i32,
    height: i32,
    cells_across: usize,
    first_cell: usize,
    per_footprint: f32,
}

pub(super) struct Gather<'a> {
    frame: &'a FrameSamples<'a>,
    views: Vec<View>,
    starts: Vec<u32>,
    refs: Vec<u32>,
    ray_origin: Vec3,
    ray_x: Vec3,
    ray_y: Vec3,
    knobs: [f32; 8],
    reach: f32,
    sharp: f32,
    bias: f32,
}

struct Tap {
    depth: f32,
    color: [f32; 3],
}

impl<'a> Gather<'a> {
    pub(super) fn new(frame: &'a FrameSamples<'a>, tiles: std::ops::Range<usize>, target: &Camera) -> Self {
        let mut first_cell = 0;
        let target_center = target.position_in_world();
        let views: Vec<View> = frame
            .set
            .cameras
            .iter()
            .map(|camera| {
                let (width, height) = camera.intrinsics.size();
                let cells_across = width.div_ceil(TILE);
                let view = View {
                    source_from_target: Projector::new(target, camera),
                    target_from_source: Projector::new(camera, target),
                    center_offset: (target_center - camera.position_in_world()).as_vec3(),
                    width: width as i32,
                    height: height as i32,
                    cells_across,
                    first_cell,
                    per_footprint: 1.0 / focal(camera),
                };
                first_cell += cells_across * height.div_ceil(TILE);
                view
            })
            .collect();
        let cell = |number: usize| {
            let (image, tile) = frame.tile(number);
            let view = &views[image.camera as usize];
            view.first_cell + tile.tile_y as usize * view.cells_across + tile.tile_x as usize
        };
        let mut starts = vec![0_u32; first_cell + 1];
        for number in tiles.clone() {
            starts[cell(number) + 1] += 1;
        }
        for i in 0..first_cell {
            starts[i + 1] += starts[i];
        }
        let mut next = starts.clone();
        let mut refs = vec![0; tiles.len()];
        for number in tiles {
            let at = &mut next[cell(number)];
            refs[*at as usize] = number as u32;
            *at += 1;
        }
        let rotation = target.world_from_camera.matrix3;
        let ray = |x: f64, y: f64| rotation * target.intrinsics.ray_in_camera(DVec2::new(x, y));
        let r0 = ray(0.5, 0.5);
        Self {
            frame,
            ray_origin: r0.as_vec3(),
            ray_x: (ray(1.5, 0.5) - r0).as_vec3(),
            ray_y: (ray(0.5, 1.5) - r0).as_vec3(),
            views,
            starts,
            refs,
            reach: knob("G_REACH", 2.0),
            sharp: knob("G_SHARP", 1.2),
            bias: knob("G_OFF", 0.15),
            knobs: [
                knob("G_TOL", 2.0),
                knob("G_RATE", 2.0),
                knob("G_ANGLE", 1.0),
                knob("G_CAP", 1.5),
                knob("G_REFINE", 1.0),
                knob("G_EDGE", 0.03),
                knob("G_BIAS", 0.0),
                knob("G_MIN", 0.25),
            ],
        }
    }

    fn tap(&self, view: &View, x: i32, y: i32) -> Option<Tap> {
        if x < 0 || y < 0 || x >= view.width || y >= view.height {
            return None;
        }
        let (x, y) = (x as usize, y as usize);
        let cell = view.first_cell + (y / TILE) * view.cells_across + x / TILE;
        for &number in &self.refs[self.starts[cell] as usize..self.starts[cell + 1] as usize] {
            let (image, tile) = self.frame.tile(number as usize);
            let (column, row) = (x % TILE, y % TILE);
            if tile.rows[row] >> column & 1 == 1 {
                let nth = tile.rank(column, row);
                let depth =
                    image.depth.get(self.frame.tiles[number as usize].tile as usize, tile.first, nth);
                let color = image.color[tile.first as usize + nth].map(half::f16::to_f32);
                return Some(Tap { depth, color });
            }
        }
        None
    }

    /// Color at a pixel of known surface, weight.
    fn view_color(&self, view: &View, x: f32, y: f32, w: f32) -> Option<([f32; 3], f32)> {
        let [tol, rate_power, angle_power, cap, refine, edge, cubic, _] = self.knobs;
        let p = &view.source_from_target;
        let mut w = w;
        let mut result = None;
        for pass in 0..=refine as usize {
            let point = p.ray(x, y) + p.origin * w;
            if point.z <= 0.0 {
                return None;
            }
            let r = 1.0 / point.z;
            let (u, v) = (point.x * r - 0.5, point.y * r - 0.5);
            let expected = w * r;
            if !(u > -1.0 && v > -1.0 && u < view.width as f32 && v < view.height as f32) {
                return None;
            }
            let (x0, y0) = (u.floor(), v.floor());
            let (fx, fy) = (u - x0, v - y0);
            let limit = expected * tol * view.per_footprint;
            let (mut color, mut depth, mut total) = ([0.0_f32; 3], 0.0, 0.0);
            let mut valid = 0;
            for corner in 0..4 {
                let (dx, dy) = (corner & 1, corner >> 1);
                let share = (if dx == 1 { fx } else { 1.0 - fx }) * (if dy == 1 { fy } else { 1.0 - fy });
                let Some(tap) = self.tap(view, x0 as i32 + dx, y0 as i32 + dy) else { continue };
                if (tap.depth - expected).abs() > limit {
                    continue;
                }
                valid += 1;
                total += share;
                depth += share * tap.depth;
                for k in 0..3 {
                    color[k] += share * tap.color[k];
                }
            }
            if total < 1e-3 {
                return None;
            }
            for k in 0..3 {
                color[k] /= total;
            }
            depth /= total;
            if pass < refine as usize {
                // The surface point that this camera saw there, carried into the target.
                let q = view.target_from_source.ray(u, v) + view.target_from_source.origin * depth;
                if q.z > 0.0 {
                    let new = depth / q.z;
                    w = new;
                }
                continue;
            }
            if false && cubic > 0.0 && valid == 4 {
                if let Some(c) = self.cubic(view, x0 as i32, y0 as i32, fx, fy, expected, limit) {
                    color = c;
                }
            }
            let s = (p.focal_ratio * r).min(cap);
            let ray = self.ray_origin + self.ray_x * x + self.ray_y * y;
            let vs = ray + view.center_offset * w;
            let cos = ray.dot(vs) / (ray.length() * vs.length());
            let edge_weight = 1.0;
            let weight = total * s.powf(rate_power) * cos.max(0.01).powf(angle_power) * edge_weight;
            result = Some((color, weight));
        }
        result
    }

    fn cubic(
        &self,
        view: &View,
        x0: i32,
        y0: i32,
        fx: f32,
        fy: f32,
        expected: f32,
        limit: f32,
    ) -> Option<[f32; 3]> {
        let a = -self.knobs[6];
        let k = |t: f32| -> [f32; 4] {
            let f = |d: f32| {
                let d = d.abs();
                if d < 1.0 {
                    ((a + 2.0) * d - (a + 3.0)) * d * d + 1.0
                } else {
                    a * (((d - 5.0) * d + 8.0) * d - 4.0)
                }
            };
            [f(t + 1.0), f(t), f(1.0 - t), f(2.0 - t)]
        };
        let (kx, ky) = (k(fx), k(fy));
        let mut color = [0.0; 3];
        for j in 0..4 {
            for i in 0..4 {
                let tap = self.tap(view, x0 + i as i32 - 1, y0 + j as i32 - 1)?;
                if (tap.depth - expected).abs() > 2.0 * limit {
                    return None;
                }
                for c in 0..3 {
                    color[c] += kx[i] * ky[j] * tap.color[c];
                }
            }
        }
        Some(color.map(|c: f32| c.max(0.0)))
    }

    /// Whether the cameras that would see the surface at `w` do: positive where they do, negative where they see through.
    fn support(&self, x: f32, y: f32, w: f32) -> Option<f32> {
        let [tol, rate_power, angle_power, cap, ..] = self.knobs;
        let (mut score, mut info) = (0.0_f32, 0.0_f32);
        for view in &self.views {
            let p = &view.source_from_target;
            let point = p.ray(x, y) + p.origin * w;
            if point.z <= 0.0 {
                continue;
            }
            let r = 1.0 / point.z;
            let (u, v) = (point.x * r, point.y * r);
            let expected = w * r;
            if !(u >= 0.0 && v >= 0.0 && u < view.width as f32 && v < view.height as f32) {
                continue;
            }
            let limit = expected * tol * view.per_footprint;
            let s = (p.focal_ratio * r).min(cap);
            let ray = self.ray_origin + self.ray_x * x + self.ray_y * y;
            let vs = ray + view.center_offset * w;
            let cos = ray.dot(vs) / (ray.length() * vs.length());
            let weight = s.powf(rate_power) * cos.max(0.01).powf(angle_power);
            let (u, v) = (u - 0.5, v - 0.5);
            let (x0, y0) = (u.floor(), v.floor());
            let (fx, fy) = (u - x0, v - y0);
            let (mut agree, mut through, mut depth) = (0.0, 0.0, 0.0);
            for corner in 0..4 {
                let (dx, dy) = (corner & 1, corner >> 1);
                let share = (if dx == 1 { fx } else { 1.0 - fx }) * (if dy == 1 { fy } else { 1.0 - fy });
                let Some(tap) = self.tap(view, x0 as i32 + dx, y0 as i32 + dy) else { continue };
                if (tap.depth - expected).abs() <= limit {
                    agree += share;
                    depth += share * tap.depth;
                } else if tap.depth < expected {
                    through += share;
                }
            }
            let mut vote = -through;
            if agree > 0.0 {
                let q = view.target_from_source.ray(u, v)
                    + view.target_from_source.origin * (depth / agree);
                let off = (q.x / q.z - x - 0.5).abs().max((q.y / q.z - y - 0.5).abs());
                vote += agree * (1.0 - self.reach * off).clamp(-1.0, 1.0);
            }
            score += vote * weight;
            info += (agree + through) * weight;
        }
        if info > 0.02 { Some(score / info) } else { None }
    }

    /// Nearer and farther surface at a pixel, and the share of the nearer.
    fn choose(&self, keys: &[u64], width: usize, x: usize, y: usize) -> Option<((u64, f32), (u64, f32), f32)> {
        let height = keys.len() / width;
        let own = keys[y * width + x];
        let at = |x: i64, y: i64| {
            if x < 0 || y < 0 || x >= width as i64 || y >= height as i64 { 0 } else { keys[y as usize * width + x as usize] }
        };
        let own_w = inverse_depth_of(own);
        let (mut near, mut far) = ((own, own_w), (own, own_w));
        if own == 0 {
            (near, far) = ((0, -1.0), (0, 1e30));
        }
        for dy in -1..=1_i64 {
            for dx in -1..=1_i64 {
                let key = at(x as i64 + dx, y as i64 + dy);
                if key == 0 || (dx == 0 && dy == 0) {
                    continue;
                }
                let mut w = inverse_depth_of(key);
                let beyond = at(x as i64 + 2 * dx, y as i64 + 2 * dy);
                if beyond != 0 && self.knobs[6] < 0.5 {
                    let d = w - inverse_depth_of(beyond);
                    if d.abs() < 0.1 * w {
                        w += d;
                    }
                }
                if w > near.1 {
                    near = (key, w);
                }
                if w < far.1 {
                    far = (key, w);
                }
            }
        }
        if near.0 == 0 || near.1 - far.1 <= near.1 * self.knobs[5] {
            return None;
        }
        let own_is_near = own != 0 && near.1 - own_w < own_w - far.1;
        if own != 0 {
            if own_is_near { near = (own, own_w) } else { far = (own, own_w) }
        }
        if !own_is_near {
            return None;
        }
        let share = match self.support(x as f32, y as f32, near.1) {
            Some(s) => (self.bias + 0.5 * self.sharp * (s + 1.0)).clamp(0.0, 1.0),
            None => if own_is_near { 1.0 } else { 0.0 },
        };
        Some((near, far, share))
    }

    fn surface_color(&self, x: usize, y: usize, w: f32, key: u64) -> ([f32; 3], f32) {
        let own = self.frame.color_of(slot_of(key));
        let (mut color, mut total) = ([0.0; 3], 0.0);
        for view in &self.views {
            if let Some((c, weight)) = self.view_color(view, x as f32, y as f32, w) {
                for k in 0..3 {
                    color[k] += c[k] * weight;
                }
                total += weight;
            }
        }
        let lack = (self.knobs[7] - total).max(0.0) * 0.2 + 1e-6;
        ([0, 1, 2].map(|k| (color[k] + own[k] * lack) / (total + lack)), total)
    }

    pub(super) fn gather(&self, keys: &[u64], width: usize) -> Vec<[f32; 3]> {
        let height = keys.len() / width;
        let dump = std::env::var("G_DUMP").is_ok();
        let records = std::sync::Mutex::new(Vec::<f32>::new());
        let mut colors = vec![[0.0_f32; 3]; keys.len()];
        colors.par_chunks_mut(width).enumerate().for_each(|(y, row)| {
            for (x, out) in row.iter_mut().enumerate() {
                let key = keys[y * width + x];
                if self.knobs[5] < 1.0
                    && let Some((near, far, share)) = self.choose(keys, width, x, y)
                {
                    if key == 0 && share < 0.5 {
                        continue;
                    }
                    let share = if self.knobs[6] == 1.0 { share.round() } else { share };
                    let (a, _) = self.surface_color(x, y, near.1, near.0);
                    let (b, _) = self.surface_color(x, y, far.1, far.0);
                    if dump {
                        let sup2 = self.support(x as f32, y as f32, far.1).unwrap_or(-9.0);
                        let rec = [x as f32, y as f32, near.1, far.1, share, sup2, a[0], a[1], a[2], b[0], b[1], b[2], inverse_depth_of(key)];
                        records.lock().unwrap().extend_from_slice(&rec);
                    }
                    *out = [0, 1, 2].map(|k| share * a[k] + (1.0 - share) * b[k]);
                    continue;
                }
                if key == 0 {
                    continue;
                }
                *out = self.surface_color(x, y, inverse_depth_of(key), key).0;
            }
        });
        if dump { let n = std::env::var("G_DUMP").unwrap(); let mut k = 0; while std::path::Path::new(&format!("{n}{k:02}")).exists() { k += 1; } std::fs::write(format!("{n}{k:02}"), bytemuck::cast_slice::<f32, u8>(&records.lock().unwrap())).unwrap(); }
        let _ = height;
        colors
    }
}
