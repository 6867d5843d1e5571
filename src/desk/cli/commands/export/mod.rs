//! `overlook export`: what a store holds, in forms that other programs read.

mod cinema;
mod figure;
mod frame_files;
mod page;
mod path;
mod pictures;
mod points;
mod splats;
mod store;
mod video;

use clap::{Args, Subcommand};

use crate::cli::output::CommandError;
use overlook_engine::error::Result;

#[derive(Debug, Args)]
pub(crate) struct ExportArgs {
    #[command(subcommand)]
    what: ExportKind,
}

#[derive(Debug, Subcommand)]
enum ExportKind {
    /// Samples as binary PLY: points with normal, color and radius.
    Points(points::PointsArgs),
    /// Pictures along a camera path, as EXR and PNG.
    Pictures(pictures::PicturesArgs),
    /// A video along a camera path, as MP4.
    Video(video::VideoArgs),
    /// A figure for print: a picture with what its colors mean, a scale bar and a caption, as PDF, SVG or PNG.
    Figure(Box<figure::FigureArgs>),
    /// Pictures from many angles as an image database, which Cinema's viewers open: PNG, depth as EXR, and a table.
    Cinema(cinema::CinemaArgs),
    /// One HTML file that plays the scene from any viewpoint, in any browser and offline.
    Page(page::PageArgs),
    /// Samples as Gaussian splats, in formats that other viewers open: PLY, SPZ, glTF, USD.
    Splats(splats::SplatsArgs),
    /// The store again, with another precision or coding.
    Store(store::StoreArgs),
}

impl ExportArgs {
    pub(crate) fn run(self) -> Result<(), CommandError> {
        match self.what {
            ExportKind::Points(args) => args.run(),
            ExportKind::Pictures(args) => args.run(),
            ExportKind::Video(args) => args.run(),
            ExportKind::Figure(args) => args.run(),
            ExportKind::Cinema(args) => args.run(),
            ExportKind::Page(args) => args.run(),
            ExportKind::Splats(args) => args.run(),
            ExportKind::Store(args) => args.run(),
        }
    }
}
