//! The splats of one frame as plain numbers in world space, for programs that hold them in memory.

use super::field::{Field, of_frame};
use super::options::SplatAmount;
use super::space::Space;
use crate::error::Result;
use crate::job::Job;
use crate::samples::SampleSet;

/// Flat Gaussians in world space, one entry of each list a splat.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SplatArrays {
    /// World units.
    pub center_in_world: Vec<[f64; 3]>,
    /// Unit quaternions `w x y z`, `w` not negative, from the axes of the Gaussian to those of the world; its third axis is the normal
    /// of the surface, on the side that was seen.
    pub rotation: Vec<[f32; 4]>,
    /// Standard deviations along its three axes, world units, above 0; the first is the longest, the third is along the normal.
    pub scale: Vec<[f32; 3]>,
    /// Linear Rec.709, 0 to 1.
    pub color: Vec<[f32; 3]>,
    /// 0 to 1.
    pub opacity: Vec<f32>,
}

/// The splats of a frame, by its index, in the order of the samples, then those of the sky; none where no sample has a place.
///
/// # Errors
/// `Invalid` where so few splats cannot be had; `Cancelled`.
pub fn arrays(set: &SampleSet, frame: usize, amount: SplatAmount, job: &Job) -> Result<SplatArrays> {
    let set = of_frame(set, frame);
    let mut arrays = SplatArrays::default();
    let has_place = set.images.iter().any(|image| image.placed_count() > 0);
    if !has_place {
        return Ok(arrays);
    }
    let field = Field::new(&set, Space::of_world(&set), amount, job)?;
    for span in &field.spans {
        for splat in field.splats(span, job)? {
            let center = splat.center.as_dvec3() + field.space.origin_in_world;
            let turned = splat.rotation;
            arrays.center_in_world.push(center.to_array());
            arrays.rotation.push([turned.w, turned.x, turned.y, turned.z]);
            arrays.scale.push(splat.radii.to_array());
            arrays.color.push(splat.color);
            arrays.opacity.push(splat.opacity);
        }
    }
    Ok(arrays)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::demo::{Demo, DemoSpec};
    use crate::preprocess::preprocess;
    use crate::settings::Settings;
    use crate::splats::SplatSky;

    #[test]
    fn splats_lie_at_the_samples_of_the_frame_and_fewer_are_had_where_fewer_are_asked_for() {
        let demo = Demo::new(&DemoSpec::new("orrery").size((96, 72)).cameras(2).frames(4)).unwrap();
        let settings = Settings::default();
        let set = preprocess(&demo.capture(&settings.capture), &settings, &Job::new()).unwrap().samples;
        let amount = SplatAmount { at_most: None, sky: SplatSky::Out };
        let found = arrays(&set, 2, amount, &Job::new()).unwrap();
        let images = set.images_at(2).filter(|image| !image.is_empty());
        let expected: Vec<_> =
            images.flat_map(|image| image.placed(&set.cameras[image.camera as usize])).collect();
        assert_eq!(found.center_in_world.len(), expected.len());
        for (center, placed) in found.center_in_world.iter().zip(&expected) {
            assert!((glam::DVec3::from(*center) - placed.point_in_world).length() < 1e-5);
        }
        let lengths = found.rotation.iter().map(|q| q.iter().map(|part| part * part).sum::<f32>());
        assert!(lengths.into_iter().all(|length| (length - 1.0).abs() < 1e-5));
        assert!(found.scale.iter().all(|[longer, shorter, flat]| longer >= shorter && shorter > flat));
        let half = expected.len() as u64 / 2;
        let few = arrays(&set, 2, SplatAmount { at_most: Some(half), ..amount }, &Job::new()).unwrap();
        assert!(few.opacity.len() as u64 <= half && few.opacity.len() > expected.len() / 8);
    }
}
