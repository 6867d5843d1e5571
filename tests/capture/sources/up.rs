//! Up of captures whose files do not say it.

use glam::DVec3;

use super::*;

#[test]
fn up_of_a_list_of_poses_is_the_axis_nearest_to_the_mean_of_the_cameras_up() {
    let quarter = std::f64::consts::FRAC_PI_2;
    for (turn, up, name) in [
        (DAffine3::IDENTITY, DVec3::Z, "+z"),
        // As of trackers whose world is that of their first camera.
        (DAffine3::from_rotation_x(quarter), DVec3::NEG_Y, "−y"),
        (DAffine3::from_rotation_y(quarter), DVec3::X, "+x"),
        // Nearest to z still.
        (DAffine3::from_rotation_x(0.3 * quarter), DVec3::Z, "+z"),
    ] {
        let folder = Folder::new();
        let mut poses = String::new();
        for (step, camera) in cameras(LENS).iter().enumerate() {
            folder.put(&format!("color/{step}.png"), &color(camera, ImageFormat::Png));
            folder.put(&format!("depth/{step}.png"), &depth_png(camera, 1000.0));
            poses += &(text(&quaternion(&(turn * camera.world_from_camera))) + "\n");
        }
        folder.put("pose.txt", poses.as_bytes());
        let Intrinsics { fx, fy, cx, cy, .. } = LENS;
        let lens = format!("{fx} 0 {cx}\n0 {fy} {cy}\n0 0 1\n");
        folder.put("camera-intrinsics.txt", lens.as_bytes());
        let found = Source::find(&folder.path("")).unwrap();
        assert_eq!(found.open(&CaptureSettings::default()).unwrap().up_in_world, up);
        let said = found.description().lines().join("\n");
        assert!(said.contains(&format!("up is {name}, the axis nearest to the mean")), "{said}");
    }
}
