//! The views of the window, a row each: what it is called in saved layouts, its name on its tab, what it shows, and the function of its room
//! that draws it.

/// Hands the rows to a macro that makes something of each.
macro_rules! views {
    ($take:ident) => {
        $take! {
            Source, "Source", "What a camera saw, and what became of each of its pixels.", source::ui::source_view_ui;
            Live, "Live view", "The kept samples, rendered from any viewpoint.", live::ui::live_view_ui;
            Compare, "Compare", "Two pictures of one place: before and after, two settings, the truth, kernels.", compare::ui::compare_view_ui;
            Pixel, "Pixel", "The explanation of one pixel, with the evidence of every camera.", pixel::ui::pixel_view_ui;
            Cameras, "Cameras", "Every camera with its kept share, and where it sees the pixel.", cameras::ui::cameras_view_ui;
            Time, "Time", "For how many frames samples are stored, and when.", timeline::ui::time_ui;
            Thresholds, "Settings", "What counts as redundant, and how what is left is rendered.", settings::ui::settings_ui;
            Report, "Report", "How many samples each rule pruned, for which cameras; how well cameras agree; memory.", report::ui::report_ui;
            Tradeoff, "Sweep", "What each setting costs, and how close it comes to the truth.", charts::ui::tradeoff_ui;
            Stability, "Stress test", "When accuracy breaks under disturbances.", charts::ui::stability_ui;
            Tuning, "Tuning", "The smallest settings that are good enough for this capture.", charts::ui::tuning::tuning_ui;
            View, "View", "The live view's lens, pose and guides, and the cameras whose samples it shows.", live::ui::panel::view_panel_ui;
            Color, "Color", "How both views show color: exposure, tone curve, channel, background; histograms.", colors::ui::color_panel_ui;
            Edits, "Edits", "Select samples by place, outline or evidence; delete them, keep them alone, leave cameras out.", edits::ui::edits_ui;
            Path, "Camera path", "A camera path: set keys, play it, export it as pictures.", path::ui::path_ui;
        }
    };
}
pub(crate) use views;
