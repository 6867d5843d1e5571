//! The one settings struct that drives the command line, the sliders and the store's own record of how it was made.
//!
//! In TOML it reads
//!
//! ```toml
//! [pruning]
//! rate = "footprint"
//! depth_tolerance = 1.5
//! ```
//!
//! Every field's doc comment is also its help text (`overlook settings`, hover text). A missing field keeps its default; an unknown
//! one is an error, so that a misspelled threshold never passes in silence.

pub(crate) mod choice;
mod choices;
mod section;

use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};
use crate::whole_file;
pub use choices::{
    AgreementRule, Antialias, Backend, Coarse, Coding, Colormap, Correction, Fill, Kernel, Magnified,
    MixedPixels, NormalEstimator, NormalSource, Precision, PruningMethod, RateModel, SpanLevels, ValueScale,
};
use section::section;
pub use section::{Field, ValueKind};

section! {
    /// Reading the capture.
    pub struct CaptureSettings in "capture" {
        /// Memory for decoded frames that may be needed again, and for what preprocessing holds of all cameras. Where that takes more,
        /// it is worked on part by part, with temporary files, and the results are the same.
        memory: u32 = 1024, "MiB", ValueKind::Integer { min: 16, max: 65536 };
        /// The largest number of views that are read, spread evenly over all: many views of a moving camera repeat others. 0 reads all.
        views: u32 = 0, "views", ValueKind::Integer { min: 0, max: 4096 };
    }
}

impl CaptureSettings {
    /// The memory, bytes.
    pub(crate) fn memory_bytes(&self) -> usize {
        (self.memory as usize) << 20
    }

    /// Bytes of decoded frames that a capture keeps: half of the memory, as the other half is needed by what is made of them.
    pub(crate) fn frame_cache_bytes(&self) -> usize {
        self.memory_bytes() / 2
    }

    /// Bytes of frames without the pixels that edits remove that are kept.
    #[must_use]
    pub fn edited_cache_bytes(&self) -> usize {
        self.memory_bytes() / 4
    }
}

section! {
    /// What the rig got wrong, corrected before anything else.
    pub struct AlignSettings in "align" {
        /// Whether cameras are turned and moved so that they agree about where surfaces are. Views between them are moved alike where
        /// their error can be predicted.
        poses: Correction = Correction::Auto, "", ValueKind::Choice(Correction::NAMES);
        /// Whether a lens and a position of its own are found for the color camera, if the capture gives color those of depth. Views that
        /// claim the same lens are rendered through the one that was found.
        lens: Correction = Correction::Auto, "", ValueKind::Choice(Correction::NAMES);
        /// Whether colors are multiplied so that cameras agree about them: exposure and white balance. Views between them are exposed
        /// alike where their error can be predicted.
        exposure: Correction = Correction::Auto, "", ValueKind::Choice(Correction::NAMES);
        /// Whether cameras that lag or lead most others by whole frames are moved in time. Fractions of a frame are reported.
        clock: Correction = Correction::Auto, "", ValueKind::Choice(Correction::NAMES);
    }
}

impl AlignSettings {
    /// The capture as it claims to be.
    pub const OFF: Self = Self {
        poses: Correction::Off,
        lens: Correction::Off,
        exposure: Correction::Off,
        clock: Correction::Off,
    };
}

section! {
    /// Surface normals.
    pub struct NormalSettings in "normals" {
        /// Where normals come from.
        source: NormalSource = NormalSource::Auto, "", ValueKind::Choice(NormalSource::NAMES);
        /// How normals are estimated where none are given.
        estimator: NormalEstimator = NormalEstimator::Plane, "", ValueKind::Choice(NormalEstimator::NAMES);
        /// Two neighbors belong to one surface while their depths differ by less than this many pixel footprints.
        edge: f32 = 8.0, "footprints", ValueKind::Number { min: 1.0, max: 64.0, log: true };
    }
}

