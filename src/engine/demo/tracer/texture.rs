//! Procedural colors of surfaces, by the point in the solid's own space: wood, stone, bricks, planets, book spines.
//!
//! Source: value noise and its fractal sum as in David Ebert et al., *Texturing and Modeling* (1994). What differs:
//! every edge is softened over a fixed length on the surface and no octave is finer than [`FINEST_M`], whoever looks:
//! two cameras that see a point see the same color, and one sample per pixel does not alias badly.

use glam::{DVec3, Vec3};

/// Length of the finest detail, m: about one and a half pixels of the default cameras.
pub(crate) const FINEST_M: f32 = 0.006;

/// A surface's color: a pattern between two colors.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Material {
    /// What decides between the colors.
    pub(crate) pattern: Pattern,
    /// First color, linear Rec.709 reflectance.
    pub(crate) a: Vec3,
    /// Second color, linear Rec.709 reflectance.
    pub(crate) b: Vec3,
    /// Light the surface sends out by itself, as a multiple of its color.
    pub(crate) glow: f32,
}

/// How the two colors of a [`Material`] are laid out; lengths in meters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Pattern {
    /// The first color alone.
    Plain,
    /// Soft clouds of the given size.
    Clouds(f32),
    /// Squares of the given size on horizontal faces, with a thin joint and a little variation.
    Tiles(f32),
    /// Planks along x of the given width, with grain.
    Planks(f32),
    /// Growth rings around z, of the given width.
    Rings(f32),
    /// Veins, the given distance apart.
    Marble(f32),
    /// A brick wall in courses of the given height, on upright faces; the second color is mortar.
    Bricks(f32),
    /// Stone with grains.
    Speckles(f32),
    /// Bands along z with whirls: a gas planet of the given radius.
    Bands(f32),
    /// Land and sea with ice at the poles: a globe of the given radius.
    Continents(f32),
    /// Craters' light and dark on a ball of the given radius.
    Moon(f32),
    /// A book lying on its back with the given half thickness: cover, pages, and bands on the spine (−x).
    Book(f32),
    /// Concentric grooves around z.
    Grooves(f32),
    /// A woven rug with a border, of the given half width (x) and half depth (y).
    Rug(f32, f32),
    /// Coarse cloth with threads the given distance apart.
    Weave(f32),
    /// Stripes across z.
    Stripes(f32),
    /// A checkerboard in all three directions.
    Checker(f32),
}

impl Material {
    /// One color all over.
    pub(crate) fn plain(color: Vec3) -> Self {
        Self { pattern: Pattern::Plain, a: color, b: color, glow: 0.0 }
    }

    /// A pattern between two colors.
    pub(crate) fn new(pattern: Pattern, a: Vec3, b: Vec3) -> Self {
        Self { pattern, a, b, glow: 0.0 }
    }

    /// Linear reflectance at a point of the surface with the given outward normal, both in the solid's space.
    ///
    /// `seed` tells solids of one material apart.
    pub(crate) fn color(&self, point: DVec3, normal: DVec3, seed: u32) -> Vec3 {
        let p = point.as_vec3();
        let n = normal.as_vec3();
        let shift = Vec3::new(17.3, 5.1, 9.7) * (seed % 97) as f32;
        let mix = |t: f32| self.a.lerp(self.b, t.clamp(0.0, 1.0));
        match self.pattern {
            Pattern::Plain => self.a,
            Pattern::Clouds(size) => mix(fbm(p + shift, size)),
            Pattern::Tiles(size) => self.tiles(p, size),
            Pattern::Planks(width) => self.planks(p + Vec3::new(0.0, 0.0, 0.37), width, seed),
            Pattern::Rings(width) => mix(rings(p + shift.x * Vec3::Z, width)),
            Pattern::Marble(size) => {
                let bend = fbm(p + shift, size * 0.9) * 4.0;
                let wave = ((p.x + 0.6 * p.y + 0.8 * p.z) / size * 3.0 + bend * 2.2).sin().abs();
                mix((1.0 - wave).powi(3) * 0.9 + 0.25 * fbm(p + shift, size * 0.3))
            }
            Pattern::Bricks(height) => self.bricks(p, n, height),
            Pattern::Speckles(size) => {
                let grain = noise((p + shift) / size) + 0.6 * noise((p - shift) / (0.55 * size));
                mix(smoothstep(0.7, 1.25, grain) * 0.75 + 0.3 * fbm(p + shift, size * 8.0))
            }
            Pattern::Bands(radius) => {
                let whirl = fbm(Vec3::new(p.x, p.y, p.z * 3.0) + shift, radius * 0.7) - 0.5;
                let height = p.z / radius + 0.16 * whirl;
                mix(0.5 + 0.3 * (height * 11.0).sin() + 0.25 * (height * 23.0 + 1.0).sin())
            }
            Pattern::Continents(radius) => self.continents(p + shift, p.z / radius, radius),
            Pattern::Moon(radius) => {
                let maria = fbm(p + shift, radius * 0.9);
                mix(smoothstep(0.4, 0.65, maria) * 0.7 + 0.5 * noise((p + shift) / (0.22 * radius)).powi(3))
            }
            Pattern::Book(half_thickness) => self.book(p, n, half_thickness),
            Pattern::Grooves(width) => {
                let radius = p.truncate().length();
                mix(0.5 + 0.5 * (radius / width * std::f32::consts::TAU).sin())
            }
            Pattern::Weave(size) => {
                let turns = std::f32::consts::TAU / size;
                let thread = ((p.x + p.z) * turns).sin() * ((p.y - p.z) * turns).sin();
                mix(0.3 + 0.25 * thread + 0.4 * fbm(p + shift, 0.25))
            }
            Pattern::Rug(x, y) => self.rug(p, x, y),
            Pattern::Stripes(width) => mix(square_wave(p.z / width, FINEST_M / width)),
            Pattern::Checker(size) => {
                let soft = FINEST_M / size;
                let sign = [p.x, p.y, p.z].map(|v| 2.0 * square_wave(v / size + 0.25, soft) - 1.0);
                mix(0.5 + 0.5 * sign[0] * sign[1] * sign[2])
            }
        }
    }

