//! Series of a chart: points that are drawn alike, each series with a shape of its own.

use crate::sweep::Series;

/// Shape of a marker.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Marker {
    /// A filled circle.
    Dot,
    /// A filled square.
    Square,
    /// A filled square on its corner.
    Diamond,
    /// A filled triangle that points up.
    Up,
    /// A filled triangle that points down.
    Down,
    /// Two strokes along the diagonals.
    Cross,
    /// Two strokes along the axes.
    Plus,
    /// A star of strokes.
    Star,
    /// A circle that is not filled.
    Ring,
}

impl Marker {
    /// The marker of a point of a sweep.
    #[must_use]
    pub fn of(series: Series) -> Self {
        match series {
            Series::Reference | Series::Variation => Self::Dot,
            Series::NoPruning | Series::TriangleMesh => Self::Up,
            Series::FirstCamera | Series::NearestCamera => Self::Down,
            Series::FirstCameraAtCount | Series::LayeredDepthImage => Self::Diamond,
            Series::Random => Self::Cross,
            Series::VoxelGrid | Series::Tsdf => Self::Square,
            Series::SingleCamera => Self::Plus,
            Series::Paper | Series::External => Self::Star,
        }
    }
}

/// Points of a chart that are drawn alike.
pub struct ChartSeries<'a, K, P> {
    /// What they have in common.
    pub kind: K,
    /// In the order given.
    pub points: Vec<&'a P>,
}

/// Groups points by their kind, kinds in the order in which they first come.
pub fn series<'a, K: PartialEq, P>(points: &'a [P], kind: impl Fn(&'a P) -> K) -> Vec<ChartSeries<'a, K, P>> {
    let mut all: Vec<ChartSeries<'a, K, P>> = Vec::new();
    for point in points {
        let kind = kind(point);
        match all.iter_mut().find(|series| series.kind == kind) {
            Some(series) => series.points.push(point),
            None => all.push(ChartSeries { kind, points: vec![point] }),
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_of_a_kind_are_one_series_in_the_order_given() {
        let all = series(&[3, 1, 5, 2], |number| number % 2);
        let all: Vec<_> = all.into_iter().map(|series| (series.kind, series.points)).collect();
        assert_eq!(all, [(1, vec![&3, &1, &5]), (0, vec![&2])]);
    }
}
