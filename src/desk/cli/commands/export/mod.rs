//! `overlook export`: what a store holds, in forms that other programs read.

mod cinema;
mod figure;
mod page;
mod path;
mod pictures;
mod samples;
mod splats;
mod store;

use clap::{Args, Subcommand};

use crate::cli::output::CommandError;
use crate::ways_out::{self, points};
use overlook_engine::error::Result;

#[derive(Debug, Args)]
pub(crate) struct ExportArgs {
    #[command(subcommand)]
    what: ExportKind,
}

#[derive(Debug, Subcommand)]
enum ExportKind {
    #[command(about = points::WAY.about)]
    Points(samples::SamplesArgs),
    #[command(about = ways_out::pictures::WAY.about)]
    Pictures(pictures::PicturesArgs),
    #[command(about = ways_out::film::WAY.about)]
    Video(pictures::VideoArgs),
    #[command(about = ways_out::figure::WAY.about)]
    Figure(Box<figure::FigureArgs>),
    /// Pictures from many angles as an image database, which Cinema's viewers open: PNG, depth as EXR, and a table.
    Cinema(cinema::CinemaArgs),
    #[command(about = ways_out::page::WAY.about)]
    Page(page::PageArgs),
    #[command(about = ways_out::splats::WAY.about)]
    Splats(splats::SplatsArgs),
    #[command(about = ways_out::store::WAY.about)]
    Store(store::StoreAgainArgs),
}

impl ExportArgs {
    pub(crate) fn run(self) -> Result<(), CommandError> {
        match self.what {
            ExportKind::Points(args) => args.run(&points::WAY),
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
