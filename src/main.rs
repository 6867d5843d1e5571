//! The `overlook` command.

fn main() {}
