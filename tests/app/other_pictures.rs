//! Pictures that another program made of the same viewpoints, compared in the window.

use std::path::Path;

use overlook_engine::color::srgb_from_linear;
use overlook_engine::demo::{Demo, DemoSpec};

use super::driver::{
    SIZE, Window, choose, click, do_command, open, open_store, open_view, pick, save_store, settle, shows,
    small_demo, type_path, wait,
};
use egui_kittest::kittest::Queryable;

/// Writes the true pictures of the window's scene into a folder, red brighter by some steps that grow from frame to frame, one of
/// another size.
fn write_pictures(folder: &Path, growth: f32) {
    let demo = Demo::new(&DemoSpec::new("orrery").cameras(3).frames(4).size((96, 72))).unwrap();
    for view in demo.truth_views() {
        let frame = view.truth.as_ref().unwrap()().unwrap();
        let path = folder.join(view.file_path.replace(".exr", ".png"));
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        let brighter = 6.0 + growth * view.frame_number as f32;
        let is_smaller = view.file_path.starts_with("novel1/0001");
        let picture = image::RgbImage::from_fn(if is_smaller { 48 } else { 96 }, 72, |x, y| {
            let color =
                frame.color[(x as usize, y as usize)].map(|linear| 255.0 * srgb_from_linear(linear.to_f32()));
            image::Rgb(
                [color[0] + brighter, color[1], color[2]].map(|step| step.round().clamp(0.0, 255.0) as u8),
            )
        });
        picture.save(path).unwrap();
    }
}

/// Opens a folder of pictures by its path.
fn open_pictures(window: &mut Window, folder: &Path) {
    type_path(window, "Compare with pictures of another program", folder, "Load this path");
    window.hover_at(egui::pos2(5.0, 5.0));
    settle(window);
}

/// Picks an entry of a list, and leaves the pictures, over which the pointer asks for a pixel.
fn pick_away(window: &mut Window, list: &str, entry: &str) {
    pick(window, list, entry);
    window.hover_at(egui::pos2(5.0, 5.0));
    window.run_steps(3);
}

#[test]
fn pictures_of_another_program_are_compared_with_ours_and_with_the_truth() {
    let folder = tempfile::tempdir().unwrap();
    let rvs = folder.path().join("rvs");
    write_pictures(&rvs, 3.0);
    let mut window = open(small_demo(), SIZE);
    settle(&mut window);
    open_view(&mut window, "Compare");
    open_pictures(&mut window, &rvs);
    wait(&mut window, "the comparison", |window| shows(window, "dB, SSIM 0."));
    for mode in ["Wipe", "Flip", "Side by side", "Difference"] {
        choose(&mut window, "Compare by", mode);
        settle(&mut window);
        assert!(shows(&window, "of pixels covered on one side only"), "{mode}");
    }
    pick_away(&mut window, "Left side", "Truth");
    wait(&mut window, "their error", |window| shows(window, "PSNR 37.") || shows(window, "PSNR 36."));
    choose(&mut window, "Difference in", "Where");
    wait(&mut window, "the classes", |window| shows(window, "of the squared error unseen"));
    choose(&mut window, "Difference in", "Flicker");
    wait(&mut window, "the trouble", |window| shows(window, "there is none before this one"));
    pick_away(&mut window, "From", "True picture 3");
    // Red is three steps brighter than in the frame before: its mean square over three channels.
    wait(&mut window, "the flicker", |window| shows(window, "flicker 1.7") || shows(window, "flicker 1.6"));
    pick_away(&mut window, "From", "True picture 6");
    wait(&mut window, "the size", |window| {
        shows(window, "rvs has a picture of view 'novel1/0001.exr' of 48×72")
    });
    pick_away(&mut window, "From", "Camera left, held out");
    wait(&mut window, "the advice", |window| {
        shows(window, "rvs has pictures of viewpoints with true pictures alone")
    });
    click(&mut window, "Pictures of other programs");
    click(&mut window, "Close rvs");
    click(&mut window, "Right side");
    assert!(window.query_by_label("rvs").is_none());
    assert!(window.state().observed().notices.is_empty(), "{:?}", window.state().observed().notices);
}

#[test]
fn a_folder_without_pictures_of_the_viewpoints_and_a_store_say_so() {
    let folder = tempfile::tempdir().unwrap();
    let mut window = open(small_demo(), SIZE);
    settle(&mut window);
    open_view(&mut window, "Compare");
    open_pictures(&mut window, folder.path());
    let notices = window.state().observed().notices;
    assert!(
        notices.iter().any(|text| text.contains("has no picture of view 'novel0/0000.exr'")),
        "{notices:?}"
    );
    let path = save_store(&mut window, folder.path());
    open_store(&mut window, &path);
    open_view(&mut window, "Compare");
    do_command(&mut window, "Compare with pictures of another program");
    let notices = window.state().observed().notices;
    assert!(notices.iter().any(|text| text.contains("Nothing to compare pictures with")), "{notices:?}");
}