section! {
    /// Temporal redundancy: which pixels stay the same, and for how long.
    pub struct SpanSettings in "spans" {
        /// Which spans of frames a sample may live in.
        levels: SpanLevels = SpanLevels::Tree, "", ValueKind::Choice(SpanLevels::NAMES);
        /// A pixel is static while its color stays within this range over the span, beyond what noise explains.
        color_tolerance: f32 = 2.0, "8-bit steps", ValueKind::Number { min: 0.0, max: 64.0, log: false };
        /// A pixel is static while its depth stays within this relative range over the span, beyond what noise explains.
        depth_tolerance: f32 = 0.001, "relative", ValueKind::Number { min: 0.0, max: 0.1, log: true };
        /// How many times the measured noise is granted on top of the tolerances, over time and between cameras; 0 trusts the
        /// tolerances alone.
        noise: f32 = 1.0, "× measured", ValueKind::Number { min: 0.0, max: 4.0, log: false };
    }
}

section! {
    /// Spatial redundancy: which samples show the same surface point, and which of them stays.
    pub struct PruningSettings in "pruning" {
        /// Which of two samples of the same surface point stays.
        method: PruningMethod = PruningMethod::HighestRate, "", ValueKind::Choice(PruningMethod::NAMES);
        /// How the sampling rate of a pixel is measured.
        rate: RateModel = RateModel::Auto, "", ValueKind::Choice(RateModel::NAMES);
        /// Two samples show the same surface while one is this close to the other's tangent plane.
        depth_tolerance: f32 = 1.0, "footprints", ValueKind::Number { min: 0.05, max: 16.0, log: true };
        /// Two samples show the same surface while their normals differ by less than this.
        normal_tolerance: f32 = 30.0, "degrees", ValueKind::Number { min: 1.0, max: 90.0, log: false };
        /// Two samples show the same surface while their colors differ by less than this.
        color_tolerance: f32 = 48.0, "8-bit steps", ValueKind::Number { min: 1.0, max: 255.0, log: true };
        /// The cosine of incidence never counts as less than this: grazing views and poor normals stay comparable.
        cosine_floor: f32 = 0.1, "", ValueKind::Number { min: 0.01, max: 1.0, log: true };
        /// Whether a foreground sample may be dropped for a background sample that shows the same point.
        across_spans: bool = true, "", ValueKind::Switch;
        /// Whether a sample is dropped only where its witness's camera shows the surface on all four pixels around the
        /// point: what is left then overlaps by a pixel at depth edges, and can be interpolated there.
        overlap: bool = true, "", ValueKind::Switch;
        /// What happens to samples with a color blended across a silhouette. With agreement, also to samples with a depth in the air
        /// between the two sides of a silhouette.
        mixed_pixels: MixedPixels = MixedPixels::Yield, "", ValueKind::Choice(MixedPixels::NAMES);
        /// What becomes of samples that other cameras contradict because they see past them. Agreement also measures the noise between
        /// cameras, and grants it where it exceeds the tolerances.
        agreement: AgreementRule = AgreementRule::Majority, "", ValueKind::Choice(AgreementRule::NAMES);
        /// A sample is dropped if the cameras that contradict it outnumber those that confirm it, its own included, by at least this
        /// many.
        agreement_margin: u32 = 1, "cameras", ValueKind::Integer { min: 1, max: 64 };
    }
}

section! {
    /// The file that the kept samples are written to.
    pub struct StoreSettings in "store" {
        /// Whether normals are stored with the samples.
        normals: bool = false, "", ValueKind::Switch;
        /// How much of color and depth is kept.
        precision: Precision = Precision::Bits10, "", ValueKind::Choice(Precision::NAMES);
        /// Depth errs by no more than this where the precision is not lossless.
        depth_precision: f32 = 0.0625, "footprints", ValueKind::Number { min: 0.001, max: 1.0, log: true };
        /// How samples are coded.
        coding: Coding = Coding::Modeled, "", ValueKind::Choice(Coding::NAMES);
        /// What became of every pixel, and which camera replaces it, is stored where that takes at most this share beside the samples; 0 for
        /// never. The window explains pixels of a store by it.
        verdicts: f32 = 0.1, "of the samples' bytes", ValueKind::Number { min: 0.0, max: 4.0, log: false };
    }
}

