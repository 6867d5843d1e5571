//! What the paper was written for: a molecular crystallization. A drop of molten salt condenses, layer by layer from a
//! seed, into a block of rock salt whose atoms are tied by bonds; six cameras, the last close to the seed; nothing
//! around but white.
//!
//! Atoms of the melt drift by sums of sines, so that any moment is known without the moments before it. Where that
//! brings two too close they are pushed apart (position-based dynamics: Matthias Müller et al., 2007).

use std::f64::consts::TAU;

use glam::{DVec3, Vec3};

use super::props::rgb;
use super::{SceneCameras, vantage};
use crate::demo::tracer::{Backdrop, Light, Material, WorldBuilder, sphere};
use crate::random::{mix, uniform_pair};

/// The middle of the block.
const CENTER: DVec3 = DVec3::new(0.0, 0.0, 1.0);
/// Atoms along x, y and z.
const SITES: [u32; 3] = [7, 6, 6];
/// Distance of neighbors in the lattice.
const SPACING_M: f64 = 0.2;
const LARGE_RADIUS_M: f64 = 0.4 * SPACING_M;
const SMALL_RADIUS_M: f64 = 0.25 * SPACING_M;
const BOND_RADIUS_M: f64 = 0.085 * SPACING_M;
/// The seed, from the middle of the block: on the face toward the cameras.
const SEED: DVec3 = DVec3::new(0.0, -2.5 * SPACING_M, 0.5 * SPACING_M);

/// Moments at which the seed and the site farthest from it begin to bind their atoms.
const FIRST_ARRIVAL: f64 = 0.08;
const LAST_ARRIVAL: f64 = 0.72;
/// How long an atom takes to its site, and a bond to grow once both of its atoms are there.
const SETTLING: f64 = 0.18;
const BONDING: f64 = 0.06;

/// How much wider than the block the melt is.
const EXPANSION: f64 = 1.1;
/// Numbers the melt's currents: some that drive no two atoms head-on, which would make them change places at once.
const CURRENTS: u64 = 6000;
/// How round the melt is, from 0, the block, to 1, an ellipsoid.
const ROUNDNESS: f64 = 0.45;
/// Atoms of the melt come no closer than this multiple of the sum of their radii.
const CONTACT: f64 = 1.05;
const SEPARATION_SWEEPS: usize = 12;

/// An atom and its place in the lattice.
struct Atom {
    /// From the middle of the block, m.
    site: DVec3,
    is_large: bool,
    /// Moment at which the crystal reaches its site.
    arrival: f64,
    /// Tells atoms apart.
    number: u64,
}

impl Atom {
    fn radius(&self) -> f64 {
        if self.is_large { LARGE_RADIUS_M } else { SMALL_RADIUS_M }
    }

    fn material(&self) -> Material {
        Material::plain(rgb(if self.is_large { 0x003c_74dc } else { 0x00e2_3a30 }))
    }

    /// How far the atom is out of the lattice's hold, from 1, the melt, to 0.
    fn freedom(&self, moment: f64) -> f64 {
        1.0 - eased((moment - self.arrival) / SETTLING)
    }
}

/// The scene at a moment, 0 to 1: molten at first, a crystal at the end.
pub(crate) fn stage(moment: f64) -> WorldBuilder {
    let mut stage = WorldBuilder::new(Light {
        to_sun: DVec3::new(-0.35, -0.72, 0.78).normalize_or_zero(),
        sun: Vec3::new(0.62, 0.59, 0.55),
        sun_spread: 0.08,
        zenith: Vec3::new(0.52, 0.54, 0.56),
        horizon: Vec3::new(0.5, 0.51, 0.53),
        ground: Vec3::new(0.38, 0.38, 0.4),
        backdrop: Backdrop::WHITE,
        contact: 0.12,
        lamp: None,
    });
    let atoms = atoms();
    let positions = positions(&atoms, moment);
    for (atom, position) in atoms.iter().zip(&positions) {
        stage.add(sphere(atom.radius()), CENTER + *position, atom.material());
    }
    // Last, as there are more of them from moment to moment: what comes before keeps its number.
    bonds(&mut stage, &atoms, &positions, moment);
    stage
}

/// All atoms, in the order of [`indices`].
fn atoms() -> Vec<Atom> {
    let middle = 0.5 * (DVec3::from(SITES.map(f64::from)) - DVec3::ONE);
    let jitter = 0.1 * SPACING_M;
    // The faces of rock salt are those of a cube, and stay so while it grows.
    let farthest = (SEED.abs() + SPACING_M * middle).max_element() + jitter;
    let atom = |(number, (x, y, z)): (u64, (u32, u32, u32))| {
        let site = SPACING_M * (DVec3::from([x, y, z].map(f64::from)) - middle);
        let from_seed = (site - SEED).abs().max_element() + jitter * uniform(number, 1);
        let arrival = FIRST_ARRIVAL + (LAST_ARRIVAL - FIRST_ARRIVAL) * from_seed / farthest;
        Atom { site, is_large: (x + y + z) % 2 == 0, arrival, number }
    };
    (0..).zip(indices()).map(atom).collect()
}

