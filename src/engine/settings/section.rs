//! One macro that declares a struct of settings whose doc comments are also its help text, and the table that sliders,
//! `--set` and `overlook settings` are made from.

/// What kind of value a setting takes, and its sensible range.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ValueKind {
    /// A number; sliders run from `min` to `max`, logarithmically where `log`.
    Number {
        /// Smallest value that is accepted.
        min: f64,
        /// Largest value that is accepted.
        max: f64,
        /// Whether a slider should be logarithmic.
        log: bool,
    },
    /// A whole number from `min` to `max`.
    Integer {
        /// Smallest value that is accepted.
        min: i64,
        /// Largest value that is accepted.
        max: i64,
    },
    /// Yes or no.
    Switch,
    /// One of several names, each with its help text.
    Choice(&'static [(&'static str, &'static str)]),
}

/// One setting: its name, its meaning, and the values that it takes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Field {
    /// Section and name, as in `pruning.rate`.
    pub path: &'static str,
    /// Unit of the value; empty if it has none.
    pub unit: &'static str,
    /// Help text.
    pub help: &'static str,
    /// What it takes.
    pub kind: ValueKind,
}

/// Declares a settings section: each field has a doc comment, a type, a default, a unit and a [`ValueKind`].
macro_rules! section {
    (
        $(#[$meta:meta])*
        pub struct $name:ident in $section:literal {
            $(
                $(#[doc = $doc:literal])+
                $field:ident: $type:ty = $default:expr, $unit:literal, $kind:expr;
            )+
        }
    ) => {
        $(#[$meta])*
        #[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
        #[serde(default, deny_unknown_fields)]
        pub struct $name {
            $(
                $(#[doc = $doc])+
                pub $field: $type,
            )+
        }

        impl Default for $name {
            fn default() -> Self {
                Self { $($field: $default),+ }
            }
        }

        impl $name {
            /// Every setting of this section.
            pub const FIELDS: &'static [$crate::settings::section::Field] = &[
                $($crate::settings::section::Field {
                    path: concat!($section, ".", stringify!($field)),
                    unit: $unit,
                    help: concat!($($doc),+),
                    kind: $kind,
                }),+
            ];
        }
    };
}

pub(crate) use section;