section! {
    /// Rendering the kept samples from a viewpoint.
    pub struct RenderSettings in "render" {
        /// How samples become pixels.
        kernel: Kernel = Kernel::Gather, "", ValueKind::Choice(Kernel::NAMES);
        /// How pixels without any sample are filled.
        fill: Fill = Fill::PushPull, "", ValueKind::Choice(Fill::NAMES);
        /// Whether gaps between nearer surfaces show what is behind only where a camera has seen the line of sight free. Only kernels that
        /// interpolate test this.
        free_space: bool = true, "", ValueKind::Switch;
        /// Samples this close behind the nearest one belong to the same surface and are blended with it.
        depth_tolerance: f32 = 4.0, "footprints", ValueKind::Number { min: 0.1, max: 64.0, log: true };
        /// Cameras whose colors `gather` averages at each point where nothing was pruned; pruning leaves the sample of one.
        views: u32 = 2, "cameras", ValueKind::Integer { min: 1, max: 8 };
        /// How kernels that interpolate smooth what is finer than a pixel. Pictures in motion are never supersampled.
        antialias: Antialias = Antialias::Silhouettes, "", ValueKind::Choice(Antialias::NAMES);
        /// How a picture coarser than the recording is rendered if it is antialiased. The window renders from a pyramid while a view moves,
        /// whatever is chosen here.
        coarse: Coarse = Coarse::Average, "", ValueKind::Choice(Coarse::NAMES);
        /// How parts of a picture that are finer than any camera recorded are rendered, by kernels that interpolate.
        magnified: Magnified = Magnified::Upsampled, "", ValueKind::Choice(Magnified::NAMES);
        /// What renders.
        backend: Backend = Backend::Auto, "", ValueKind::Choice(Backend::NAMES);
    }
}

/// Everything that can be set.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct Settings {
    /// Reading the capture.
    pub capture: CaptureSettings,
    /// What the rig got wrong.
    pub align: AlignSettings,
    /// Surface normals.
    pub normals: NormalSettings,
    /// Temporal redundancy.
    pub spans: SpanSettings,
    /// Spatial redundancy.
    pub pruning: PruningSettings,
    /// The file.
    pub store: StoreSettings,
    /// Rendering.
    pub render: RenderSettings,
}