    fn tiles(&self, p: Vec3, size: f32) -> Vec3 {
        let cell = (p / size).floor();
        let inside = p / size - cell;
        let edge = inside.x.min(1.0 - inside.x).min(inside.y.min(1.0 - inside.y)) * size;
        let shade = 0.86 + 0.28 * hash(cell.x as i32, cell.y as i32, 7);
        let checker = (cell.x as i32 + cell.y as i32).rem_euclid(2) as f32;
        let stone = self.a.lerp(self.b, 0.75 * checker) * shade * (0.9 + 0.2 * fbm(p, 0.22));
        stone.lerp(self.b * 0.42, 1.0 - smoothstep(0.003, 0.003 + FINEST_M, edge))
    }

    fn planks(&self, p: Vec3, width: f32, seed: u32) -> Vec3 {
        let row = (p.y / width).floor();
        let along = p.x + 0.83 * row;
        let plank = (along / (width * 9.0)).floor();
        let tone = hash(row as i32, plank as i32, seed as i32);
        let inside = p.y / width - row;
        let edge = inside.min(1.0 - inside) * width;
        let end = (along / (width * 9.0) - plank).min(1.0 - along / (width * 9.0) + plank) * width * 9.0;
        let q = p + Vec3::new(0.0, tone * 7.0, tone * 3.0);
        let grain = fbm(Vec3::new(q.x * 0.09, q.y, q.z), 0.035);
        let wave = 0.5 + 0.5 * (q.y * 90.0 + 9.0 * fbm(Vec3::new(q.x * 0.25, q.y, q.z), 0.25)).sin();
        let wood = self.a.lerp(self.b, (0.5 * grain + 0.25 * wave + 0.45 * (tone - 0.3)).clamp(0.0, 1.0));
        wood * (0.45 + 0.55 * smoothstep(0.0, 0.001 + FINEST_M, edge.min(end)))
    }

    fn bricks(&self, p: Vec3, n: Vec3, height: f32) -> Vec3 {
        // The coordinate along the wall: whichever of x and y the face does not look along.
        let along = if n.x.abs() > n.y.abs() { p.y } else { p.x };
        let up = if n.z.abs() > 0.7 { p.y } else { p.z };
        let course = (up / height).floor();
        let u = along / (height * 2.9) + 0.5 * course.rem_euclid(2.0);
        let brick = u.floor();
        let edge_u = (u - brick).min(1.0 - u + brick) * height * 2.9;
        let edge_v = (up / height - course).min(1.0 - up / height + course) * height;
        let tone = hash(brick as i32, course as i32, 3);
        let clay = self.a * (0.62 + 0.55 * tone) * (0.75 + 0.5 * fbm(p, 0.05));
        let warm =
            clay.lerp(Vec3::new(clay.x, clay.y * 0.8, clay.z * 0.75), hash(brick as i32, course as i32, 11));
        let mortar = self.b * (0.85 + 0.3 * fbm(p, 0.03));
        mortar.lerp(warm, smoothstep(0.004, 0.004 + FINEST_M, edge_u.min(edge_v)))
    }

    fn continents(&self, p: Vec3, latitude: f32, radius: f32) -> Vec3 {
        let height = fbm(p, radius * 0.85) + 0.25 * (fbm(p, radius * 0.25) - 0.5);
        let land = smoothstep(0.505, 0.53, height);
        let dry = Vec3::new(0.42, 0.3, 0.14);
        let ground = self.b.lerp(dry, smoothstep(0.52, 0.66, height) * (1.0 - latitude * latitude));
        let sea = self.a * (0.7 + 0.6 * smoothstep(0.3, 0.52, height));
        let ice = smoothstep(0.86, 0.93, latitude.abs() + 0.3 * (height - 0.5));
        sea.lerp(ground, land).lerp(Vec3::splat(0.78), ice)
    }

