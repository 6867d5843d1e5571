//! What is drawn in a picture: an outline, and strokes of a brush.

use glam::DVec2;

use super::region::Stroke;

/// A stroke with its bounds.
#[derive(Clone, Debug)]
struct StrokeShape {
    points: Vec<DVec2>,
    radius: f64,
    least: DVec2,
    most: DVec2,
}

impl StrokeShape {
    fn new(stroke: &Stroke) -> Self {
        let points: Vec<DVec2> = stroke.points.iter().copied().map(DVec2::from).collect();
        let least = points.iter().copied().fold(DVec2::INFINITY, DVec2::min) - stroke.radius;
        let most = points.iter().copied().fold(DVec2::NEG_INFINITY, DVec2::max) + stroke.radius;
        Self { points, radius: stroke.radius, least, most }
    }

    fn contains(&self, point: DVec2) -> bool {
        if point.cmplt(self.least).any() || point.cmpgt(self.most).any() {
            return false;
        }
        let reach = self.radius * self.radius;
        let starts = self.points.first().into_iter().chain(&self.points);
        starts.zip(&self.points).any(|(&start, &end)| {
            let along = end - start;
            let share = (point - start).dot(along) / along.length_squared();
            let nearest = if share.is_finite() { start + along * share.clamp(0.0, 1.0) } else { start };
            point.distance_squared(nearest) <= reach
        })
    }
}

/// All that is drawn, in image space, pixels.
#[derive(Clone, Debug)]
pub(super) struct DrawnArea {
    outline: Polygon,
    strokes: Vec<StrokeShape>,
}

impl DrawnArea {
    pub(super) fn new(outline: &[[f64; 2]], strokes: &[Stroke]) -> Self {
        let strokes = strokes.iter().map(StrokeShape::new).collect();
        Self { outline: Polygon::new(outline), strokes }
    }

    /// Whether a point lies within the outline or under a stroke.
    pub(super) fn contains(&self, point: DVec2) -> bool {
        self.outline.contains(point) || self.strokes.iter().any(|stroke| stroke.contains(point))
    }

    /// The least and the largest coordinates of what it holds; the first are larger than the second where it holds nothing.
    pub(super) fn bounds(&self) -> [DVec2; 2] {
        let [mut least, mut most] = self.outline.bounds();
        for stroke in &self.strokes {
            (least, most) = (least.min(stroke.least), most.max(stroke.most));
        }
        [least, most]
    }
}

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
    fn a_stroke_holds_what_is_within_its_radius_of_where_the_brush_went() {
        let stroke = Stroke { radius: 2.0, points: vec![[10.0, 10.0], [20.0, 10.0], [20.0, 20.0]] };
        let dot = Stroke { radius: 1.0, points: vec![[5.0, 30.0]] };
        let square = [[40.0, 0.0], [50.0, 0.0], [50.0, 10.0], [40.0, 10.0]];
        let area = DrawnArea::new(&square, &[stroke, dot]);
        let holds = |x: f64, y: f64| area.contains(DVec2::new(x, y));
        assert!(
            holds(15.0, 11.9)
                && holds(21.9, 15.0)
                && holds(8.1, 10.0)
                && holds(5.5, 30.5)
                && holds(45.0, 5.0)
        );
        assert!(!holds(15.0, 12.1) && !holds(7.9, 10.0) && !holds(18.6, 8.0 - 0.1) && !holds(6.1, 30.0));
        assert_eq!(area.bounds(), [DVec2::new(4.0, 0.0), DVec2::new(50.0, 31.0)]);
    }

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
