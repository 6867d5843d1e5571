//! Groups of neighboring views, each beside those before it.

use glam::DVec3;

use crate::capture::camera::Camera;

/// Some views by a measure, the nearest first; of equally near ones the first.
pub(crate) fn nearest_first(
    views: impl Iterator<Item = usize>,
    measure: impl Fn(usize) -> f64,
) -> Vec<usize> {
    let mut measured: Vec<(f64, usize)> = views.map(|view| (measure(view), view)).collect();
    measured.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    measured.into_iter().map(|(_, view)| view).collect()
}

/// Where views are, and what they look at.
pub(crate) struct Neighbors {
    of_view: Vec<[DVec3; 2]>,
}

impl Neighbors {
    /// Views that look at things `typical_depth` away.
    pub(crate) fn new(cameras: &[Camera], typical_depth: f64) -> Self {
        let of_view = |camera: &Camera| {
            let eye = camera.position_in_world();
            [eye, eye + typical_depth * camera.forward_in_world()]
        };
        Self { of_view: cameras.iter().map(of_view).collect() }
    }

    /// How far apart two views are: their positions, and the points that they look at.
    fn between(&self, a: usize, b: usize) -> f64 {
        let [a, b] = [a, b].map(|view| self.of_view[view]);
        a[0].distance(b[0]) + a[1].distance(b[1])
    }

    /// How far a view is from the nearest of some others.
    pub(crate) fn beside(&self, view: usize, others: &[usize]) -> f64 {
        others.iter().map(|other| self.between(*other, view)).fold(f64::INFINITY, f64::min)
    }

    /// All views in groups. The first begins at an end, each other one at the view nearest to those before it. The nearest
    /// views that are left come first: a group takes as many of them as `take` says, one at least.
    pub(crate) fn groups(&self, mut take: impl FnMut(&[usize]) -> usize) -> Vec<Vec<usize>> {
        let all = 0..self.of_view.len();
        // How far each view that is left is from all groups so far.
        let mut left: Vec<(usize, f64)> = all.clone().map(|view| (view, f64::INFINITY)).collect();
        let mut start = all.max_by(|a, b| self.between(0, *a).total_cmp(&self.between(0, *b)).then(b.cmp(a)));
        let mut groups = Vec::new();
        while let Some(first) = start {
            let mut group =
                nearest_first(left.iter().map(|(view, _)| *view), |view| self.between(first, view));
            group.truncate(take(&group).max(1));
            left.retain(|(view, _)| !group.contains(view));
            for (view, apart) in &mut left {
                *apart = apart.min(self.beside(*view, &group));
            }
            groups.push(group);
            start = left.iter().min_by(|a, b| a.1.total_cmp(&b.1)).map(|(view, _)| *view);
        }
        groups
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::capture::Intrinsics;

    fn lens() -> Intrinsics {
        Intrinsics::from_horizontal_angle(8, 8, 1.0)
    }

    #[test]
    fn views_along_a_way_come_in_groups_along_it_without_a_gap() {
        let place = |index: usize| index * 37 % 100;
        let camera = |index: usize| {
            let eye = DVec3::X * place(index) as f64;
            Camera::look_at(index.to_string(), lens(), eye, eye + DVec3::Y, DVec3::Z)
        };
        let cameras: Vec<Camera> = (0..100).map(camera).collect();
        let groups = Neighbors::new(&cameras, 3.0).groups(|_| 15);
        let mut all = groups.concat();
        all.sort_unstable();
        assert_eq!(all, (0..100).collect::<Vec<_>>(), "each is in one");
        assert_eq!(groups.iter().map(Vec::len).collect::<Vec<_>>(), [15, 15, 15, 15, 15, 15, 10]);
        let ends = groups.iter().map(|group| {
            let places = || group.iter().map(|view| place(*view));
            (places().min().unwrap(), places().max().unwrap())
        });
        let ends: Vec<(usize, usize)> = ends.collect();
        for (nth, group) in groups.iter().enumerate() {
            assert_eq!(ends[nth].1 - ends[nth].0, group.len() - 1, "without a gap: {group:?}");
        }
        for pair in ends.windows(2) {
            assert!(pair[0].1 + 1 == pair[1].0 || pair[1].1 + 1 == pair[0].0, "beside each other: {pair:?}");
        }
        assert_eq!(Neighbors::new(&cameras, 3.0).groups(|_| 0).len(), 100, "one at least");
    }

    #[test]
    fn views_from_one_place_are_told_apart_by_what_they_look_at() {
        let camera = |index: usize| {
            let angle = (index * 7 % 30) as f64 * 0.05;
            let target = DVec3::new(angle.cos(), angle.sin(), 0.0);
            Camera::look_at(index.to_string(), lens(), DVec3::ZERO, target, DVec3::Z)
        };
        let cameras: Vec<Camera> = (0..30).map(camera).collect();
        for group in Neighbors::new(&cameras, 2.0).groups(|_| 8) {
            let mut places: Vec<usize> = group.iter().map(|camera| camera * 7 % 30).collect();
            places.sort_unstable();
            assert!(places.windows(2).all(|pair| pair[1] - pair[0] == 1), "{places:?}");
        }
    }
}
