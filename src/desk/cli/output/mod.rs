//! What commands write.

mod command_error;
mod output_guard;
mod part_files;
mod picture;
mod process;
mod progress;
mod results;
mod score_table;
mod size_table;
mod study;
mod text;

pub(crate) use command_error::CommandError;
pub(crate) use output_guard::{
    check_file, check_folder, refuse_capture_files, refuse_input, refuse_store, refuse_true_pictures,
    refuse_view_files,
};
pub(crate) use part_files::{Inputs, OpenPart, PartFiles};
pub(crate) use picture::PicturePaths;
pub(crate) use process::peak_rss_bytes;
pub(crate) use progress::{STOPPED, export, watched};
pub(crate) use results::{Journal, recorded, sweep_table, write_results};
pub(crate) use score_table::{class_line, comparison_table, painter_line, picture_table, view_table};
pub(crate) use size_table::Sizes;
pub(crate) use study::{
    PAGE, SavedPicture, StressDocument, SweepDocument, ViewsDocument, command, save_picture, version,
    write_error_map, write_page,
};
pub(crate) use text::{
    bytes, count, count_of, cut_by_hand, percent, print, print_error, print_json, print_parts, warn,
    without_depth, wrote_pictures,
};
