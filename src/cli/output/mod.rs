//! What commands write.

mod command_error;
mod output_guard;
mod picture;
mod process;
mod progress;
mod results;
mod score_table;
mod size_table;
mod text;

pub(crate) use command_error::CommandError;
pub(crate) use output_guard::{
    apart_from, apart_from_capture, apart_from_pictures_of, apart_from_stores, apart_from_views,
    can_be_read_again, file, folder,
};
pub(crate) use picture::PicturePaths;
pub(crate) use process::peak_rss_bytes;
pub(crate) use progress::{STOPPED, watched};
pub(crate) use results::{Journal, recorded, table, write_results};
pub(crate) use score_table::{comparison_table, painter_line, view_table};
pub(crate) use size_table::Sizes;
pub(crate) use text::{bytes, count, number, percent, print, print_json, tell, warn, without_depth};