impl Settings {
    /// Every setting, section by section.
    pub fn fields() -> impl Iterator<Item = &'static Field> {
        let preprocessing = [NormalSettings::FIELDS, SpanSettings::FIELDS, PruningSettings::FIELDS];
        let all = [CaptureSettings::FIELDS, AlignSettings::FIELDS].into_iter().chain(preprocessing);
        all.chain([StoreSettings::FIELDS, RenderSettings::FIELDS]).flatten()
    }

    /// Reads settings from TOML text; `place` is named in errors.
    ///
    /// # Errors
    /// [`Error::Invalid`] for broken TOML, an unknown key, or a value out of range.
    pub fn from_toml(text: &str, place: &str) -> Result<Self> {
        let settings: Self = toml::from_str(text).map_err(|error| toml_error(&error, place, text))?;
        settings.validate(place)?;
        Ok(settings)
    }

    /// Reads settings from a TOML file.
    ///
    /// # Errors
    /// [`Error::Io`] where the file cannot be read, and as [`Settings::from_toml`].
    pub fn load(path: &Path) -> Result<Self> {
        let text = whole_file::short_text(path)?;
        Self::from_toml(&text, &path.display().to_string())
    }

    /// These settings as TOML.
    #[must_use]
    pub fn to_toml(&self) -> String {
        toml::to_string_pretty(self).unwrap_or_default()
    }

    /// The value at `path` (`pruning.rate`), or `None` where there is no such setting.
    #[must_use]
    pub fn get(&self, path: &str) -> Option<toml::Value> {
        let (section, name) = path.split_once('.')?;
        let table = toml::Table::try_from(self).ok()?;
        table.get(section)?.get(name).cloned()
    }

    /// Sets the value at `path` (`pruning.rate`).
    ///
    /// # Errors
    /// [`Error::Invalid`] where there is no such setting or it does not take this value; nothing is changed then.
    pub fn set(&mut self, path: &str, value: toml::Value) -> Result<()> {
        let place = format!("setting {path}");
        let field = Self::fields().find(|field| field.path == path).ok_or_else(|| {
            let names: Vec<_> = Self::fields().map(|field| field.path).collect();
            Error::invalid(&place, format!("there is no such setting; there are {}", names.join(", ")))
        })?;
        let value = match (field.kind, value) {
            (ValueKind::Number { .. }, toml::Value::Integer(whole)) => toml::Value::Float(whole as f64),
            (_, value) => value,
        };
        let mut table =
            toml::Table::try_from(&*self).map_err(|error| Error::invalid(&place, error.to_string()))?;
        if let Some((section, name)) = path.split_once('.')
            && let Some(toml::Value::Table(section)) = table.get_mut(section)
        {
            section.insert(name.to_owned(), value);
        }
        let changed: Self = table
            .try_into()
            .map_err(|error: toml::de::Error| Error::invalid(&place, error.message().to_owned()))?;
        changed.validate(&place)?;
        *self = changed;
        Ok(())
    }

    /// Sets from `key=value` text, as `--set` takes it. A bare word is taken as text.
    ///
    /// # Errors
    /// As [`Settings::set`], and where there is no `=`.
    pub fn set_text(&mut self, assignment: &str) -> Result<()> {
        let (path, text) = assignment.split_once('=').ok_or_else(|| {
            Error::invalid(
                format!("--set {assignment}"),
                "write it as key=value, as in pruning.rate=footprint",
            )
        })?;
        let value = text
            .trim()
            .parse::<toml::Value>()
            .unwrap_or_else(|_| toml::Value::String(text.trim().to_owned()));
        self.set(path.trim(), value)
    }

    /// Checks every number against its range.
    ///
    /// # Errors
    /// [`Error::Invalid`] naming the first setting out of range.
    pub fn validate(&self, place: &str) -> Result<()> {
        let table = toml::Table::try_from(self).map_err(|error| Error::invalid(place, error.to_string()))?;
        for field in Self::fields() {
            let Some((section, name)) = field.path.split_once('.') else { continue };
            let value = table.get(section).and_then(|section| section.get(name));
            let (number, min, max) = match (field.kind, value) {
                (ValueKind::Number { min, max, .. }, Some(toml::Value::Float(number))) => (*number, min, max),
                (ValueKind::Integer { min, max }, Some(toml::Value::Integer(whole))) => {
                    (*whole as f64, min as f64, max as f64)
                }
                _ => continue,
            };
            // Tolerances are f32: one unit in the last place either way is the same setting.
            let slack = 1e-6 * max.abs();
            if !(min - slack..=max + slack).contains(&number) {
                let what = format!(
                    "{} = {number} is out of range; it goes from {min} to {max} {}",
                    field.path, field.unit
                );
                return Err(Error::invalid(place, what));
            }
        }
        Ok(())
    }
}

/// What is wrong with TOML text, in one line, with line and column.
pub(crate) fn toml_error(error: &toml::de::Error, place: &str, text: &str) -> Error {
    let place = error.span().map_or_else(|| place.to_owned(), |at| line_and_column(place, text, at.start));
    Error::invalid(place, error.message().replace('\n', " "))
}

/// Line and character of the byte at `offset` of a text, both counted from 1.
fn line_and_column(place: &str, text: &str, offset: usize) -> String {
    let before = text.get(..offset).unwrap_or(text);
    let line = before.matches('\n').count() + 1;
    let column = before.chars().rev().take_while(|character| *character != '\n').count() + 1;
    format!("{place}, line {line}, column {column}")
}

