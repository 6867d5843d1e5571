//! One file per subcommand.

mod bench;
mod demo;
mod evaluate;
mod export;
mod info;
mod preprocess;
mod render;
mod settings;
mod stress;
mod sweep;
mod tune;
mod verify;

pub(crate) use bench::BenchArgs;
pub(crate) use demo::DemoArgs;
pub(crate) use evaluate::EvaluateArgs;
pub(crate) use export::ExportArgs;
pub(crate) use info::InfoArgs;
pub(crate) use preprocess::PreprocessArgs;
pub(crate) use render::RenderArgs;
pub(crate) use settings::SettingsCommandArgs;
pub(crate) use stress::StressArgs;
pub(crate) use sweep::SweepArgs;
pub(crate) use tune::TuneArgs;
pub(crate) use verify::VerifyArgs;