/// The sites by their numbers along x, y and z, z counting fastest.
fn indices() -> impl Iterator<Item = (u32, u32, u32)> {
    let [x_end, y_end, z_end] = SITES;
    (0..x_end).flat_map(move |x| (0..y_end).flat_map(move |y| (0..z_end).map(move |z| (x, y, z))))
}

/// Where the atoms are at a moment, from the middle of the block, m.
fn positions(atoms: &[Atom], moment: f64) -> Vec<DVec3> {
    let freedoms: Vec<f64> = atoms.iter().map(|atom| atom.freedom(moment)).collect();
    let placed = |(atom, freedom): (&Atom, &f64)| atom.site.lerp(molten(atom, moment), *freedom);
    let mut positions: Vec<DVec3> = atoms.iter().zip(&freedoms).map(placed).collect();
    separate(atoms, &freedoms, &mut positions);
    positions
}

/// Where an atom of the melt is, from the middle of the block, m.
fn molten(atom: &Atom, moment: f64) -> DVec3 {
    let half = SPACING_M * 0.5 * DVec3::from(SITES.map(f64::from));
    let share = atom.site / half;
    // A cube becomes a ball: Philip Nowell, *Mapping a Cube to a Sphere* (2005).
    let square = share * share;
    let (a, b) = (DVec3::new(square.y, square.z, square.x), DVec3::new(square.z, square.x, square.y));
    let round = (DVec3::ONE - 0.5 * (a + b) + a * b / 3.0).map(f64::sqrt);
    let rest = atom.site * DVec3::ONE.lerp(round, ROUNDNESS) * EXPANSION;
    rest + flow(atom.site, moment) + wobble(atom.number, moment)
}

/// What the melt's currents move a place by, m. They run across the waves they come in, which squeezes nothing.
fn flow(place: DVec3, moment: f64) -> DVec3 {
    (0..6_u64).fold(DVec3::ZERO, |sum, wave| {
        let wave = CURRENTS + wave;
        let random = |salt: u64| uniform(wave, salt);
        let along = unit(wave, 10);
        let across = along.cross(unit(wave, 20)).normalize_or_zero();
        let length = (4.0 + 4.0 * random(1)) * SPACING_M;
        let phase = random(2) + along.dot(place) / length + (0.5 + random(3)) * moment;
        sum + across * (0.38 * SPACING_M * (TAU * phase).sin())
    })
}

/// What an atom moves by on its own, m.
fn wobble(number: u64, moment: f64) -> DVec3 {
    (0..3_u64).fold(DVec3::ZERO, |sum, swing| {
        let phase = uniform(number, 30 + swing) + (1.0 + 3.0 * uniform(number, 40 + swing)) * moment;
        sum + unit(number, 50 + swing) * (0.18 * SPACING_M * (TAU * phase).sin())
    })
}

/// Pushes atoms apart that come too close, each as far as it is free; those of the lattice stay.
fn separate(atoms: &[Atom], freedoms: &[f64], positions: &mut [DVec3]) {
    let reach = |a: usize, b: usize| CONTACT * (atoms[a].radius() + atoms[b].radius());
    let mut pairs = Vec::new();
    for b in 0..atoms.len() {
        for a in 0..b {
            let near = positions[a].distance_squared(positions[b]) < (2.0 * reach(a, b)).powi(2);
            if near && freedoms[a] + freedoms[b] > 0.0 {
                pairs.push((a, b));
            }
        }
    }
    for _ in 0..SEPARATION_SWEEPS {
        for (a, b) in pairs.iter().copied() {
            let apart = positions[b] - positions[a];
            let missing = reach(a, b) - apart.length();
            if missing > 0.0 {
                let push = apart.normalize_or(DVec3::Z) * (missing / (freedoms[a] + freedoms[b]));
                positions[a] -= push * freedoms[a];
                positions[b] += push * freedoms[b];
            }
        }
    }
}

