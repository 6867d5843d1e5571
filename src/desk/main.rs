//! The `overlook` program: the command line, and with no command the window.

fn main() -> std::process::ExitCode {
    env_logger::Builder::from_env(env_logger::Env::default().default_filter_or("error")).init();
    overlook::cli::run(overlook::app::run)
}
