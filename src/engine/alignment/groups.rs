//! Groups of cameras that see the same, each beside those before it.

use crate::capture::Camera;

/// Cameras that are aligned together.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct CameraGroup {
    /// Those that no group before has, ascending.
    pub(super) new: Vec<usize>,
    /// Those of groups before that hold them where they are, ascending.
    pub(super) decided: Vec<usize>,
}

/// One camera of this many in a group is of those before it.
const DECIDED_SHARE: usize = 4;

/// How far apart two cameras are: their positions, and the points that they look at.
fn distance(cameras: &[Camera], typical_depth: f64, a: usize, b: usize) -> f64 {
    let looks_at = |camera: &Camera| camera.position_in_world() + typical_depth * camera.forward_in_world();
    let [a, b] = [a, b].map(|index| &cameras[index]);
    a.position_in_world().distance(b.position_in_world()) + looks_at(a).distance(looks_at(b))
}

/// The first `count` of some cameras by a measure.
fn first_by(mut cameras: Vec<usize>, count: usize, measure: impl Fn(usize) -> f64) -> Vec<usize> {
    cameras.sort_by(|a, b| measure(*a).total_cmp(&measure(*b)).then(a.cmp(b)));
    cameras.truncate(count);
    cameras.sort_unstable();
    cameras
}

/// Cuts cameras that look at things `typical_depth` away into groups of at most `most`. The first group is at an end; each other one
/// grows from the camera nearest to those before it.
pub(super) fn groups(cameras: &[Camera], typical_depth: f64, most: usize) -> Vec<CameraGroup> {
    let between = |a: usize, b: usize| distance(cameras, typical_depth, a, b);
    // How far each camera is from those that are decided; none while nothing is.
    let mut beside = vec![f64::INFINITY; cameras.len()];
    let mut is_decided = vec![false; cameras.len()];
    let all = || 0..cameras.len();
    let mut start = all().max_by(|a, b| between(0, *a).total_cmp(&between(0, *b)).then(b.cmp(a)));
    let mut groups = Vec::new();
    while let Some(first) = start {
        let count = if groups.is_empty() { most } else { most - most / DECIDED_SHARE };
        let left = all().filter(|camera| !is_decided[*camera]).collect();
        let new = first_by(left, count.max(1), |camera| between(first, camera));
        let nearest =
            |camera: usize| new.iter().map(|other| between(*other, camera)).fold(f64::INFINITY, f64::min);
        let known = all().filter(|camera| is_decided[*camera]).collect();
        let decided = first_by(known, most.saturating_sub(new.len()), nearest);
        for &camera in &new {
            is_decided[camera] = true;
        }
        for camera in all().filter(|camera| !is_decided[*camera]) {
            beside[camera] = beside[camera].min(nearest(camera));
        }
        groups.push(CameraGroup { new, decided });
        let left = all().filter(|camera| !is_decided[*camera]);
        start = left.min_by(|a, b| beside[*a].total_cmp(&beside[*b]).then(a.cmp(b)));
    }
    groups
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::capture::Intrinsics;

    #[test]
    fn cameras_along_a_way_come_in_groups_along_it_each_held_by_the_end_of_the_one_before() {
        let lens = Intrinsics::from_horizontal_angle(8, 8, 1.0);
        let place = |index: usize| index * 37 % 100;
        let camera = |index: usize| {
            let eye = DVec3::X * place(index) as f64;
            Camera::look_at(index.to_string(), lens, eye, eye + DVec3::Y, DVec3::Z)
        };
        let cameras: Vec<Camera> = (0..100).map(camera).collect();
        let groups = groups(&cameras, 3.0, 20);
        let mut all: Vec<usize> = groups.iter().flat_map(|group| group.new.clone()).collect();
        all.sort_unstable();
        assert_eq!(all, (0..100).collect::<Vec<_>>(), "each is new once");
        assert_eq!(
            groups.iter().map(|group| group.new.len()).collect::<Vec<_>>(),
            [20, 15, 15, 15, 15, 15, 5]
        );
        for pair in groups.windows(2) {
            let places = |cameras: &[usize]| cameras.iter().map(|camera| place(*camera)).collect::<Vec<_>>();
            let (new, decided) = (places(&pair[1].new), places(&pair[1].decided));
            let ends = |places: &[usize]| (*places.iter().min().unwrap(), *places.iter().max().unwrap());
            assert_eq!(ends(&new).1 - ends(&new).0, new.len() - 1, "without a gap: {new:?}");
            assert_eq!(decided.len(), 20 - new.len());
            let gaps = [(ends(&decided).0, ends(&new).1), (ends(&new).0, ends(&decided).1)];
            assert!(gaps.iter().any(|(above, below)| *above == below + 1), "{new:?} beside {decided:?}");
        }
    }

    #[test]
    fn cameras_that_stand_at_one_place_are_told_apart_by_what_they_look_at() {
        let lens = Intrinsics::from_horizontal_angle(8, 8, 1.0);
        let camera = |index: usize| {
            let angle = (index * 7 % 30) as f64 * 0.05;
            let target = DVec3::new(angle.cos(), angle.sin(), 0.0);
            Camera::look_at(index.to_string(), lens, DVec3::ZERO, target, DVec3::Z)
        };
        let cameras: Vec<Camera> = (0..30).map(camera).collect();
        for group in groups(&cameras, 2.0, 8) {
            let mut places: Vec<usize> = group.new.iter().map(|camera| camera * 7 % 30).collect();
            places.sort_unstable();
            assert!(places.windows(2).all(|pair| pair[1] - pair[0] == 1), "{places:?}");
        }
    }
}
