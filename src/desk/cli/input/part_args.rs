//! Options of work that is cut into parts for several machines.

use clap::Args;

use overlook_engine::part::{MOST_PARTS, Part};

/// Which part of the work to do, or to put parts together.
#[derive(Debug, Args)]
pub(crate) struct PartArgs {
    /// Do one part of the work, as in `--part 2/6`: the second of six. Several machines can each do one. The part becomes one file
    /// beside the results, complete or not there at all.
    #[arg(long, value_name = "K/N", conflicts_with = "join")]
    pub(crate) part: Option<Part>,
    /// Put N parts together that --part made: the results are those of one piece of work. A part whose input has changed since is
    /// refused.
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..=i64::from(MOST_PARTS)))]
    pub(crate) join: Option<u32>,
}