impl Settings {
    /// Reads what is known here of settings as TOML text that another version may have written: the settings, and each of the text that
    /// this version does not have or whose value it does not take, as `section.name = value`. Those keep their defaults. `None` for broken
    /// TOML.
    #[must_use]
    pub fn known_from_toml(text: &str) -> Option<(Self, Vec<String>)> {
        let table: toml::Table = text.parse().ok()?;
        let (mut settings, mut unknown) = (Self::default(), Vec::new());
        for (section, values) in table {
            for (name, value) in values.as_table().cloned().unwrap_or_default() {
                let stated = format!("{section}.{name} = {value}");
                if settings.set(&format!("{section}.{name}"), value).is_err() {
                    unknown.push(stated);
                }
            }
        }
        Some((settings, unknown))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn settings_survive_toml() {
        let mut settings = Settings::default();
        settings.set_text("pruning.rate=footprint").unwrap();
        settings.set_text("pruning.depth_tolerance = 2").unwrap();
        settings.set_text("pruning.across_spans=false").unwrap();
        assert_eq!(settings.pruning.rate, RateModel::Footprint);
        assert!(!settings.pruning.across_spans);
        assert_eq!(Settings::from_toml(&settings.to_toml(), "test").unwrap(), settings);
    }

    #[test]
    fn a_misspelled_or_absurd_setting_is_refused_and_changes_nothing() {
        let mut settings = Settings::default();
        for text in [
            "pruning.rat=paper",
            "pruning.rate=papr",
            "pruning.depth_tolerance=-1",
            "pruning.depth_tolerance=nan",
            "nonsense",
            "capture.memory=1.5",
        ] {
            let error = settings.set_text(text).unwrap_err().to_string();
            assert!(!error.contains('\n'), "{error}");
        }
        assert_eq!(settings, Settings::default());
        let said = |text: &str| Settings::from_toml(text, "s.toml").unwrap_err().to_string();
        let unknown = said("[pruning]\n  rat = 1");
        assert!(unknown.starts_with("s.toml, line 2, column 3: unknown field `rat`"), "{unknown}");
        let broken = said("# Größe\n[pruning]\nmethod = ");
        assert!(broken.starts_with("s.toml, line 3, column ") && !broken.contains(['\n', '|']), "{broken}");
    }

    #[test]
    fn every_setting_can_be_read_and_has_help() {
        let settings = Settings::default();
        for field in Settings::fields() {
            assert!(settings.get(field.path).is_some(), "{}", field.path);
            assert!(field.help.len() > 10);
        }
    }

    #[test]
    fn a_value_that_is_not_known_costs_no_other_setting() {
        let text = "[pruning]\ndepth_tolerance = 2.0\n[render]\nfill = \"texture\"\nviews = 3\n";
        let (settings, unknown) = Settings::known_from_toml(text).unwrap();
        let mut expected = Settings::default();
        expected.pruning.depth_tolerance = 2.0;
        expected.render.views = 3;
        assert_eq!(settings, expected);
        assert_eq!(unknown, ["render.fill = \"texture\""]);
        assert_eq!(Settings::known_from_toml("[render"), None);
    }

    #[test]
    fn a_setting_that_was_a_switch_is_read_as_the_choice_that_it_became() {
        for (switch, expected) in [("true", Antialias::Silhouettes), ("false", Antialias::Off)] {
            let text = format!("[render]\nantialias = {switch}\n");
            let (settings, unknown) = Settings::known_from_toml(&text).unwrap();
            assert_eq!((settings.render.antialias, unknown), (expected, Vec::new()));
            assert_eq!(Settings::from_toml(&text, "test").unwrap(), settings);
            let mut set = Settings::default();
            set.set_text(&format!("render.antialias={switch}")).unwrap();
            assert_eq!(set, settings);
        }
        let error = Settings::default().set_text("render.free_space=sometimes").unwrap_err().to_string();
        assert!(error.contains("boolean"), "{error}");
    }

    #[test]
    fn all_settings_are_known_from_their_own_text() {
        let mut settings = Settings::default();
        settings.set_text("pruning.rate=footprint").unwrap();
        settings.set_text("render.views=3").unwrap();
        assert_eq!(Settings::known_from_toml(&settings.to_toml()), Some((settings, Vec::new())));
    }
}