    fn book(&self, p: Vec3, n: Vec3, half_thickness: f32) -> Vec3 {
        let in_cover = p.z.abs() > half_thickness - 0.006;
        if n.x < -0.5 {
            let y = p.y.abs();
            let band = smoothstep(0.062, 0.068, y) * (1.0 - smoothstep(0.074, 0.08, y));
            let title = 1.0 - smoothstep(0.022, 0.028, y);
            return self.a.lerp(self.b, 0.75 * band + 0.4 * title) * (0.85 + 0.3 * fbm(p, 0.05));
        }
        if in_cover || n.z.abs() > 0.5 {
            return self.a * (0.85 + 0.3 * fbm(p, 0.06));
        }
        let leaf = 0.5 + 0.5 * (p.z * 700.0).sin();
        Vec3::new(0.72, 0.66, 0.52) * (0.82 + 0.12 * leaf)
    }

    fn rug(&self, p: Vec3, half_x: f32, half_y: f32) -> Vec3 {
        let edge = (half_x - p.x.abs()).min(half_y - p.y.abs());
        let soft = FINEST_M / 0.12;
        let diamond = square_wave((p.x.abs() + p.y.abs() * 1.5) / 0.24, soft);
        let cross = square_wave((p.x - p.y) / 0.12, soft) * square_wave((p.x + p.y) / 0.12, soft);
        let field = self.a.lerp(self.b, 0.75 * diamond).lerp(Vec3::new(0.55, 0.42, 0.2), 0.5 * cross);
        let border = self.b.lerp(self.a, square_wave(edge / 0.09, soft));
        let weave = 0.86 + 0.28 * noise(p / 0.009);
        field.lerp(border, 1.0 - smoothstep(0.14, 0.15, edge)) * weave
    }
}

fn rings(p: Vec3, width: f32) -> f32 {
    let bend = fbm(Vec3::new(p.x, p.y, p.z * 0.2), 0.25);
    let radius = p.truncate().length() + 0.06 * bend;
    let grain = noise(Vec3::new(p.x * 0.3, p.y, p.z * 0.1) / 0.012);
    0.55 * (0.5 + 0.5 * (radius / width * std::f32::consts::TAU).sin()) + 0.2 * grain + 0.25 * bend
}

/// 0 and 1 in turn, each half a unit long, with edges softened over `soft` units.
fn square_wave(x: f32, soft: f32) -> f32 {
    let phase = x - x.floor();
    let from_edge = 0.25 - (phase - 0.5).abs();
    smoothstep(-0.5 * soft, 0.5 * soft, from_edge)
}

pub(crate) fn smoothstep(low: f32, high: f32, x: f32) -> f32 {
    let t = ((x - low) / (high - low)).clamp(0.0, 1.0);
    t * t * (3.0 - 2.0 * t)
}

/// A uniform number in [0, 1) for a lattice point.
pub(crate) fn hash(x: i32, y: i32, z: i32) -> f32 {
    let mut h = (x as u32).wrapping_mul(0x8da6_b343)
        ^ (y as u32).wrapping_mul(0xd816_3841)
        ^ (z as u32).wrapping_mul(0xcb1a_b31f);
    h = (h ^ (h >> 15)).wrapping_mul(0x2c1b_3c6d);
    h = (h ^ (h >> 12)).wrapping_mul(0x297a_2d39);
    ((h ^ (h >> 15)) >> 8) as f32 / (1 << 24) as f32
}

/// Smooth noise with features one unit apart, 0 to 1.
pub(crate) fn noise(p: Vec3) -> f32 {
    let cell = p.floor();
    let f = p - cell;
    let w = f * f * (Vec3::splat(3.0) - 2.0 * f);
    let (x, y, z) = (cell.x as i32, cell.y as i32, cell.z as i32);
    let lerp = |a: f32, b: f32, t: f32| a + (b - a) * t;
    let row = |dy: i32, dz: i32| lerp(hash(x, y + dy, z + dz), hash(x + 1, y + dy, z + dz), w.x);
    lerp(lerp(row(0, 0), row(1, 0), w.y), lerp(row(0, 1), row(1, 1), w.y), w.z)
}

/// Fractal noise whose largest features are `size` meters apart, about 0 to 1; stops at [`FINEST_M`].
pub(crate) fn fbm(p: Vec3, size: f32) -> f32 {
    let (mut sum, mut weights, mut weight, mut scale) = (0.0, 0.0, 1.0, size);
    for octave in 0..4 {
        if octave > 0 && scale < 2.0 * FINEST_M {
            break;
        }
        sum += weight * noise(p / scale + Vec3::splat(31.7 * octave as f32));
        weights += weight;
        weight *= 0.5;
        scale *= 0.48;
    }
    sum / weights
}
