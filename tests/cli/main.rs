//! The command line: what each command prints, writes and refuses.

#[expect(dead_code, reason = "the builder serves other tests too")]
#[path = "../common/builder.rs"]
mod builder;
#[path = "../common/command.rs"]
mod command;
#[path = "../common/said.rs"]
mod said;
#[path = "../common/skip.rs"]
mod skip;

mod cinema_command;
mod commands;
mod edit_command;
mod export_command;
mod figure_command;
mod film_paths;
mod gpu_command;
mod page_command;
mod page_reader;
mod parts;
mod place_command;
mod preprocess_command;
mod preprocess_parts;
mod result_places;
mod splat_reader;
mod splats_command;
mod study_commands;
mod values_command;
mod video_command;
