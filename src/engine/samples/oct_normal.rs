//! Unit normals in two bytes.
//!
//! Source: Cigolle et al., *A Survey of Efficient Representations for Independent Unit Vectors*, JCGT 2014: project onto the
//! octahedron, unfold it to a square. What differs: both coordinates at −128 mean "no normal".

use glam::Vec3;

/// A unit normal in octahedral coordinates, two signed bytes; about one degree of precision.
///
/// Source: Cigolle et al., *A Survey of Efficient Representations for Independent Unit Vectors*, JCGT 2014.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
pub struct OctNormal(pub [i8; 2]);

const UNKNOWN: OctNormal = OctNormal([-128, -128]);

impl OctNormal {
    /// The nearest representable direction; a zero vector stays "unknown".
    pub(crate) fn encode(normal: Vec3) -> Self {
        let length = normal.x.abs() + normal.y.abs() + normal.z.abs();
        if length == 0.0 {
            return UNKNOWN;
        }
        let n = normal / length;
        let (x, y) = if n.z >= 0.0 {
            (n.x, n.y)
        } else {
            ((1.0 - n.y.abs()).copysign(n.x), (1.0 - n.x.abs()).copysign(n.y))
        };
        Self([x, y].map(|v| (v * 127.0).round().clamp(-127.0, 127.0) as i8))
    }

    /// The unit vector, or zero where unknown.
    #[must_use]
    pub fn decode(self) -> Vec3 {
        if self == UNKNOWN {
            return Vec3::ZERO;
        }
        let [x, y] = self.0.map(|v| f32::from(v) / 127.0);
        let z = 1.0 - x.abs() - y.abs();
        let fold = (-z).max(0.0);
        Vec3::new(x - fold.copysign(x), y - fold.copysign(y), z).normalize_or_zero()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_direction_survives_two_bytes_to_within_a_degree() {
        for i in 0..4000 {
            let (z, a) = (1.0 - 2.0 * (i as f32 + 0.5) / 4000.0, i as f32 * 2.399_963);
            let n = Vec3::new((1.0 - z * z).sqrt() * a.cos(), (1.0 - z * z).sqrt() * a.sin(), z);
            assert!(OctNormal::encode(n).decode().dot(n) > 0.9998, "{n}");
        }
        assert_eq!(OctNormal::encode(Vec3::ZERO).decode(), Vec3::ZERO);
    }
}
