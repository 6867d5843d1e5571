//! Polygons in pictures.

use glam::DVec2;

/// A closed polygon in image space, pixels, with its bounds.
#[derive(Clone, Debug)]
pub(super) struct Polygon {
    corners: Vec<DVec2>,
    least: DVec2,
    most: DVec2,
}

impl Polygon {
    pub(super) fn new(corners: &[[f64; 2]]) -> Self {
        let corners: Vec<DVec2> = corners.iter().copied().map(DVec2::from).collect();
        let least = corners.iter().copied().fold(DVec2::INFINITY, DVec2::min);
        let most = corners.iter().copied().fold(DVec2::NEG_INFINITY, DVec2::max);
        Self { corners, least, most }
    }

    /// The least and the largest coordinates of its corners; the first are larger than the second where it has none.
    pub(super) fn bounds(&self) -> [DVec2; 2] {
        [self.least, self.most]
    }

    /// Whether a point lies inside, by the number of sides that a ray to its right crosses.
    pub(super) fn contains(&self, point: DVec2) -> bool {
        if point.cmplt(self.least).any() || point.cmpgt(self.most).any() {
            return false;
        }
        let before = self.corners.last().into_iter().chain(&self.corners);
        let mut inside = false;
        for (a, b) in before.zip(&self.corners) {
            let crosses = (a.y > point.y) != (b.y > point.y);
            if crosses && point.x < a.x + (point.y - a.y) / (b.y - a.y) * (b.x - a.x) {
                inside = !inside;
            }
        }
        inside
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_polygon_with_a_notch_holds_what_is_within_its_sides() {
        let notched = [[0.0, 0.0], [4.0, 0.0], [4.0, 4.0], [2.0, 1.0], [0.0, 4.0]];
        let polygon = Polygon::new(&notched);
        let holds = |x: f64, y: f64| polygon.contains(DVec2::new(x, y));
        assert!(holds(0.5, 0.5) && holds(3.5, 2.5) && holds(2.0, 0.5));
        assert!(!holds(2.0, 2.0) && !holds(-0.5, 0.5) && !holds(4.5, 0.5) && !holds(2.0, 4.5));
        assert!(!Polygon::new(&[]).contains(DVec2::ZERO));
    }
}