/// Bonds between neighbors: each atom grows its half, in its own color, until they meet midway between the surfaces.
fn bonds(stage: &mut WorldBuilder, atoms: &[Atom], positions: &[DVec3], moment: f64) {
    let [_, y_end, z_end] = SITES;
    let index = |x: u32, y: u32, z: u32| ((x * y_end + y) * z_end + z) as usize;
    for (x, y, z) in indices() {
        for (to_x, to_y, to_z) in [(x + 1, y, z), (x, y + 1, z), (x, y, z + 1)] {
            if to_x == SITES[0] || to_y == SITES[1] || to_z == SITES[2] {
                continue;
            }
            let ends = [index(x, y, z), index(to_x, to_y, to_z)];
            let arrival = atoms[ends[0]].arrival.max(atoms[ends[1]].arrival);
            let grown = ((moment - arrival - 0.8 * SETTLING) / BONDING).clamp(0.0, 1.0);
            if grown == 0.0 {
                continue;
            }
            let radii = ends.map(|end| atoms[end].radius());
            let between = positions[ends[1]] - positions[ends[0]];
            let visible = 0.5 * (between.length() - radii[0] - radii[1]);
            for (end, direction) in [(0, between.normalize_or_zero()), (1, -between.normalize_or_zero())] {
                let root = CENTER + positions[ends[end]];
                // The tip starts within the atom.
                let length = (radii[end] + visible) * grown + 0.9 * radii[end] * (1.0 - grown);
                let bar = (root, root + direction * length);
                stage.add_bar(bar, (BOND_RADIUS_M, BOND_RADIUS_M), atoms[ends[end]].material());
            }
        }
    }
}

/// 0 to 1 with a gentle start and end.
fn eased(share: f64) -> f64 {
    let t = share.clamp(0.0, 1.0);
    t * t * t * (t * (6.0 * t - 15.0) + 10.0)
}

/// A uniform number between 0 and 1 for a pair of numbers.
fn uniform(number: u64, salt: u64) -> f64 {
    f64::from(uniform_pair(mix(mix(number) ^ salt))[0])
}

/// A uniformly random direction for a pair of numbers.
fn unit(number: u64, salt: u64) -> DVec3 {
    let [up, turn] = uniform_pair(mix(mix(number) ^ salt)).map(f64::from);
    let z = 2.0 * up - 1.0;
    let (sin, cos) = (TAU * turn).sin_cos();
    DVec3::new(cos, sin, 0.0) * (1.0 - z * z).sqrt() + DVec3::Z * z
}

/// Six cameras before the block, the last close to the seed.
pub(crate) fn cameras() -> SceneCameras {
    let middle = CENTER.to_array();
    SceneCameras {
        cameras: vec![
            vantage("front", [0.3, -2.2, 1.3], middle, 50.0),
            vantage("left", [-1.2, -1.8, 1.45], middle, 50.0),
            vantage("right", [1.5, -1.6, 1.15], middle, 50.0),
            vantage("high", [0.5, -1.65, 2.4], middle, 50.0),
            vantage("low", [-0.75, -1.75, 0.1], middle, 50.0),
            vantage("seed", [-0.3, -1.2, 1.3], [0.02, -0.45, 1.06], 50.0),
        ],
        novel: vec![
            vantage("home", [1.1, -1.85, 1.55], middle, 50.0),
            vantage("novel1", [-0.8, -2.0, 1.1], middle, 50.0),
            vantage("novel2", [0.3, -1.25, 1.45], [0.05, -0.2, 1.0], 50.0),
        ],
        target: CENTER,
        distance: (1.7, 2.2),
        azimuth_deg: (-150.0, -30.0),
        elevation_deg: (-25.0, 45.0),
    }
}

#[cfg(test)]
mod tests {
    use super::{Atom, SITES, SPACING_M, atoms, positions, stage};
    use glam::DVec3;

    /// Positions at each frame of the recording.
    fn frames(atoms: &[Atom]) -> Vec<Vec<DVec3>> {
        (0..60).map(|frame| positions(atoms, f64::from(frame) / 60.0)).collect()
    }

    #[test]
    fn atoms_keep_their_distance_and_never_jump() {
        let atoms = atoms();
        let frames = frames(&atoms);
        for (frame, positions) in frames.iter().enumerate() {
            for (b, at_b) in positions.iter().enumerate() {
                for (a, at_a) in positions[..b].iter().enumerate() {
                    let touching = atoms[a].radius() + atoms[b].radius();
                    let apart = at_a.distance(*at_b) / touching;
                    assert!(apart > 0.97, "{a} and {b} at frame {frame}: {apart}");
                }
            }
        }
        for (frame, pair) in frames.windows(2).enumerate() {
            let step = pair[0].iter().zip(&pair[1]).map(|(a, b)| a.distance(*b)).fold(0.0, f64::max);
            assert!(step < 0.3 * SPACING_M, "{step} m after frame {frame}");
        }
    }

    #[test]
    fn the_crystal_stays_as_it_has_grown() {
        let atoms = atoms();
        let frames = frames(&atoms);
        assert!(atoms.iter().zip(&frames[0]).all(|(atom, position)| atom.site.distance(*position) > 0.0));
        for (atom, position) in atoms.iter().zip(&frames[59]) {
            assert_eq!(atom.site, *position);
        }
        let bonds = |[x, y, z]: [u32; 3]| (x - 1) * y * z + x * (y - 1) * z + x * y * (z - 1);
        let solids = |moment: f64| stage(moment).build().solids.len();
        assert_eq!(solids(0.0), atoms.len());
        assert_eq!(solids(59.0 / 60.0), atoms.len() + 2 * bonds(SITES) as usize);
    }
}
