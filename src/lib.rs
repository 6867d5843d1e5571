//! Overlook: see, prune and explore animated scenes recorded as color and depth by several static cameras.
//!
//! The method, one stage a module, each importing only from those before it:
//!
//! 1. [`capture`]: what was recorded.
//! 2. [`preprocess`]: normals, spans in time, sampling rates, registration, pruning.
//! 3. [`store`]: the file of what is left.
//! 4. [`render`]: what is left, seen from anywhere.
//! 5. [`evaluate`]: how close to the truth that is, and what it costs.
//! 6. [`cli`] and [`app`]: the command line and the window over these same calls.

pub mod color;
pub mod error;
pub mod grid;
pub mod job;
pub mod settings;

pub mod capture;
pub mod evaluate;
pub mod preprocess;
pub mod render;
pub mod store;

pub mod app;
pub mod cli;
